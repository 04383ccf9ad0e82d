"""Which stage errors come from: estimates beside the same with one stage replaced by the truth."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from corsmal.dataset.annotation import CONTAINERS, DENSITIES_G_PER_ML, LEVEL_FRACTIONS
from corsmal.errors import ArgumentError
from corsmal.evaluation.checking import truth_table
from corsmal.evaluation.estimates import ID_COLUMN, check_estimates, estimates_table
from corsmal.evaluation.metrics import CLASS_NAMES
from corsmal.evaluation.protocols import BY_NETWORKS, Protocol
from corsmal.evaluation.recordings import error_table
from corsmal.evaluation.tables import METRICS, container_table
from corsmal.quantities import BY_NAME, GEOMETRY

AS_IT_IS = "as it is"
"""The stage that stands for none: nothing is replaced."""

GROUPS = ("all", "seen", "unseen")
"""Of the containers: the demo's networks were trained on the annotated ones."""


_KEPT = [*CLASS_NAMES, "protocol", *(f"{stage}_{what}" for stage in BY_NETWORKS for what in ("weights", "held_out"))]
"""Columns that stay as they are when another stage is replaced."""


def attribution_table(
    estimates: pd.DataFrame,
    replaced: Mapping[str, pd.DataFrame],
    annotation: pd.DataFrame,
    *,
    protocol: Protocol = "held-out",
) -> pd.DataFrame:
    """How much of each error goes away with each stage replaced by the truth.

    Args:
        estimates: the estimates table of a run.
        replaced: the same by replaced stage, see ``corsmal.runs.attribution``; the filling and what the networks were
            trained on are taken from ``estimates``. The stage ``filling`` is added: its truth is annotated.
        annotation: a dataset's table, or the columns of the annotation file.
        protocol: which numbers of networks are judged, see ``error_table``.

    Returns:
        A row per stage, ``as it is`` first, and container, ``Average`` last: ``stage``, ``container_id``,
        ``container``, and for every metric of Table 2 its value with that stage replaced (in %) and, with ``_removed``,
        the part of the shortfall that is gone, in %: 100 when nothing is left of it, negative when it grew. The
        shortfall is the MAPE, or what MPF1 lacks to 100. NaN where there was none, or no number.

    Raises:
        ArgumentError: a table has no ids, no recording in common with the annotation, or the protocol is unknown.
    """
    before = container_table(error_table(estimates, annotation, protocol=protocol))
    tables, kept = {AS_IT_IS: estimates}, estimates_table(estimates).set_index(ID_COLUMN)[_KEPT]
    for stage, table in replaced.items():
        tables[stage] = estimates_table(table).drop(columns=_KEPT).join(kept, on=ID_COLUMN)
    tables["filling"] = with_true_filling(estimates, annotation)
    parts = []
    for stage, table in tables.items():
        after = container_table(error_table(table, annotation, protocol=protocol)).set_index("container_id")
        after = after.reindex(before["container_id"]).reset_index(drop=True)
        part = before[["container_id", "container"]].copy()
        part.insert(0, "stage", stage)
        for metric in METRICS:
            old, new = (table[metric] if metric.endswith("_mape") else 100 - table[metric] for table in (before, after))
            part[metric] = after[metric]
            part[f"{metric}_removed"] = (100 * (old - new) / old.where(old > 0)).replace([np.inf, -np.inf], np.nan)
        parts.append(part)
    return pd.concat(parts, ignore_index=True)


def with_true_filling(estimates: pd.DataFrame, annotation: pd.DataFrame) -> pd.DataFrame:
    """Estimates with the annotated filling type and level, and the masses that follow from them.

    Returns:
        An estimates table of the recordings that both have; what the annotation does not know stays as estimated.

    Raises:
        ArgumentError: a table has no ids, or they have no recording in common.
    """
    known = truth_table(annotation)
    table = check_estimates(estimates, known.index).table
    table = table.assign(**{name: known.loc[table.index, name].fillna(table[name]) for name in CLASS_NAMES})
    table["filling_held_out"] = True  # the truth comes from no network
    fraction = table["filling_level"].map(dict(enumerate(LEVEL_FRACTIONS)))
    density = table["filling_type"].map(dict(enumerate(DENSITIES_G_PER_ML)))
    table["filling_mass_g"] = fraction * table["capacity_ml"] * density
    table["object_mass_g"] = table["container_mass_g"] + table["filling_mass_g"]
    return table.rename_axis(ID_COLUMN).reset_index()


def ablation_table(estimates: Mapping[tuple[str, str], pd.DataFrame], annotation: pd.DataFrame) -> pd.DataFrame:
    """How good the geometry is with different parameters, from detected and from true masks.

    Args:
        estimates: estimates tables by kind of masks and name of the parameters, see ``corsmal.runs.attribution``.
        annotation: a dataset's table, or the columns of the annotation file.

    Returns:
        By masks, parameters and containers (``GROUPS``): the MAPE of each quantity over the recordings in %, ``failed``
        (recordings that could not be fitted, which are in no mean), and ``QUANTITY inside``: the share of the truths
        inside their 90 % intervals, in %; NaN where there is none.

    Raises:
        ArgumentError: there is no table, or one has no recording in common with the annotation.
    """
    if not estimates:
        raise ArgumentError("estimates must hold at least one table, got none")
    truth, rows = truth_table(annotation), {}
    for (masks, name), table in estimates.items():
        errors = error_table(table, annotation)
        found, true = table.set_index(ID_COLUMN).loc[errors.index], truth.loc[errors.index]
        row = pd.DataFrame({name: abs(errors[BY_NAME[name].error_column]) for name in GEOMETRY})
        row["failed"] = row["capacity_ml"].isna()
        for quantity in GEOMETRY:
            low, high = (found.get(f"{quantity}_{end}", pd.Series(np.nan, found.index)) for end in ("low", "high"))
            is_inside = true[quantity].between(low.astype("float64"), high.astype("float64"))
            row[f"{quantity} inside"] = 100 * is_inside.astype("float64").where(low.notna() & true[quantity].notna())
        is_seen = errors["container_id"].isin(CONTAINERS)
        for group, part in zip(GROUPS, (row, row[is_seen], row[~is_seen]), strict=True):
            if len(part):
                rows[masks, name, group] = dict(part.mean(numeric_only=True)) | {"failed": int(part["failed"].sum())}
    table = pd.DataFrame.from_dict(rows, orient="index")
    table.index = pd.MultiIndex.from_tuples(rows, names=["masks", "preset", "containers"])
    return table.sort_index(level=["masks", "containers"], sort_remaining=False)
