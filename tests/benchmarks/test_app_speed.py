"""What the app does on the server, each beside its bare cost. Compare the rows of one run, not the time of the day."""

import itertools
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import pytest
from pytest_benchmark.fixture import BenchmarkFixture
from streamlit.testing.v1 import AppTest

from corsmal.dataset import Recording, open_dataset
from corsmal.demo.opening import open_demo
from corsmal.figures import (
    hull_figure,
    profile_figure,
    reprojection_figure,
    score_figure,
)
from corsmal.parameters import METHOD_VIEWS, PAIRS, ShapeParameters
from corsmal.shape import KnownProfile, fit_hull, measure_hull
from corsmal.stages.detections import load_detections
from corsmal.store import Store
from corsmal.ui import shared
from corsmal.ui.linked_plot.component import figure_json
from corsmal.ui.playback import Playback
from tests.app.driver import PAGES, Visitor
from tests.benchmarks.conftest import Opened

PAIR = PAIRS[0]
KNOWN = KnownProfile.frustum(61.0, 98.0, 119.0)

slider = pytest.mark.benchmark(group="slider", max_time=0.5)
drawing = pytest.mark.benchmark(group="figure", max_time=0.3)
stepping = pytest.mark.benchmark(group="frame step", max_time=0.5)
rerunning = pytest.mark.benchmark(group="page")


def root_of(recording: Recording) -> Path:
    """The dataset that a recording belongs to."""
    return recording.views["view1"].video_path.parents[2]


@pytest.fixture
def server(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An app with a store of its own."""
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path))
    shared.store.cache_clear()


@pytest.fixture
def shapes() -> Callable[[], ShapeParameters]:
    """Another L at each step, as when it is dragged."""
    values = itertools.cycle(range(100, 190, 3))
    return lambda: ShapeParameters(circumferences=next(values))


@slider
@pytest.mark.usefixtures("server")
@pytest.mark.parametrize(
    ("preset", "knob"),
    [
        pytest.param("paper", "circumferences", marks=pytest.mark.goal(seconds=0.03)),
        pytest.param("tuned", "tilt_deg"),
    ],
)
def test_slider_step(benchmark: BenchmarkFixture, recording: Recording, preset: str, knob: str) -> None:
    """What the server does when L, or the tilt, is dragged on the Shape page: fit, figures, and what is sent of it."""
    visitor = Visitor(root_of(recording)).open("shape")
    visitor.choose("preset_control", preset)
    knobs = {"circumferences": range(100, 190, 3), "tilt_deg": [step / 4 for step in range(4, 34)]}
    values = itertools.cycle(knobs[knob])
    benchmark.pedantic(lambda: visitor.drag("hull", **{knob: next(values)}), rounds=12, warmup_rounds=2)
    assert visitor.crashes == []


@slider
def test_figures_of_a_slider_step(benchmark: BenchmarkFixture, opened: Opened, cameras, images, shapes) -> None:
    def step() -> list[str]:
        shape = shapes()
        fit = opened.fit(shape)
        figures = [
            hull_figure.parts(fit.hull, fit.dimensions, cameras=cameras),
            profile_figure.parts(fit.hull, fit.dimensions, known=KNOWN),
        ]
        for view in PAIR:
            mask = opened.mask(view)
            figures.append(reprojection_figure.parts(images[view], mask, cameras[view], fit.hull, parameters=shape))
        return [figure_json(figure) for figure in figures]

    assert all(benchmark(step))


@slider
def test_fit_with_its_files_and_masks(benchmark: BenchmarkFixture, opened: Opened, shapes) -> None:
    assert benchmark(lambda: opened.fit(shapes())).ok


@slider
def test_bare_fit_and_measures(benchmark: BenchmarkFixture, opened: Opened, cameras, shapes) -> None:
    masks, pair = [opened.mask(view) for view in PAIR], [cameras[view] for view in PAIR]
    assert benchmark(lambda: measure_hull(fit_hull(pair, masks, shapes()))).ok


@pytest.fixture
def figure(opened: Opened, cameras, images, request: pytest.FixtureRequest):
    """A function that makes the figure."""
    fit, view = opened.fit(ShapeParameters.paper()), PAIR[0]
    mask = opened.mask(view)
    return {
        "hull": lambda: hull_figure.parts(fit.hull, fit.dimensions, cameras=cameras),
        "profile": lambda: profile_figure.parts(fit.hull, fit.dimensions, known=KNOWN),
        "reprojection": lambda: reprojection_figure.parts(
            images[view], mask, cameras[view], fit.hull, parameters=ShapeParameters.paper()
        ),
        "scores": lambda: score_figure.parts(opened.best),
    }[request.param]


figures = pytest.mark.parametrize("figure", ["hull", "profile", "reprojection", "scores"], indirect=True)


@drawing
@figures
def test_one_figure_and_its_text(benchmark: BenchmarkFixture, figure) -> None:
    assert benchmark(lambda: figure_json(figure()))


@drawing
@figures
def test_bare_text_of_a_figure_that_is_made(benchmark: BenchmarkFixture, figure) -> None:
    made = figure()
    assert benchmark(figure_json, made)


@pytest.fixture(params=["real", "demo"])
def playback(request: pytest.FixtureRequest, opened: Opened, tmp_path: Path) -> Iterator[Playback]:
    """The recording that is measured on, or the first of the ready-made demo, with detections in every frame."""
    recording, found = opened.recording, opened.found.views
    if request.param == "demo":
        store = Store(tmp_path)
        recording = next(iter(open_dataset(open_demo(store=store))))
        found = load_detections(recording, store=store).views
    videos = {view: recording.views[view].video() for view in METHOD_VIEWS}
    yield Playback(recording, videos, found, "both thirds")
    for video in videos.values():
        video.close()


def in_sequence(playback: Playback, read: Callable[[str, int], bytes]) -> Callable[[], list[bytes]]:
    """Reads the three views' next frame at each call, from the beginning again after the end."""
    numbers = itertools.cycle(range(min(map(len, playback.videos.values()))))

    def step() -> list[bytes]:
        frame = next(numbers)
        return [read(view, frame) for view in playback.videos]

    return step


@stepping
def test_pictures_of_three_views(benchmark: BenchmarkFixture, playback: Playback) -> None:
    """What the server does for a frame of the time line: decode, draw the detections, make it small, encode."""
    assert all(benchmark.pedantic(in_sequence(playback, playback.picture), rounds=70, warmup_rounds=1))


@stepping
def test_bare_decoding_and_jpeg(benchmark: BenchmarkFixture, playback: Playback) -> None:
    def read(view: str, frame: int) -> bytes:
        return bytes(cv2.imencode(".jpg", playback.videos[view][frame])[1])

    assert all(benchmark.pedantic(in_sequence(playback, read), rounds=70, warmup_rounds=1))


@rerunning
@pytest.mark.usefixtures("server")
@pytest.mark.parametrize("page", PAGES)
def test_page_runs_again(benchmark: BenchmarkFixture, recording: Recording, page: str) -> None:
    """A round trip without the browser: Streamlit runs the page of a recording that was opened before."""
    visitor = Visitor(root_of(recording)).open(page)
    benchmark.pedantic(visitor.test.run, rounds=6, warmup_rounds=1)
    assert visitor.crashes == []


@rerunning
def test_bare_run_of_an_empty_page(benchmark: BenchmarkFixture) -> None:
    empty = AppTest.from_string("import streamlit as st\nst.title('Nothing')")
    benchmark.pedantic(empty.run, rounds=6, warmup_rounds=1)
