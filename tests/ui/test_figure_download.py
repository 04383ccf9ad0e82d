import math

import numpy as np
import plotly.graph_objects as go
import pytest

from corsmal.ui.figure_download import _csv, as_seen

EYE = {"x": 1.0, "y": 2.0, "z": 0.5}
ZERO = {"x": 0.0, "y": 0.0, "z": 0.0}
CAMERA = {"eye": EYE, "center": ZERO, "up": {"x": 0.0, "y": 0.0, "z": 1.0}}


@pytest.fixture
def figure():
    return go.Figure([go.Scatter(y=[1, 2], name="a"), go.Mesh3d(x=[0, 1, 0], y=[0, 0, 1], z=[0, 0, 0], name="b")])


def test_a_download_is_turned_zoomed_and_shows_the_traces_that_the_page_shows(figure):
    view = {"cameras": {"scene": CAMERA}, "ranges": {"xaxis": [0.5, 1.5]}, "visible": [True, "legendonly"]}
    seen = as_seen(figure, view, height_px=333)
    assert seen.layout.scene.camera.eye.to_plotly_json() == EYE
    assert list(seen.layout.xaxis.range) == [0.5, 1.5]
    assert [trace.visible for trace in seen.data] == [True, "legendonly"]
    assert seen.layout.height == 333
    assert figure.layout.height is None
    assert figure.data[1].visible is None


@pytest.mark.parametrize(
    "view",
    [
        None,
        "text",
        {"cameras": [1], "ranges": 3, "visible": "yes"},
        {"cameras": {"scene": {"eye": {"x": math.nan, "y": 0, "z": 0}}}, "ranges": {"xaxis": [math.inf, 1]}},
        {"cameras": {"paper_bgcolor": CAMERA}, "ranges": {"title": [0, 1], "xaxis": ["<b>", 1]}, "visible": [True]},
    ],
)
def test_a_view_that_nobody_can_have_is_ignored(figure, view):
    seen = as_seen(figure, view, height_px=200)
    assert seen.to_dict() == go.Figure(figure).update_layout(height=200).to_dict()


def test_data_has_the_digits_that_mean_something():
    figure = go.Figure(go.Scatter(x=np.array([1 / 3]), y=["=1+1"], name="@a", customdata=[2 / 3]))
    assert _csv(figure).decode() == "trace,x,y,label\n'@a,0.333333,'=1+1,0.666667\n"
    figure = go.Figure(go.Bar(x=[1.5], y=[0]), {"yaxis": {"tickvals": [0], "ticktext": ["<b>◆ none</b>"]}})
    assert _csv(figure).decode() == "trace,x,y\ntrace 1,1.5,◆ none\n"
