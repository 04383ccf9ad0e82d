import json
import re
import shutil
import struct

import numpy as np
import pandas as pd
import plotly.graph_objects as go
import pytest

from corsmal.errors import ArgumentError, FileError, NotFoundError
from corsmal.evaluation import error_table
from corsmal.figures import export_figure, figure_data
from corsmal.figures.evaluation import comparison_figure, errors_figure
from corsmal.figures.export import draw_pictures, find_browser, picture_of
from corsmal.figures.grey import in_grey
from corsmal.figures.heatmaps import confusion_figure
from tests.evaluation.made import made_annotation, perfect_estimates

POINTS = go.Figure(
    [
        go.Scatter(x=[1, 2], y=[3, 4], name="red", line={"color": "#E5484D"}),
        go.Scatter(x=[1, 2], y=[4, 3], name="green", line={"color": "#14B8A6"}),
    ],
    {"xaxis": {"title": {"text": "frame"}}, "yaxis": {"title": {"text": "radius (mm)"}}},
)
CONE = go.Figure(go.Mesh3d(x=[0, 1, 0, 0], y=[0, 0, 1, 0], z=[0, 0, 0, 1], color="#6A5ACD", name="hull"))


@pytest.fixture
def no_browser(monkeypatch):
    """As if none was installed."""
    monkeypatch.setenv("BROWSER_PATH", "/nowhere/chrome")


def test_one_browser_draws_vectors_pages_and_pixels_of_the_wanted_size():
    if shutil.which("chromium") is None:
        pytest.skip("no program named chromium on PATH; on Debian: apt-get install chromium")
    shares = []
    svg, pdf, png, screen, cone = draw_pictures(
        [
            picture_of(POINTS, file_format="svg", width_mm=80, font_pt=9),
            picture_of(POINTS, file_format="pdf", width_mm=80, font_pt=9),
            picture_of(POINTS, file_format="png", width_mm=80, font_pt=9, is_grey=True),
            picture_of(POINTS, file_format="png", width_px=1000, font_pt=12),
            picture_of(CONE, file_format="png", width_px=300),
        ],
        progress=lambda done, total: shares.append((done, total)),
    )
    width = float(re.findall(r'<svg[^>]* width="([\d.]+)"', svg.decode())[0])
    assert width == pytest.approx(80 / 25.4 * 96, rel=0.01)
    assert "radius (mm)" in svg.decode()
    assert pdf[:5] == b"%PDF-"
    box = re.findall(rb"/MediaBox\s*\[\s*0 0 ([\d.]+) ([\d.]+)", pdf)[0]
    assert float(box[0]) == pytest.approx(80 / 25.4 * 72, rel=0.02)
    assert size_of(png)[0] == pytest.approx(80 / 25.4 * 300, abs=2)
    assert size_of(screen)[0] == pytest.approx(1000, abs=1)
    assert size_of(cone)[0] == pytest.approx(300, abs=1)
    assert shares[-1] == (5, 5)


def size_of(png):
    return struct.unpack(">II", png[16:24])


@pytest.mark.usefixtures("no_browser")
def test_without_a_browser_one_sentence_says_what_to_install():
    assert find_browser() is None
    with pytest.raises(NotFoundError, match=r"needs Chrome or Chromium.*apt-get install chromium"):
        export_figure(POINTS, file_format="svg")


@pytest.mark.usefixtures("no_browser")
@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"path": "figure.gif"}, "file_format must be one of svg, pdf, png, got 'gif'"),
        ({}, "file_format must be one of"),
        ({"path": "a.svg", "width_mm": 80, "width_px": 80}, "exclude each other"),
        ({"path": "a.svg", "width_mm": -1}, "width must be above 0"),
        ({"path": "a.svg", "width_px": 20_000}, "at most 10000 pixels"),
        ({"path": "a.svg", "font_pt": 0}, "font_pt must be from 1 to 100"),
    ],
)
def test_wrong_wishes_are_named_before_a_browser_starts(options, problem):
    with pytest.raises(ArgumentError, match=problem):
        export_figure(POINTS, **options)


