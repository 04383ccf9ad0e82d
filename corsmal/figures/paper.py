"""A figure as it stands on white paper: the theme's colours, without buttons, in colours or in grey."""

from typing import Any

import plotly.graph_objects as go

from corsmal.figures.grey import in_grey
from corsmal.figures.style import Part

FONT_PX = 13.0
"""Size of the pages' text: sizes in figures are meant beside it."""

INK, GRID = "#16212B", "#D9DFE5"
FONTS = "Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif"
COLOURS = ["#0068C9", "#E5484D", "#14B8A6", "#E69F00", "#7C6CF2", "#8A8F98"]
"""Of traces that name no colour of their own."""

_LINES = {"gridcolor": GRID, "linecolor": GRID, "zerolinecolor": GRID, "tickcolor": GRID}
_AXIS = {**_LINES, "automargin": True}
TEMPLATE: Part = {
    "layout": {
        "font": {"color": INK, "family": FONTS, "size": FONT_PX},
        "colorway": COLOURS,
        "paper_bgcolor": "#FFFFFF",
        "plot_bgcolor": "#FFFFFF",
        "hoverlabel": {"bgcolor": "#EEF2F5", "bordercolor": GRID, "font": {"color": INK}},
        "legend": {"bgcolor": "rgba(0,0,0,0)"},
        "margin": {"l": 56, "r": 16, "t": 32, "b": 48},
        "xaxis": _AXIS,
        "yaxis": _AXIS,
        "scene": {f"{name}axis": {**_LINES, "showbackground": False} for name in "xyz"},
        "updatemenudefaults": {"bgcolor": "#FFFFFF", "bordercolor": GRID, "font": {"color": INK, "size": 12}},
    }
}


def as_figure(figure: go.Figure | Part) -> go.Figure:
    """A figure from its parts, see ``corsmal.figures.drawing``."""
    return figure if isinstance(figure, go.Figure) else go.Figure(figure["data"], figure.get("layout"))


def on_paper(figure: go.Figure | Part, *, is_grey: bool = False, is_still: bool = True) -> dict[str, Any]:
    """A figure's ``data`` and ``layout`` as plain values, to be drawn on white paper.

    Args:
        figure: the figure, or the parts of a ``Drawing``.
        is_grey: whether it is drawn in greys, see ``in_grey``.
        is_still: whether it becomes a picture, see ``still``.
    """
    parts: dict[str, Any] = as_figure(figure).to_dict()
    parts.setdefault("layout", {}).update(template=TEMPLATE, paper_bgcolor="#FFFFFF", plot_bgcolor="#FFFFFF")
    shown = still(parts) if is_still else parts
    return in_grey(shown) if is_grey else shown


def still(parts: Part) -> dict[str, Any]:
    """A figure without what has no use in a picture: buttons, and traces that a click in the legend would show."""
    layout = {name: value for name, value in parts["layout"].items() if name != "updatemenus"}
    return {"data": [trace for trace in parts["data"] if trace.get("visible") != "legendonly"], "layout": layout}


def is_spatial(parts: Part) -> bool:
    """Whether a figure has a trace in space, which takes a browser's 3D graphics to draw."""
    return any(str(trace.get("type", "")).endswith("3d") for trace in parts["data"])
