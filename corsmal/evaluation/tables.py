"""The paper's tables and confusion matrices, from the error table of a run."""

from collections.abc import Mapping
from typing import get_args

import numpy as np
import pandas as pd

from corsmal.dataset.annotation import Kind
from corsmal.errors import ArgumentError, check_choice
from corsmal.evaluation.metrics import CLASS_NAMES, NO_ESTIMATE, confusion, mpf1
from corsmal.quantities import BY_METRIC, QUANTITIES

METRICS = {quantity.metric: quantity.error_column for quantity in QUANTITIES}
"""Table 2's metrics in order, all in %, and the error table's column behind each."""

AVERAGE = "Average"
KINDS: tuple[Kind, ...] = get_args(Kind)


def metric_of(errors: pd.DataFrame, metric: str) -> float:
    """One metric of Table 2 over some recordings.

    Args:
        errors: rows of ``error_table``.
        metric: a key of ``METRICS``.

    Returns:
        In %, over the judged recordings that have an estimate; for MPF1 a recording without an answer is a wrong one.
        NaN where there is nothing to compute it from.

    Raises:
        ArgumentError: it is no error table, or the metric is unknown.
    """
    column = _column_of(errors, metric)
    if column in CLASS_NAMES:
        known = is_judged(errors, metric)
        return mpf1(errors[f"{column}_true"][known], errors[column][known]) if known.any() else np.nan
    return float(errors[column].abs().mean())


def is_judged(errors: pd.DataFrame, metric: str) -> pd.Series:
    """Whether each recording counts for a metric: its truth is known and the protocol does not leave it out.

    A recording without an estimate counts as a failure. Args and errors are those of ``metric_of``.
    """
    column = _column_of(errors, metric)
    return errors[f"{column}_correct"].notna() if column in CLASS_NAMES else errors[f"{BY_METRIC[metric].name}_judged"]


def is_counted(errors: pd.DataFrame, metric: str) -> pd.Series:
    """Whether a metric is computed from each recording: those judged, for MAPE only if they have an estimate."""
    column = _column_of(errors, metric)
    return errors[f"{column}_correct" if column in CLASS_NAMES else column].notna()


def container_table(errors: pd.DataFrame) -> pd.DataFrame:
    """The paper's Table 2: MPF1 and MAPE of each container, in %, and how many recordings failed.

    Args:
        errors: from ``error_table``, or some of its rows.

    Returns:
        A row per container and the row ``Average``: ``container_id`` (NA for the average), ``container``, the columns
        of ``METRICS`` as ``metric_of`` (the average is the mean over the containers that have a number), the counts
        ``recordings`` and ``failures``, summed in the last row, and ``protocol``. Recordings of an unknown container
        are in no row.

    Raises:
        ArgumentError: it is no error table, or no recording's container is known.
    """
    rows = []
    for number, group in errors.groupby("container_id") if "container_id" in errors else ():
        name = group["container"].iloc[0] or f"container {number}"
        values = {metric: metric_of(group, metric) for metric in METRICS}
        counts = {"recordings": len(group), "failures": int(group["failed"].sum())}
        rows.append({"container_id": number, "container": name, **values, **counts})
    if not rows:
        raise ArgumentError("errors must be an error table with a recording whose container is known")
    table = pd.DataFrame(rows)
    last = {"container_id": pd.NA, "container": AVERAGE, **table[list(METRICS)].mean()}
    rows.append(last | {"recordings": table["recordings"].sum(), "failures": table["failures"].sum()})
    types = {"container_id": "Int64"} | dict.fromkeys(METRICS, "float64")
    return pd.DataFrame(rows).assign(protocol=errors["protocol"].iloc[0]).astype(types)


def recordings_behind(errors: pd.DataFrame, metric: str, *, container_id: int | None = None) -> pd.DataFrame:
    """The recordings that a cell of Table 2 is made from, the worst first.

    Args:
        errors: from ``error_table``.
        metric: a key of ``METRICS``, or ``failures`` for the recordings that failed.
        container_id: the row's container; None for the average, all containers.

    Returns:
        Those that count: without an answer first, then by falling error; of classes the wrong before the right.

    Raises:
        ArgumentError: it is no error table, or the metric is unknown.
    """
    rows = errors if container_id is None else errors[(errors["container_id"] == container_id).fillna(value=False)]
    if metric == "failures":
        return rows[rows["failed"]]
    column, rows = _column_of(errors, metric), rows[is_judged(rows, metric)]
    if column in CLASS_NAMES:
        order = rows[f"{column}_correct"].astype("int64").where(rows[column].notna(), -1)
        return rows.loc[order.sort_values(kind="stable").index]
    order = rows[column].abs().sort_values(ascending=False, na_position="first", kind="stable")
    return rows.loc[order.index]


def confusion_tables(errors: pd.DataFrame, quantity: str) -> dict[Kind, pd.DataFrame]:
    """The confusion matrices of ``filling_type`` or ``filling_level`` by kind of container (paper Fig. 3).

    Raises:
        ArgumentError: it is no error table, or the quantity is no class.
    """
    known = _is_known(errors, quantity)
    truth, predicted = errors[f"{quantity}_true"], errors[quantity]
    rows = {kind: known & (errors["kind"] == kind) for kind in KINDS}
    return {kind: confusion(truth[own], predicted[own], CLASS_NAMES[quantity]) for kind, own in rows.items()}


def recordings_confused(
    errors: pd.DataFrame, quantity: str, *, kind: Kind, true_class: int, predicted_class: int
) -> pd.DataFrame:
    """The rows of an error table that a cell of ``confusion_tables`` counts.

    ``true_class`` is the number of its row, ``predicted_class`` that of its column, −1 for no estimate.

    Raises:
        ArgumentError: it is no error table, or the quantity is no class.
    """
    known = errors[_is_known(errors, quantity)]
    is_there = known[f"{quantity}_true"].eq(true_class) & known[quantity].fillna(NO_ESTIMATE).eq(predicted_class)
    return known[is_there.astype("bool") & (known["kind"] == kind)]


def _column_of(errors: pd.DataFrame, metric: str) -> str:
    return _present(errors, "metric", metric, METRICS)


def _is_known(errors: pd.DataFrame, quantity: str) -> pd.Series:
    return errors[_present(errors, "quantity", quantity, {name: f"{name}_correct" for name in CLASS_NAMES})].notna()


def _present(errors: pd.DataFrame, what: str, choice: str, columns: Mapping[str, str]) -> str:
    """The column behind a choice."""
    check_choice(what, choice, columns)
    if columns[choice] not in errors:
        raise ArgumentError(f"errors must come from error_table: it has no column {columns[choice]!r}")
    return columns[choice]
