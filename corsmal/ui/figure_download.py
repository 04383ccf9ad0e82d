"""Downloads of a figure for a paper or a talk: opened by the button on every figure, computed when asked for."""

import math
import re
from collections.abc import Mapping
from functools import partial
from typing import Any

import plotly.graph_objects as go
import streamlit as st

from corsmal.evaluation.escaping import csv_file
from corsmal.figures.data import figure_data
from corsmal.figures.export import FIGURE_FORMATS, NO_BROWSER, export_figure, find_browser
from corsmal.figures.paper import as_figure
from corsmal.figures.style import Part
from corsmal.ui.messages import guarded
from corsmal.ui.one_of import one_of

UNITS = {"mm": "mm, for paper", "px": "pixels, for a screen"}
WIDTHS = {"mm": 160, "px": 1600}
FONTS_PT = {"mm": 8.0, "px": 15.0}
COLOURS = {"colour": "as on the page", "grey": "grey"}
SIGNIFICANT = 6
"""Digits of the numbers in the CSV file."""


@st.dialog("Download figure")
def figure_dialog(figure: go.Figure | Part, *, name: str) -> None:
    """Choose how a figure is drawn, and download it or its numbers.

    Args:
        figure: as it is shown, its height set.
        name: of the figure, for people; the files are named after it.
    """
    stem = re.sub(r"\W+", "_", name).strip("_")[:60] or "figure"
    st.caption(name)
    with guarded():
        _picture(figure, stem)
    st.download_button(
        "Data (CSV)", partial(_csv, figure), f"{stem}.csv", key="figure_csv", icon=":material/table:", on_click="ignore"
    )


def _picture(figure: go.Figure | Part, stem: str) -> None:
    if find_browser() is None:
        st.info(NO_BROWSER, icon=":material/web_asset_off:")
        return
    file_format = one_of("Format", {each: each.upper() for each in FIGURE_FORMATS}, key="figure_format")
    unit = one_of("Width in", UNITS, key="figure_unit")
    left, right = st.columns(2)
    width = left.number_input(f"Width ({unit})", 20, 5000, WIDTHS[unit], key=f"figure_width_{unit}")
    font_pt = right.number_input("Text (pt)", 4.0, 40.0, FONTS_PT[unit], 0.5, key=f"figure_font_{unit}")
    colours = one_of("Colours", COLOURS, key="figure_colours")
    draw = partial(
        export_figure,
        figure,
        file_format=file_format,
        width_mm=float(width) if unit == "mm" else None,
        width_px=int(width) if unit == "px" else None,
        font_pt=float(font_pt),
        is_grey=colours == "grey",
    )
    st.download_button(
        f"Download {file_format.upper()}",
        draw,
        f"{stem}.{file_format}",
        key="figure_picture",
        icon=":material/download:",
        type="primary",
        on_click="ignore",
        help="Drawn when pressed, which takes a few seconds.",
    )


def _csv(figure: go.Figure | Part) -> bytes:
    table = figure_data(figure).map(
        lambda value: float(f"{value:.{SIGNIFICANT}g}") if isinstance(value, float) else value
    )
    return csv_file(table).encode()


def as_seen(figure: go.Figure | Part, view: Mapping[str, Any], *, height_px: int) -> go.Figure:
    """A figure as a browser shows it: turned, zoomed, and with the traces that are shown.

    Args:
        figure: the figure, or the parts of a ``Drawing``.
        view: from ``linked_plot.js``: ``cameras`` by scene, ``ranges`` by axis, ``visible`` by trace. What cannot be
            read is ignored: anyone who can reach the app can make one up.
        height_px: of the figure on the page.
    """
    seen = go.Figure(as_figure(figure)).update_layout(height=height_px)
    for scene, camera in _mapping(view, "cameras").items():
        parts = {name: _point(_mapping(camera, name)) for name in ("eye", "center", "up")}
        if re.fullmatch(r"scene\d*", scene) and all(parts.values()):
            seen.update_layout({scene: {"camera": parts}})
    for axis, ends in _mapping(view, "ranges").items():
        is_range = isinstance(ends, list) and len(ends) == 2 and all(map(_is_finite, ends))
        if is_range and re.fullmatch(r"[xy]axis\d*", axis):
            seen.update_layout({axis: {"range": ends}})
    visible = view.get("visible") if isinstance(view, Mapping) else None
    if isinstance(visible, list) and len(visible) == len(seen.data):
        for trace, shown in zip(seen.data, visible, strict=True):
            trace.visible = shown if shown in (True, False, "legendonly") else None
    return seen


def _mapping(value: Any, name: str) -> Mapping[str, Any]:
    found = value.get(name) if isinstance(value, Mapping) else None
    return found if isinstance(found, Mapping) else {}


def _point(value: Mapping[str, Any]) -> dict[str, float]:
    return {name: value[name] for name in "xyz"} if all(_is_finite(value.get(name)) for name in "xyz") else {}


def _is_finite(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)
