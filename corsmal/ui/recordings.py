"""The table of a dataset's recordings, and its filters, which the recording picker follows."""

from collections.abc import Iterable, Mapping
from typing import Any

import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.ui import session

UNKNOWN = "unknown"
LACKS = {"all": "all", "video": "with a video", "complete": "with nothing missing"}
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
FILTERS = ("container", "filling", "level", "scenario")
LACKS_KEY, TABLE, SELECTED = "filter_lacks", "recordings_table", "recordings_selected"
NO_VIDEO = "view1 video, view2 video, view3 video"
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
    return shown.join(table[[*numbers, "missing"]])


def filter_table(shown: pd.DataFrame, *, chosen: Mapping[str, Iterable[str]], lacks: str = "all") -> pd.DataFrame:
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
    elif lacks == "video":
        keep &= missing.map(has_video)
    return shown[keep]


def has_video(missing: str) -> bool:
    """Whether a recording that lacks so much, a value of the column ``missing``, has any video of the fixed views."""
    return NO_VIDEO not in missing


def all_recordings(dataset: Dataset) -> pd.DataFrame:
    """``recordings_table`` of a dataset, made once per session."""
    of, shown = st.session_state.get(TABLE, (None, pd.DataFrame()))
    if of is not dataset:
        shown = recordings_table(dataset.table)
        st.session_state[TABLE] = dataset, shown
    return shown


def filter_controls(shown: pd.DataFrame) -> None:
    """The filters, which last as long as the session looks at one dataset."""
    *columns, last = st.columns(len(FILTERS) + 1)
    for column, name in zip(columns, FILTERS, strict=True):
        options = sorted(shown[name].unique())
        session.keep_among(name, options)
        key = f"filter_{name}"
        st.session_state[key] = [value for value in getattr(session.choice(), name) if value in options]
        column.multiselect(name.capitalize(), options, key=key, on_change=_filtered, args=(name, key))
    st.session_state[LACKS_KEY] = session.choice().lacks
    last.selectbox(
        "Recordings",
        list(LACKS),
        format_func=LACKS.__getitem__,
        key=LACKS_KEY,
        on_change=lambda: session.choose(lacks=st.session_state[LACKS_KEY]),
    )


def _filtered(name: str, key: str) -> None:
    chosen: dict[str, Any] = {name: tuple(st.session_state[key])}
    session.choose(**chosen)


def listed(dataset: Dataset) -> pd.DataFrame:
    """The rows of ``all_recordings`` that pass the session's filters."""
    shown, current = all_recordings(dataset), session.choice()
    chosen = {name: set(getattr(current, name)) & set(shown[name]) for name in FILTERS}
    return filter_table(shown, chosen=chosen, lacks=current.lacks)


def newly_clicked(selection: Any, *, key: str) -> int | None:
    """The row of a table that was clicked or ticked since the last run, which a later choice elsewhere outdates.

    Args:
        selection: what ``st.dataframe`` returns as such.
        key: of the table.
    """
    rows, cells = list(selection.rows), [row for row, _ in selection.cells]
    before = st.session_state.get(SELECTED)
    rows_before, cells_before = before[1:] if before is not None and before[0] == key else ([], [])
    st.session_state[SELECTED] = key, rows, cells
    if cells and cells != cells_before:
        return cells[0]
    return rows[0] if rows and rows != rows_before else None
