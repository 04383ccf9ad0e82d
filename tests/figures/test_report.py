import base64
import re

import pandas as pd
import plotly.graph_objects as go
import pytest

from corsmal.errors import ArgumentError
from corsmal.figures.pins import Pin
from corsmal.figures.report import report_html

TABLES = {"Table 2": pd.DataFrame({"container": ["red cup", "<b>"], "capacity_mape": [34.249, float("nan")]})}


@pytest.fixture(scope="module")
def report():
    pins = [
        Pin("Hull of 000001", figure=go.Figure(go.Scatter(x=[1, 2], y=[3, 4.25]))),
        Pin("Profile of 000001", figure=go.Figure(go.Scatter(x=[1], y=[2]))),
        Pin('A frame of "000001"', content=b"picture", medium="image/jpeg"),
        Pin("The crop", content=b"sound", medium="audio/wav"),
    ]
    return report_html("Run 7 & more", tables=TABLES, pins=pins, parameters={"L": 145, "weights": "a.safetensors"})


def test_everything_is_in_it(report):
    assert "<h1>Run 7 &amp; more</h1>" in report
    assert "<td>34.2</td>" in report
    assert "<td>–</td>" in report
    assert "&lt;b&gt;" in report
    assert f"data:image/jpeg;base64,{base64.b64encode(b'picture').decode()}" in report
    assert f"<audio controls src='data:audio/wav;base64,{base64.b64encode(b'sound').decode()}'>" in report
    assert "<td>L</td>" in report
    assert "a.safetensors" in report


def test_plotly_is_in_it_once_and_nothing_is_loaded_or_sent(report):
    assert report.count("plotly.js v") == 1
    assert report.count("Plotly.newPlot(") == 2
    without_library = re.sub(r"<head>.*</head>", "", report, flags=re.S)
    assert "http" not in re.sub(r'"plotlyServerURL":\s*"[^"]*"', "", without_library)
    assert not re.search(r"<(script|link|img|iframe)[^>]*(src|href)=['\"]?(https?:)?//", report)
    assert '"showSendToCloud": false' in report


def test_report_without_figures_is_small():
    assert len(report_html("Empty", tables={}, parameters={})) < 3000


@pytest.mark.parametrize(
    "content",
    [
        {},
        {"content": b"x"},
        {"content": b"x", "medium": "text/html"},
        {"medium": "image/png"},
        {"figure": go.Figure(), "content": b"x", "medium": "image/png"},
    ],
)
def test_pins_hold_one_thing(content):
    with pytest.raises(ArgumentError, match="either a figure"):
        Pin("nothing", **content)
