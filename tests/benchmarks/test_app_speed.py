"""What the app does on the server, each beside its bare cost. Compare the rows of one run, not the time of the day."""

import itertools
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import pytest
from pytest_benchmark.fixture import BenchmarkFixture
from streamlit.testing.v1 import AppTest

from corsmal.dataset import Recording, Video
from corsmal.detection import filter_detections
from corsmal.figures import (
    draw_detections,
    hull_figure,
    jpeg,
    profile_figure,
    reprojection_figure,
    score_figure,
)
from corsmal.parameters import METHOD_VIEWS, PAIRS, ShapeParameters
from corsmal.shape import KnownProfile, fit_hull, measure_hull
from corsmal.ui import shared
from corsmal.ui.linked_plot.component import figure_json
from tests.app.driver import PAGES, Visitor
from tests.benchmarks.conftest import Opened

PICTURE_WIDTH_PX = 960
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
def test_slider_step(benchmark: BenchmarkFixture, recording: Recording, shapes) -> None:
    """What the server does when L is dragged on the Shape page: the fit, the figures, and what is sent of the page."""
    visitor = Visitor(root_of(recording)).open("shape")
    benchmark.pedantic(lambda: visitor.drag("hull", circumferences=shapes().circumferences), rounds=12, warmup_rounds=2)
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
            figures.append(reprojection_figure.parts(images[view], mask, cameras[view], fit.hull, points=shape.points))
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
        "reprojection": lambda: reprojection_figure.parts(images[view], mask, cameras[view], fit.hull, points=19),
        "scores": lambda: score_figure.parts(opened.best, frame=3),
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


@pytest.fixture
def next_frames(recording: Recording) -> Iterator[Callable[[], tuple[int, dict[str, Video]]]]:
    """The three views' next frame at each call, from the beginning again after the end."""
    videos = {view: recording.views[view].video() for view in METHOD_VIEWS}
    numbers = itertools.cycle(range(min(len(video) for video in videos.values())))
    yield lambda: (next(numbers), videos)
    for video in videos.values():
        video.close()


@stepping
def test_frame_step_in_three_views(benchmark: BenchmarkFixture, opened: Opened, next_frames) -> None:
    """What pages/frames.py does: decode, draw, encode, and the scores with their cursor."""

    def step() -> list[bytes]:
        frame, videos = next_frames()
        pictures = []
        for view, video in videos.items():
            detections = opened.found.views[view][frame]
            filtered = filter_detections(detections, centre_rule=opened.best.centre_rule)
            pictures.append(jpeg(draw_detections(video[frame], detections, filtered), width=PICTURE_WIDTH_PX))
        return [*pictures, figure_json(score_figure.parts(opened.best, frame=frame)).encode()]

    assert all(benchmark.pedantic(step, rounds=20, warmup_rounds=1))


@stepping
def test_bare_decoding_and_jpeg(benchmark: BenchmarkFixture, next_frames) -> None:
    def step() -> list[int]:
        frame, videos = next_frames()
        return [len(cv2.imencode(".jpg", video[frame])[1]) for video in videos.values()]

    assert all(benchmark.pedantic(step, rounds=20, warmup_rounds=1))


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