def test_a_file_that_cannot_be_written_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr("corsmal.figures.export.draw_pictures", lambda _pictures: [b"content"])
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(FileError, match="choose another file"):
        export_figure(POINTS, tmp_path / "file" / "figure.svg")
    assert export_figure(POINTS, tmp_path / "figure.svg") == (tmp_path / "figure.svg").read_bytes() == b"content"


def test_greys_stay_apart_and_scales_run_from_light_to_dark():
    figure = go.Figure(
        [
            *POINTS.data,
            go.Scatter(y=[1], marker={"line": {"color": "#FFFFFF"}}),
            go.Heatmap(z=[[1, 2]], colorscale=[[0, "#2166AC"], [0.5, "rgba(243,243,241,0.5)"], [1, "#B2182B"]]),
        ],
        {"annotations": [{"text": "<span style='color:#E69F00'>●</span> view1"}], "title": "#E5484D is red"},
    )
    grey = in_grey(figure.to_dict())
    lines = [trace["line"]["color"] for trace in grey["data"][:2]]
    assert lines == ["#282828", "#B9B9B9"]
    scale = [colour for _, colour in grey["data"][3]["colorscale"]]
    assert grey["data"][2]["marker"]["line"]["color"] == "#FFFFFF"
    assert [int(colour[1:3], 16) for colour in scale] == [250, 185, 120]
    assert re.fullmatch(r"<span style='color:#(..)\1\1'>●</span> view1", grey["layout"]["annotations"][0]["text"])
    assert grey["layout"]["title"]["text"] == "#E5484D is red"
    assert figure.data[0].line.color == "#E5484D"


@pytest.mark.parametrize("is_read", [False, True])
def test_data_of_points_is_named_after_the_axes(is_read):
    packed = go.Figure(POINTS).update_traces(x=np.array([1, 2]))
    table = figure_data(go.Figure(json.loads(packed.to_json())) if is_read else packed)
    assert list(table.columns) == ["trace", "frame", "radius (mm)"]
    assert table.to_numpy().tolist() == [["red", 1, 3], ["red", 2, 4], ["green", 1, 4], ["green", 2, 3]]


def test_data_of_cells_vertices_intervals_and_panels():
    counts = pd.DataFrame([[3, 1]], index=["rice"], columns=["rice", "none"])
    cells = figure_data(confusion_figure({"cup": counts}))
    assert cells[cells["trace"] == "cup"][["predicted", "true", "value"]].to_numpy().tolist() == [
        ["rice", "rice", 75.0],
        ["none", "rice", 25.0],
    ]
    assert figure_data(CONE)["z (mm)"].tolist() == [0, 0, 0, 1]
    rows = pd.DataFrame({"label": ["Height"], "difference": [2.0], "low": [1.0], "high": [4.0], "verdict": ["better"]})
    [row] = figure_data(comparison_figure(rows, label="label")).to_dict("records")
    assert (row["x_low"], row["x_high"], row["label"]) == (1.0, 4.0, "Height")
    annotation = made_annotation(21)
    errors = error_table(perfect_estimates(annotation), annotation)
    table = figure_data(errors_figure(errors, colour="#123456"))
    assert set(table["label"].dropna()) == set(errors.index)
    assert figure_data(go.Figure()).empty


def test_errors_of_every_number_have_a_panel_each_over_the_same_containers():
    annotation = made_annotation(21)
    estimates = perfect_estimates(annotation)
    estimates["height_mm"] = np.nan
    estimates["capacity_ml"] *= 1.1
    figure = errors_figure(error_table(estimates, annotation), colour="#123456")
    titles = [note.text for note in figure.layout.annotations]
    assert titles == ["<b>Capacity</b>", "<b>Top width</b>", "<b>Bottom width</b>", "<b>Mass</b>"]
    points = [trace for trace in figure.data if trace.name == "measured" and trace.xaxis == "x"]
    assert np.asarray(points[0].x) == pytest.approx(10)
    assert list(figure.layout.yaxis4.ticktext) == ["red cup", "green glass", "cereal box"]
