"""Functions that draw figures, checked by Plotly or as the browser takes them."""

from collections.abc import Callable, Sequence
from functools import update_wrapper
from typing import Generic, ParamSpec

import plotly.graph_objects as go

from corsmal.figures.style import Part

P = ParamSpec("P")

Drawn = tuple[Sequence[Part], Part]
"""The traces and the layout of a figure."""


class Drawing(Generic[P]):
    """A function that draws: called, it gives a ``plotly.graph_objects.Figure``.

    ``parts`` takes the same arguments and gives the figure's traces and layout as they go to the browser, which is
    several times as fast, because Plotly checks none of them: for plots that follow a slider.

    Args:
        parts: the function; it gives the traces and the layout.
    """

    def __init__(self, parts: Callable[P, Drawn]) -> None:
        self._parts = parts
        update_wrapper(self, parts)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> go.Figure:
        """The figure."""
        return go.Figure(*self._parts(*args, **kwargs))

    def parts(self, *args: P.args, **kwargs: P.kwargs) -> Part:
        """``data`` and ``layout`` of the figure, in Plotly's own terms."""
        traces, layout = self._parts(*args, **kwargs)
        return {"data": traces, "layout": layout}
