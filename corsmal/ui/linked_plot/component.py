"""The component behind every linked plot, and how a page talks to it.

The page owns the values, the browser reports what the user does. A page therefore asks first and draws after::

    @st.fragment
    def hull_plot() -> None:
        parameters.update(plot_event("hull").values)
        linked_plot(figure(parameters), key="hull", label="Hull", sliders=[Slider(..., value=parameters["L"])])

``Slider.value`` is what the input shows. As long as the user drags it, or the answer to the last report is on its
way, the browser keeps the user's position; otherwise it follows ``Slider.value``, so a preset or an opened address
moves the sliders.
"""

import base64
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
import plotly.graph_objects as go
import streamlit as st
from plotly.io.json import to_json_plotly

from corsmal.errors import ArgumentError
from corsmal.figures.style import Part
from corsmal.ui.figure_download import as_seen, figure_dialog
from corsmal.ui.linked_plot.assets import plotly_url, read_asset
from corsmal.ui.linked_plot.events import PlotEvent, Slider, Span, parse_event

ARRAY_TYPES = ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")
"""What a browser has arrays of."""

_component = st.components.v2.component(
    "corsmal.linked_plot",
    css=read_asset("linked_plot.css"),
    js="".join(map(read_asset, ("linked_plot.js", "reports.js", "span.js", "cursor.js", "camera.js"))),
    isolate_styles=False,
)


def linked_plot(
    figure: go.Figure | Part,
    *,
    key: str,
    label: str,
    height_px: int = 480,
    sliders: Sequence[Slider] = (),
    span: Span | None = None,
    frame_on_x: float | None = None,
    revision: str = "",
    follows_camera: bool = False,
    camera: Sequence[float] | None = None,
) -> None:
    """Show a figure that keeps its camera and reports what the user does with it.

    Inside a ``st.fragment`` only the fragment runs again. Colours and fonts that the figure does not set come from
    the app's theme.

    Args:
        figure: the figure, or the parts of a ``Drawing``; width, height and template are replaced.
        key: names the plot in ``st.session_state``; unique in the app.
        label: accessible name.
        height_px: height of the figure without the range inputs.
        sliders: range inputs under the figure.
        span: two handles on the figure's x-axis.
        frame_on_x: the length of one frame on the x-axis: a line marks where the page's time line stands, and a click
            on a point goes to its frame instead of being reported.
        revision: camera, zoom and hidden traces stay while this stays the same.
        follows_camera: whether the page keeps the camera of a plot in 3D, see ``PlotEvent.camera``.
        camera: where that is, as the page keeps it; None: where the figure has it.

    Raises:
        ArgumentError: two range inputs or ends share a name, or the height is not positive.
    """
    names = [slider.name for slider in sliders] + ([] if span is None else [*span.names])
    if len(set(names)) < len(names):
        raise ArgumentError(f"sliders must have different names, got {names}")
    if height_px < 1:
        raise ArgumentError(f"height_px must be positive, got {height_px}")
    shown = _component(
        key=key,
        data={
            "figure": figure_json(figure),
            "label": label,
            "height": height_px,
            "sliders": [asdict(slider) for slider in sliders],
            "span": None if span is None else asdict(span),
            "frame_on_x": frame_on_x,
            "revision": revision or key,
            "follows_camera": follows_camera,
            "camera": None if camera is None else list(camera),
            "acknowledged": acknowledged(key),
            "plotly_url": plotly_url(),
        },
        on_report_change=no_callback,
        on_download_change=no_callback,
    )
    if shown.download is not None:
        figure_dialog(as_seen(figure, shown.download, height_px=height_px), name=label)


def plot_event(key: str) -> PlotEvent:
    """What the user did to a linked plot, or to the time line, since its last run.

    Args:
        key: its key.

    Returns:
        The event, once; an empty one when this run has another cause, or the event was handed out before.

    Raises:
        ArgumentError: the browser sent something that cannot be read.
    """
    return parse_event(fresh_report(key))


def fresh_report(key: str) -> dict[str, Any]:
    """What a component of ours reports, once; empty when the run has another cause.

    Args:
        key: its key.
    """
    report: dict[str, Any] = (st.session_state.get(key) or {}).get("report") or {}
    sequence = report.get("sequence", 0)
    if sequence <= acknowledged(key):
        return {}
    st.session_state[_acknowledged_key(key)] = sequence
    return report


def acknowledged(key: str) -> int:
    """The number of the last report that was handed out."""
    number: int = st.session_state.get(_acknowledged_key(key), 0)
    return number


def _acknowledged_key(key: str) -> str:
    return f"{key}.acknowledged"


def figure_json(figure: go.Figure | Part) -> str:
    """A figure as it goes to the browser."""
    parts = figure.to_dict() if isinstance(figure, go.Figure) else _packed(figure)
    parts.get("layout", {}).pop("template", None)
    return str(to_json_plotly(parts))


def _packed(value: Any) -> Any:
    """Arrays of numbers in the form that Plotly unpacks in the browser, as ``Figure.to_dict`` gives them."""
    if isinstance(value, dict):
        return {name: _packed(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_packed(part) for part in value]
    if not isinstance(value, np.ndarray) or not value.size:
        return value
    code = f"{value.dtype.kind}{value.dtype.itemsize}"
    if code not in ARRAY_TYPES:
        return value
    packed = {"dtype": code, "bdata": base64.b64encode(value.tobytes()).decode("ascii")}
    return packed | ({"shape": ", ".join(map(str, value.shape))} if value.ndim > 1 else {})


def no_callback() -> None:
    """Streamlit names a component's state by its callbacks; the run itself is all that is wanted."""
