"""One colour for one thing, on every page and in both themes.

Figures are plain mappings in Plotly's own terms, see ``corsmal.figures.drawing``.
"""

from typing import Any

Part = dict[str, Any]
"""A trace or a layout, or part of one, in Plotly's own terms."""

VIEW_COLOURS = {"view1": "#E69F00", "view2": "#009E73", "view3": "#3B8EDE", "view4": "#8A8F98"}
CONTAINER = "#14B8A6"
HULL = "#5B8DEF"
RING = "#2F5BB7"
BESIDE = "#E69F00"
"""A hull that another one is compared with."""
PENALTY = "#D55E00"
BEST = "#CC79A7"
DROPPED = "#D55E00"
INSIDE = "#14B8A6"
OUTSIDE = "#E5484D"
TRUTH = "#8A8F98"
TOTAL = "#7C6CF2"
ADDED = "#FACC15"
AXIS = "#D946EF"
INPUT_COLOURS = ("#7C6CF2", "#0EA5E9", "#84A816", "#F472B6")
"""Top width, bottom width, height, and mm per pixel."""
SOUND = "#5B8DEF"
ATTENTION = "#CC79A7"

TYPE_COLOURS = {"none": "#A3ACB9", "pasta": "#E9B44C", "rice": "#8DB66B", "water": "#5AA9E6"}
LEVEL_COLOURS = {"empty": "#DAD3EE", "half": "#A58FDA", "full": "#6F4FC0"}
"""The levels are an order: the fuller, the darker."""

BRIGHT = 140
"""Of 255: on a colour that is lighter than this, text is dark."""


def rgb(colour: str) -> tuple[int, int, int]:
    """A ``#rrggbb`` colour as three bytes."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def text_on(colour: str) -> str:
    """A colour for text that can be read on a ``#rrggbb`` colour."""
    red, green, blue = rgb(colour)
    return "#16212B" if 0.3 * red + 0.59 * green + 0.11 * blue > BRIGHT else "#FFFFFF"


def plain_layout(**changes: object) -> Part:
    """The layout that all figures share: no title, tight margins, legend above, the theme's own background."""
    return {
        "margin": {"l": 60, "r": 12, "t": 34, "b": 46},
        "legend": {"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom"},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "hoverlabel": {"namelength": -1},
        **changes,
    }


def axis(title: str, **changes: object) -> Part:
    """An axis with a title."""
    return {"title": {"text": title}, **changes}
