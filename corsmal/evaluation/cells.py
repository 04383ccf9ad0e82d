"""Table 2 cell by cell: the number, its interval, what it counts, and the published number beside it."""

from typing import Any

import numpy as np
import pandas as pd

from corsmal.errors import ArgumentError
from corsmal.evaluation.bootstrap import RESAMPLES, Floats, draw_weights, interval, weighted_metric
from corsmal.evaluation.estimates import FAILED
from corsmal.evaluation.published import paper_table_2
from corsmal.evaluation.tables import AVERAGE, METRICS, is_counted, is_judged
from corsmal.quantities import BY_METRIC


def cell_table(errors: pd.DataFrame, *, rng: np.random.Generator, resamples: int = RESAMPLES) -> pd.DataFrame:
    """Table 2 with everything that belongs to a cell.

    Args:
        errors: from ``error_table``, or some of its rows.
        rng: draws recordings for the intervals, see ``draw_weights``.
        resamples: number of draws, at least 100.

    Returns:
        A row per container and metric, then one per metric for ``Average``:

        - ``protocol``, ``container_id`` (NA for the average), ``container``, ``metric``;
        - ``value`` (%, as in ``container_table``) with ``low`` and ``high``, its 95 % bootstrap interval (NaN for a
          single recording);
        - ``recordings`` (those that count), ``failures`` (of these, without an estimate of their own: a training mean
          or nothing) and ``left_out`` (by the protocol);
        - ``published`` (%, the paper's Table 2), ``difference`` (percentage points to it) and ``compared``, the number
          of containers behind the difference. An average is compared over the containers that both tables have a
          number for.

    Raises:
        ArgumentError: it is no error table, no recording's container is known, or resamples is below 100.
    """
    groups = errors.groupby("container_id") if "container_id" in errors else ()
    rows, draws = [], []
    for number, group in groups:
        weights = draw_weights(len(group), resamples=resamples, rng=rng)
        known = {"container_id": number, "container": group["container"].iloc[0] or f"container {number}"}
        for metric in METRICS:
            counts = is_counted(group, metric)
            values = weighted_metric(group, metric, weights, counts=counts.to_numpy())
            low, high = interval(values, has_spread=counts.sum() > 1)
            cell = {"metric": metric, "value": values[0], "low": low, "high": high}
            rows.append(known | cell | _counts(group, metric))
            draws.append(values)
    if not rows:
        raise ArgumentError("errors must be an error table with a recording whose container is known")
    table = pd.DataFrame(rows)
    paper = paper_table_2().set_index("container_id")[list(METRICS)]
    keys = zip(table["container_id"], table["metric"], strict=True)
    table["published"] = np.array([paper[metric].get(number, np.nan) for number, metric in keys], dtype=np.float64)
    table["difference"] = table["value"] - table["published"]
    table["compared"] = table["difference"].notna().astype("int64")
    averages = [
        _average(metric, table[own], np.array(draws)[own], paper[metric])
        for metric in METRICS
        if (own := (table["metric"] == metric).to_numpy()).any()
    ]
    table = pd.concat([table, pd.DataFrame(averages)], ignore_index=True)
    table.insert(0, "protocol", errors["protocol"].iloc[0])
    return table.astype({"container_id": "Int64"})


def comparison_note(cells: pd.DataFrame) -> str:
    """What the published averages are compared over, from ``cell_table``; empty where both have the same containers."""
    whole = paper_table_2()["container_id"].count()
    own = cells[cells["value"].notna() & cells["container_id"].notna()].value_counts(["protocol", "metric"])
    unlike: dict[str, dict[str, str]] = {}
    for row in cells[cells["container_id"].isna()].to_dict("records"):
        here = own.get((row["protocol"], row["metric"]), 0)
        if here and not row["compared"] == here == whole:
            text = f"{row['compared']} of {here}"
            unlike.setdefault(row["protocol"], {})[BY_METRIC[row["metric"]].label] = text
    if not unlike:
        return ""
    counts = "; ".join(f"{protocol}: {_counted(by_label)} containers" for protocol, by_label in unlike.items())
    return f"Averages are compared with the paper's over the containers that both tables have a number for ({counts})."


def _counted(by_label: dict[str, str]) -> str:
    texts = set(by_label.values())
    return texts.pop() if len(texts) == 1 else ", ".join(f"{label} {text}" for label, text in by_label.items())


def _counts(group: pd.DataFrame, metric: str) -> dict[str, int]:
    quantity, judged = BY_METRIC[metric], is_judged(group, metric)
    is_failed = group[quantity.error_column].isna()
    if not quantity.is_class:
        is_failed |= group["status"].isin(FAILED)
    out = int(group[f"{quantity.stage}_left_out"].sum()) if f"{quantity.stage}_left_out" in group else 0
    return {"recordings": int(judged.sum()), "failures": int((judged & is_failed).sum()), "left_out": out}


def _average(metric: str, cells: pd.DataFrame, draws: Floats, paper: pd.Series) -> dict[str, Any]:
    """The last row of a metric: over containers, and compared over those that the paper has too."""
    has_value = cells["value"].notna().to_numpy()
    sums = {name: cells[name].sum() for name in ("recordings", "failures", "left_out", "compared")}
    row: dict[str, Any] = {"container_id": pd.NA, "container": AVERAGE, "metric": metric, **sums}
    values = draws[has_value].mean(axis=0) if has_value.any() else np.full(draws.shape[1], np.nan)
    has_spread = bool(cells["low"][has_value].notna().all())
    row["value"], (row["low"], row["high"]) = values[0], interval(values, has_spread=has_spread)
    common = cells[cells["compared"] == 1]
    is_whole = len(common) == len(paper) - 1
    row["published"] = paper.iloc[-1] if is_whole else common["published"].mean()
    row["difference"] = common["value"].mean() - row["published"]
    return row
