"""What an attribution says, in a sentence per stage."""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from corsmal.evaluation.tables import AVERAGE
from corsmal.quantities import BY_METRIC

WITH_TRUE = {
    "masks": "With the true masks in all frames",
    "best frame": "With the frames that the true masks would have chosen",
    "dimensions": "With the annotated capacity, widths and height",
    "filling": "With the annotated filling",
}
"""What was replaced, as a sentence begins."""

STAGE_NAMES = {"masks": "Masks", "best frame": "Best frame", "dimensions": "Dimensions", "filling": "Filling"}
"""The stages, for people."""

SAME_POINTS = 0.05
"""A change that no number shows."""


def stage_sentences(table: pd.DataFrame, *, container: str = AVERAGE) -> dict[str, str]:
    """One sentence per stage: which errors become smaller when it is replaced by the truth, and by how much.

    Args:
        table: from ``attribution_table``.
        container: of whose rows; default: the average.

    Returns:
        Text by stage. A share of the error is given with its 95 % interval; where the error is small, both numbers
        only. A change counts where its interval excludes 0.
    """
    rows = table[table["container"] == container]
    return {str(stage): _sentence(str(stage), own) for stage, own in rows.groupby("stage", sort=False)}


def gone_text(row: Mapping[Any, Any]) -> str:
    """What goes away in a row of ``attribution_table``, briefly: a share, or points where the error is small."""
    if abs(row["gone"]) < SAME_POINTS:
        return "0"
    if pd.notna(row["share"]) and row["gone"] > 0:
        return f"{row['share']:.0f} %"
    return f"{-row['gone']:+.1f}".replace("-", "−")


def _sentence(stage: str, rows: pd.DataFrame) -> str:
    fall, grow, unclear, same = [], [], [], []
    for row in rows.to_dict("records"):
        label = _label(row["metric"])
        if abs(row["gone"]) < SAME_POINTS:
            same.append(label)
        elif not is_clear(row):
            unclear.append(label)
        elif row["gone"] > 0:
            fall.append(row)
        else:
            grow.append(row)
    fall.sort(key=lambda row: 0.0 if pd.isna(row["share"]) else -row["share"])
    parts = [_changes(own, verb) for own, verb in ((fall, "falls"), (grow, "grows")) if own]
    parts += [f"there is no clear change of {_listed(unclear)}"] if unclear else []
    parts += [f"nothing changes for {_listed(same)}"] if same else []
    return f"{WITH_TRUE.get(stage, stage)} {'; '.join(parts) or 'there is nothing to compare'}."


def is_clear(row: Mapping[Any, Any]) -> bool:
    """Whether the interval of what goes away excludes 0, in a row of ``attribution_table``."""
    return bool(row["low"] > 0 or row["high"] < 0)


def _changes(rows: list[dict[Any, Any]], verb: str) -> str:
    """Such as ``the error of mass falls from 24.1 to 10.2 % (58 % less; 95 % interval 41–70 %), that of …``."""
    first, *others = rows
    parts = [f"the error of {_label(first['metric'])} {verb} {_change(first)}"]
    return ", ".join([*parts, *(f"that of {_label(row['metric'])} {_change(row)}" for row in others)])


def _change(row: Mapping[Any, Any]) -> str:
    before, after = (row[name] if row["metric"].endswith("_mape") else 100 - row[name] for name in ("before", "after"))
    change = f"from {before:.1f} to {after:.1f} %"
    if pd.isna(row["share"]) or row["gone"] < 0:
        return change
    share, low, high = (round(row[name]) for name in ("share", "share_low", "share_high"))
    return f"{change} ({share} % less" + (")" if low == high else f"; 95 % interval {low}–{high} %)")


def _label(metric: str) -> str:
    quantity = BY_METRIC[metric]
    return f"filling {quantity.label.lower()} (100 − MPF1)" if quantity.is_class else quantity.label.lower()


def _listed(labels: list[str]) -> str:
    return labels[0] if len(labels) == 1 else f"{', '.join(labels[:-1])} and {labels[-1]}"
