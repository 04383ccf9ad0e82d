"""The table of a dataset's recordings."""

from collections.abc import Iterable, Mapping

import pandas as pd
import streamlit as st

UNKNOWN = "unknown"
LACKS = {None: "all", "video": "with a video", "complete": "with nothing missing"}
"""Which recordings to list, by what is on disk."""
COLUMNS = {
    "picture": st.column_config.ImageColumn("", width="small"),
    "capacity_ml": st.column_config.NumberColumn("capacity (mL)", format="%.0f"),
    "width_top_mm": st.column_config.NumberColumn("top (mm)", format="%.0f"),
    "width_bottom_mm": st.column_config.NumberColumn("bottom (mm)", format="%.0f"),
    "height_mm": st.column_config.NumberColumn("height (mm)", format="%.0f"),
    "container_mass_g": st.column_config.NumberColumn("mass (g)", format="%.0f"),
    "missing": st.column_config.TextColumn("missing", width="medium"),
}
SCENARIOS = {0: "on the table", 1: "held", 2: "brought in"}


def recording_labels(table: pd.DataFrame) -> dict[str, str]:
    """Each recording in one line, by id: container, filling and level, as far as they are known."""
    known = (table[column].to_numpy(dtype=object, na_value="") for column in ("container", "filling", "level"))
    labels = {}
    for name, container, filling, level in zip(table.index.to_numpy(dtype=object), *known, strict=True):
        content = "empty" if filling == "none" else ", ".join(filter(None, (filling, level)))
        labels[name] = " · ".join(filter(None, (name, container, content)))
    return labels


def most_complete(table: pd.DataFrame) -> str:
    """The id of the first recording that lacks the least: what to show before anything was chosen."""
    return str(table["missing"].str.count(",").where(table["missing"] != "", -1).idxmin())


def recordings_table(table: pd.DataFrame) -> pd.DataFrame:
    """A dataset's table as people read it: names for numbers, ``unknown`` for what the annotation does not say.

    Args:
        table: ``Dataset.table``.

    Returns:
        Columns container, kind, filling, level, scenario, capacity_ml, width_top_mm, width_bottom_mm, height_mm,
        container_mass_g and missing, indexed by recording id.
    """
    shown = table[["container", "kind", "filling", "level"]].astype("string").fillna(UNKNOWN)
    shown["scenario"] = table["scenario"].map(SCENARIOS).astype("string").fillna(UNKNOWN)
    numbers = ["capacity_ml", "width_top_mm", "width_bottom_mm", "height_mm", "container_mass_g"]
    return shown.join(table[["missing", *numbers]])


def filter_table(shown: pd.DataFrame, *, chosen: Mapping[str, Iterable[str]], lacks: str | None = None) -> pd.DataFrame:
    """The rows whose columns hold one of the chosen values; an empty choice keeps all.

    Args:
        shown: from ``recordings_table``.
        chosen: values by column.
        lacks: a key of ``LACKS``.
    """
    keep = pd.Series(data=True, index=shown.index)
    for column, values in chosen.items():
        if values := list(values):
            keep &= shown[column].isin(values)
    missing = shown["missing"]
    if lacks == "complete":
        keep &= missing == ""
    elif lacks is not None:
        keep &= ~missing.str.contains("view1 video, view2 video, view3 video", regex=False)
    return shown[keep]
