import asyncio
import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest
from streamlit.testing.v1 import AppTest

from corsmal.errors import ArgumentError
from corsmal.ui.linked_plot import Click, PlotEvent, Slider, Span, plotly_route
from corsmal.ui.linked_plot.assets import plotly_url
from corsmal.ui.linked_plot.component import figure_json
from corsmal.ui.linked_plot.events import parse_event

SCRIPT = """
import plotly.graph_objects as go
import streamlit as st
from corsmal.ui.linked_plot import Slider, linked_plot, plot_event

event = plot_event("plot")
figure = go.Figure(go.Scatter(y=[1, 2]), layout={"template": "plotly_dark"})
sliders = [Slider("a", "A", min=0, max=9, step=1, value=3), Slider("b", "B", min=0, max=9, step=1, value=4)]
linked_plot(figure, key="plot", label="Plot", sliders=sliders)
st.session_state["event"] = event
"""

CHECKS = """
import plotly.graph_objects as go
import streamlit as st
from corsmal.ui.linked_plot import Slider, linked_plot

slider = Slider("a", "A", min=0, max=9, step=1, value=3)
for arguments in ({"sliders": [slider, slider]}, {"height_px": 0}):
    try:
        linked_plot(go.Figure(), key="plot", label="Plot", **arguments)
    except ValueError as error:
        st.error(str(error))
"""

SPAN = """
import plotly.graph_objects as go
import streamlit as st
from corsmal.ui.linked_plot import Slider, Span, linked_plot, plot_event

st.session_state["values"] = plot_event("plot").values
slider = Slider("c", "C", min=0, max=9, step=1, value=1)
span = Span(names=("a", "b"), labels=("A", "B"), min=0, max=9, step=1, values=(3, 4))
linked_plot(go.Figure(), key="plot", label="Plot", sliders=[slider], span=span)
"""


def run(report: dict[str, Any] | None = None) -> AppTest:
    test = AppTest.from_string(SCRIPT, default_timeout=30).run()
    test.session_state["plot"] = {"report": report} if report else {}
    return test.run()


def event_of(test: AppTest) -> PlotEvent:
    assert not test.exception
    event: PlotEvent = test.session_state["event"]
    return event


def test_first_run_has_no_event() -> None:
    assert event_of(run()) == PlotEvent()


def test_a_report_is_one_event() -> None:
    test = run({"sequence": 1, "values": {"a": 7}, "settled": False})
    assert event_of(test) == PlotEvent(values={"a": 7}, settled=False)
    assert event_of(test.run()) == PlotEvent()


def test_the_browser_learns_which_report_was_answered() -> None:
    (component,) = run({"sequence": 5, "values": {"a": 7}}).get("bidi_component")
    sent = json.loads(component.proto.json)
    assert sent["acknowledged"] == 5
    assert [slider["value"] for slider in sent["sliders"]] == [3, 4]
    assert "template" not in json.loads(sent["figure"])["layout"]


def test_parse_reads_every_kind() -> None:
    click = {"x": 1, "y": "b", "curve": 2, "customdata": [3]}
    event = parse_event({"click": click})
    assert event.click == Click(x=1, y="b", curve=2, customdata=[3])
    assert event.settled


@pytest.mark.parametrize(
    "report",
    [
        {"values": [1]},
        {"values": {"a": "x"}},
        {"values": {"a": float("nan")}},
        {"click": {"x": 1}},
        {"click": 3},
    ],
)
def test_parse_refuses_what_it_cannot_read(report: dict[str, Any]) -> None:
    with pytest.raises(ArgumentError, match="reload the page"):
        parse_event(report)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"min": 5, "max": 5}, "min must be below max"),
        ({"step": 0}, "step positive"),
        ({"value": 10}, r"must lie in 0\.\.9, got 10"),
        ({"value": float("nan")}, "finite"),
    ],
)
def test_slider_refuses(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        Slider(**({"name": "a", "label": "A", "min": 0, "max": 9, "step": 1, "value": 3} | change))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"values": (5, 4)}, "must rise within 0..9"),
        ({"values": (-1, 4)}, "must rise within 0..9"),
        ({"values": (3, 9.5)}, "must rise within 0..9"),
        ({"values": (3, float("inf"))}, "finite"),
        ({"step": 0}, "step be positive"),
        ({"gap": -1}, "gap not negative"),
    ],
)
def test_span_refuses(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        Span(**({"names": ("a", "b"), "labels": ("A", "B"), "min": 0, "max": 9, "step": 1, "values": (3, 4)} | change))


def test_ends_of_a_span_are_values_like_those_of_range_inputs() -> None:
    test = AppTest.from_string(SPAN, default_timeout=30).run()
    assert test.session_state["values"] == {}
    test.session_state["plot"] = {"report": {"sequence": 1, "values": {"b": 7}, "settled": False}}
    test.run()
    assert test.session_state["values"] == {"b": 7}
    sent = json.loads(test.get("bidi_component")[0].proto.json)["span"]
    assert (sent["names"], sent["values"], sent["domain"]) == (["a", "b"], [3, 4], [0, 1])


def test_names_and_height_are_checked() -> None:
    test = AppTest.from_string(CHECKS, default_timeout=30).run()
    assert [error.value for error in test.error] == [
        "sliders must have different names, got ['a', 'a']",
        "height_px must be positive, got 0",
    ]


def test_parts_go_to_the_browser_as_a_checked_figure_would() -> None:
    trace = {
        "type": "heatmap",
        "x": np.arange(3, dtype=np.float32),
        "z": np.arange(6, dtype=np.uint8).reshape(2, 3).T,
        "text": np.array(["a", "b"]),
        "customdata": [[1, None], [2.5, "b"]],
        "y": np.array([]),
    }
    sent = json.loads(figure_json({"data": [trace], "layout": {"title": {"text": "A"}}}))
    checked = go.Figure([trace], {"title": {"text": "A"}})
    assert sent == json.loads(figure_json(checked))
    assert sent["data"][0]["z"]["shape"] == "3, 2"
    assert np.frombuffer(base64.b64decode(sent["data"][0]["z"]["bdata"]), np.uint8).tolist() == [0, 3, 1, 4, 2, 5]


def test_plotly_js_comes_from_the_installed_package() -> None:
    route = plotly_route()
    response = asyncio.run(route.endpoint(None))
    assert route.path == plotly_url()
    assert response.media_type == "text/javascript"
    assert "plotly.js" in Path(response.path).read_text(encoding="utf-8")[:200]
