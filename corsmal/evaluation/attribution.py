"""Which stage errors come from: estimates beside the same with one stage replaced by the truth."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from corsmal.dataset.annotation import CONTAINERS, DENSITIES_G_PER_ML, LEVEL_FRACTIONS
from corsmal.errors import ArgumentError
from corsmal.evaluation.bootstrap import RESAMPLES, Floats, draw_weights, interval, weighted_metric
from corsmal.evaluation.checking import truth_table
from corsmal.evaluation.estimates import ID_COLUMN, check_estimates, estimates_table
from corsmal.evaluation.metrics import CLASS_NAMES
from corsmal.evaluation.protocols import BY_NETWORKS, Protocol
from corsmal.evaluation.recordings import error_table
from corsmal.evaluation.tables import AVERAGE, METRICS, is_counted
from corsmal.quantities import BY_NAME, GEOMETRY

AS_IT_IS = "as it is"
"""The stage that stands for none: nothing is replaced."""

SMALL_POINTS = 5.0
"""Shortfalls below this, in percentage points, are given in points only: a share of them would say nothing."""

GROUPS = ("all", "seen", "unseen")
"""Of the containers: the demo's networks were trained on the annotated ones."""


_KEPT = [*CLASS_NAMES, "protocol", *(f"{stage}_{what}" for stage in BY_NETWORKS for what in ("weights", "held_out"))]
"""Columns that stay as they are when another stage is replaced."""

_COLUMNS = [
    *("container_id", "container", "metric", "recordings", "before", "after"),
    *("gone", "low", "high", "share", "share_low", "share_high"),
]


def attribution_table(
    estimates: pd.DataFrame,
    replaced: Mapping[str, pd.DataFrame],
    annotation: pd.DataFrame,
    *,
    rng: np.random.Generator,
    protocol: Protocol = "held-out",
    resamples: int = RESAMPLES,
) -> pd.DataFrame:
    """How much of each error goes away with each stage replaced by the truth.

    Only recordings that count both before and after are compared. Intervals are those of a paired bootstrap over
    recordings, whatever their container, so that there are some where each container was filmed once.

    Args:
        estimates: the estimates table of a run.
        replaced: the same by replaced stage, see ``corsmal.runs.attribution``; the filling and what the networks were
            trained on are taken from ``estimates``. The stage ``filling`` is added: its truth is annotated.
        annotation: a dataset's table, or the columns of the annotation file.
        rng: draws the recordings.
        protocol: which numbers of networks are judged, see ``error_table``.
        resamples: how many times, at least 100.

    Returns:
        A row per stage, container, ``Average`` last, and metric of Table 2: ``stage``, ``container_id``,
        ``container``, ``metric``, ``recordings`` (compared), ``before`` and ``after`` (the metric in %), ``gone`` with
        ``low`` and ``high``: by how many percentage points the shortfall became smaller, and its 95 % interval (NaN
        for one recording); ``share`` with ``share_low`` and ``share_high``: the same in % of the shortfall before,
        clipped to 0..100, NaN where that is below ``SMALL_POINTS``. The shortfall is the MAPE, or what MPF1 lacks
        to 100. What no recording has both before and after has no row.

    Raises:
        ArgumentError: a table has no ids, no recording in common with the annotation, or the protocol is unknown.
    """
    before = error_table(estimates, annotation, protocol=protocol)
    kept = estimates_table(estimates).set_index(ID_COLUMN)[_KEPT]
    tables = {
        stage: estimates_table(table).drop(columns=_KEPT).join(kept, on=ID_COLUMN) for stage, table in replaced.items()
    }
    tables["filling"] = with_true_filling(estimates, annotation)
    parts = []
    for stage, table in tables.items():
        if stage != AS_IT_IS:
            rows = _compared(before, error_table(table, annotation, protocol=protocol), rng, resamples)
            parts.append(pd.DataFrame(rows, columns=_COLUMNS).assign(stage=stage))
    found = pd.concat(parts, ignore_index=True)
    return found[["stage", *_COLUMNS]].astype({"container_id": "Int64"})


def _compared(
    before: pd.DataFrame, after: pd.DataFrame, rng: np.random.Generator, resamples: int
) -> list[dict[str, Any]]:
    """A row per container and metric, then those of the average, for one stage."""
    known = before.index[before["container_id"].notna()].intersection(after.index)
    before, after = before.loc[known], after.loc[known]
    weights = draw_weights(len(known), resamples=resamples, rng=rng) if len(known) else np.ones((1, 0))
    rows: list[dict[str, Any]] = []
    drawn: dict[str, list[tuple[int, Floats]]] = {metric: [] for metric in METRICS}
    for number, place in before.groupby("container_id").indices.items():
        sides = before.iloc[place], after.iloc[place]
        container = {"container_id": number, "container": sides[0]["container"].iloc[0] or f"container {number}"}
        for metric in METRICS:
            counts = (is_counted(sides[0], metric) & is_counted(sides[1], metric)).to_numpy()
            if count := int(counts.sum()):
                own = weights[:, place]
                values = np.array([weighted_metric(side, metric, own, counts=counts) for side in sides])
                rows.append(container | _summary(metric, count, values))
                drawn[metric].append((count, values))
    for metric, found in drawn.items():
        if found:
            values = _mean_over_containers(np.array([values for _, values in found]))
            average = {"container_id": pd.NA, "container": AVERAGE}
            rows.append(average | _summary(metric, sum(count for count, _ in found), values))
    return rows


def _mean_over_containers(values: Floats) -> Floats:
    """The mean of (containers, 2, m) values over the containers that a draw has: (2, m)."""
    is_there = np.isfinite(values).all(axis=1, keepdims=True)
    counts = is_there.sum(axis=0)
    sums = np.where(is_there, values, 0.0).sum(axis=0)
    means: Floats = np.divide(sums, counts, out=np.full(sums.shape, np.nan), where=counts > 0)
    return means


def _summary(metric: str, count: int, values: Floats) -> dict[str, Any]:
    """What (2, 1 + resamples) values of a metric, before and after, say; the first belong to the recordings as are."""
    shortfalls = values if metric.endswith("_mape") else 100 - values
    gone = shortfalls[0] - shortfalls[1]
    low, high = interval(gone, has_spread=count > 1)
    summary = {"metric": metric, "recordings": count, "before": values[0, 0], "after": values[1, 0]}
    summary |= {"gone": gone[0], "low": low, "high": high}
    if shortfalls[0, 0] < SMALL_POINTS:
        return summary | dict.fromkeys(("share", "share_low", "share_high"), np.nan)
    shares = np.divide(gone, shortfalls[0], out=np.full(gone.shape, np.nan), where=shortfalls[0] > 0)
    shares = np.clip(100 * shares, 0, 100)
    share_low, share_high = interval(shares, has_spread=count > 1)
    return summary | {"share": shares[0], "share_low": share_low, "share_high": share_high}


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
