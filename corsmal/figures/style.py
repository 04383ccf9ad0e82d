"""One colour for one thing, on every page and in both themes, and the traces that figures are made of.

Figures are plain mappings in Plotly's own terms, see ``corsmal.figures.drawing``.
"""

from typing import Any

Part = dict[str, Any]
"""A trace or a layout, or part of one, in Plotly's own terms."""

VIEW_COLOURS = {"view1": "#E69F00", "view2": "#009E73", "view3": "#3B8EDE", "view4": "#8A8F98"}
CONTAINER = "#14B8A6"
PRESET_COLOURS = {"paper": "#A0714F", "released": "#B4436C", "lode": "#7D8B2B", "tuned": "#6A5ACD"}
"""Of what was fitted with a preset: hulls, profiles, curves, runs. None is a view's."""
OWN_COLOUR = "#64748B"
"""Of what was fitted with parameters of no preset."""
RING = "#3F4A56"
TABLE = "#8A8F98"
ERROR_COLOURS = [[0.0, "#2166AC"], [0.5, "#F3F3F1"], [1.0, "#B2182B"]]
"""Of signed distances, from inside the true shape to outside it."""
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
SIGHT = "#E08D3C"
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


def run_colour(preset: str) -> str:
    """The colour of a run with the parameters of a preset, or with others."""
    return PRESET_COLOURS.get(preset, OWN_COLOUR)


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


def scatter(x: Any, y: Any, *, mode: str, **look: object) -> Part:
    """A trace of markers, lines or text."""
    return {"type": "scatter", "mode": mode, "x": x, "y": y, **look}


def bars(lengths: Any, rows: Any, **look: object) -> Part:
    """A trace of horizontal bars."""
    return {"type": "bar", "orientation": "h", "x": lengths, "y": rows, **look}


def heatmap(values: Any, *, colours: list[list[Any]], **look: object) -> Part:
    """A trace of coloured cells, without a colour bar."""
    return {"type": "heatmap", "z": values, "colorscale": colours, "showscale": False, **look}


def note(text: str, **place: object) -> Part:
    """An annotation without an arrow."""
    return {"text": text, "showarrow": False, **place}


def cursor_line(x: float, *, yref: str, colour: str = TRUTH) -> Part:
    """A dotted line across the plot that marks a place on its x axis."""
    ends = {"x0": x, "x1": x, "yref": yref, "y0": 0, "y1": 1}
    return {"type": "line", **ends, "line": {"color": colour, "width": 2, "dash": "dot"}}


def pixels_below(source: str, box: tuple[int, int, int, int], *, axes: str = "") -> Part:
    """A picture below the traces, whose pixels (x0, y0, x1, y1), ends excluded, lie at their places on the axes."""
    x0, y0, x1, y1 = box
    place = {"x": x0 - 0.5, "y": y0 - 0.5, "sizex": x1 - x0, "sizey": y1 - y0, "sizing": "stretch", "layer": "below"}
    return {"source": source, "xref": f"x{axes}", "yref": f"y{axes}", **place}


def side_by_side(count: int, *, gap: float) -> list[tuple[float, float]]:
    """Where panels of equal width begin and end, as shares of the figure's width."""
    width = (1 - gap * (count - 1)) / max(1, count)
    return [(number * (width + gap), number * (width + gap) + width) for number in range(count)]
