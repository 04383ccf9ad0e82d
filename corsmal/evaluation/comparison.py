"""Two runs on the same recordings: is the difference significant, and which estimates became right or wrong."""

from typing import Any

import numpy as np
import pandas as pd

from corsmal.errors import ArgumentError
from corsmal.evaluation.bootstrap import RESAMPLES, Floats, draw_weights, interval, weighted_metric
from corsmal.evaluation.metrics import CLASS_NAMES
from corsmal.evaluation.tables import AVERAGE, METRICS, is_counted

NO_DIFFERENCE = "no significant difference"


def compare_runs(
    first: pd.DataFrame, second: pd.DataFrame, *, rng: np.random.Generator, resamples: int = RESAMPLES
) -> pd.DataFrame:
    """Paired differences of Table 2's metrics between two runs, with bootstrap intervals.

    Only recordings that both runs have are compared; for MAPE, those for which both have an estimate. Within each
    container the same recordings are drawn for both runs, see ``draw_weights``. A single recording has no spread, and
    neither has an average over a container with one.

    Args:
        first: from ``error_table``.
        second: from ``error_table``, of another run on the same annotation.
        rng: draws the recordings.
        resamples: how many times, at least 100.

    Returns:
        A row per container and metric, then one per metric for ``Average``, the mean over containers:
        ``container_id``, ``container``, ``metric``, ``recordings`` (compared), ``first``, ``second`` (in %),
        ``difference`` (second − first, percentage points), ``low``, ``high`` (its 95 % interval, NaN without a
        spread), ``verdict`` on the second run: ``better`` or ``worse`` when the interval excludes 0, else ``no
        significant difference``; and ``protocol``. What one of the runs did not estimate has no row.

    Raises:
        ArgumentError: the runs have no recording of a known container in common, are judged by different protocols, or
            resamples is below 100.
    """
    first, second = _in_common(first, second)
    rows: list[dict[str, Any]] = []
    drawn: dict[str, list[tuple[int, Floats]]] = {metric: [] for metric in METRICS}
    for number, group in first.groupby("container_id"):
        known = {"container_id": number, "container": group["container"].iloc[0] or f"container {number}"}
        weights = draw_weights(len(group), resamples=resamples, rng=rng)
        sides = (group, second.loc[group.index])
        for metric in METRICS:
            counts = (is_counted(sides[0], metric) & is_counted(sides[1], metric)).to_numpy()
            values = np.array([weighted_metric(side, metric, weights, counts=counts) for side in sides])
            if count := int(counts.sum()):
                rows.append(known | {"metric": metric} | _summary(metric, count, values, has_spread=count > 1))
                drawn[metric].append((count, values))
    for metric, parts in drawn.items():
        if parts:
            mean = np.mean([values for _, values in parts], axis=0)
            compared = [count for count, _ in parts]
            summary = _summary(metric, sum(compared), mean, has_spread=min(compared) > 1)
            rows.append({"container_id": pd.NA, "container": AVERAGE, "metric": metric} | summary)
    if not rows:
        raise ArgumentError("first and second must have estimates of the same quantity for some recording in common")
    return pd.DataFrame(rows).assign(protocol=first["protocol"].iloc[0]).astype({"container_id": "Int64"})


def changed_sides(first: pd.DataFrame, second: pd.DataFrame, *, threshold_percent: float = 20.0) -> pd.DataFrame:
    """The recordings that one run gets right and the other wrong.

    Args:
        first: from ``error_table``.
        second: from ``error_table``, of another run on the same annotation.
        threshold_percent: a quantity is right when its error is at most this share of the truth, in %; without an
            estimate it is wrong.

    Returns:
        A row per recording and quantity that changed sides: ``recording_id``, ``container_id``, ``container``,
        ``metric``, ``first`` and ``second`` (the error with its sign in %, or the class, as text) and ``change``:
        ``better`` or ``worse`` in the second run. What one of the runs did not estimate at all is left out.

    Raises:
        ArgumentError: the runs have no recording of a known container in common, or the threshold is not positive.
    """
    if not threshold_percent > 0:
        raise ArgumentError(f"threshold_percent must be positive, got {threshold_percent}")
    first, second = _in_common(first, second)
    parts = []
    for metric, column in METRICS.items():
        if first[column].isna().all() or second[column].isna().all():
            continue
        sides = [_is_right(run, column, threshold_percent) for run in (first, second)]
        changed = (sides[0] != sides[1]).fillna(value=False).astype("bool")
        if not changed.any():
            continue
        before, after = first[changed], second[changed]
        part = before[["container_id", "container"]].reset_index()
        part["metric"], part["first"], part["second"] = metric, _shown(before, column), _shown(after, column)
        part["change"] = np.where(sides[1][changed].astype("bool"), "better", "worse")
        parts.append(part)
    columns = ["recording_id", "container_id", "container", "metric", "first", "second", "change"]
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=columns)


def _in_common(first: pd.DataFrame, second: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    for name, run in (("first", first), ("second", second)):
        if not isinstance(run, pd.DataFrame) or not {"container_id", "protocol", *METRICS.values()} <= set(run.columns):
            raise ArgumentError(f"{name} must be an error table, see error_table")
    protocols = [str(run["protocol"].iloc[0]) for run in (first, second) if len(run)]
    if len(set(protocols)) > 1:
        raise ArgumentError(f"first and second must be judged by the same protocol, got {' and '.join(protocols)}")
    known = first.index[first["container_id"].notna()].intersection(second.index)
    if known.empty:
        raise ArgumentError("first and second have no recording of a known container in common")
    return first.loc[known], second.loc[known]


def _summary(metric: str, count: int, values: Floats, *, has_spread: bool) -> dict[str, Any]:
    """One row of the comparison from (2, rows) values, the first of which belong to the recordings as they are."""
    differences = values[1] - values[0]
    low, high = interval(differences, has_spread=has_spread)
    gain = -1 if metric.endswith("_mape") else 1
    verdict = NO_DIFFERENCE
    if low > 0 or high < 0:
        verdict = "better" if gain * differences[0] > 0 else "worse"
    summary = {"recordings": count, "first": values[0, 0], "second": values[1, 0], "difference": differences[0]}
    return summary | {"low": low, "high": high, "verdict": verdict}


def _is_right(run: pd.DataFrame, column: str, threshold_percent: float) -> pd.Series:
    """Whether each recording is right; NA where that cannot be said."""
    if column in CLASS_NAMES:
        return run[f"{column}_correct"]
    return (run[column].abs() <= threshold_percent).astype("boolean")


def _shown(run: pd.DataFrame, column: str) -> list[str]:
    if column in CLASS_NAMES:
        return ["no estimate" if pd.isna(number) else CLASS_NAMES[column][int(number)] for number in run[column]]
    return ["no estimate" if pd.isna(error) else f"{error:+.1f} %" for error in run[column]]
