"""What the app does on the server, each beside its bare cost. Compare the rows of one run, not the time of the day."""

import itertools
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from plotly.io.json import to_json_plotly
from pytest_benchmark.fixture import BenchmarkFixture

from corsmal.batch import DetectionSet, load_detections
from corsmal.dataset import Recording, Video, open_dataset
from corsmal.detection import filter_detections
from corsmal.estimation import container_mask, fit_frame
from corsmal.figures import (
    draw_detections,
    hull_figure,
    jpeg,
    profile_figure,
    reprojection_figure,
    score_figure,
)
from corsmal.parameters import METHOD_VIEWS, PAIRS, SelectionParameters, ShapeParameters
from corsmal.selection import BestFrame, select_best_frame
from corsmal.shape import fit_hull, measure_hull
from corsmal.store import Store
from tests.tiny import write_tiny_dataset

ROOT = Path(__file__).resolve().parents[2]
REAL = ROOT.parent / "shared" / "ccm" / "train"
PICTURE_WIDTH_PX = 960
PAIR = PAIRS[0]

slider = pytest.mark.benchmark(group="one step of a slider", max_time=0.4)
stepping = pytest.mark.benchmark(group="one frame further, three views, nothing cached", max_time=0.4)
opening = pytest.mark.benchmark(group="opening a recording", max_time=0.4)


@dataclass(frozen=True)
class Opened:
    """A recording as the pages hold it."""

    recording: Recording
    found: DetectionSet
    best: BestFrame

    @property
    def frame(self) -> int:
        return self.best.frame or 0

    def mask(self, view: str):
        detections = self.found.views[view][self.frame]
        return container_mask(detections, centre_rule=self.best.centre_rule, parameters=SelectionParameters())

    def fit(self, shape: ShapeParameters):
        return fit_frame(
            self.recording,
            self.found.views,
            pair=PAIR,
            frame=self.frame,
            centre_rule=self.best.centre_rule,
            shape=shape,
        )


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """The real recording 000618; where it is absent, a generated one of the same size."""
    if REAL.is_dir():
        return open_dataset(REAL)["000618"]
    root = write_tiny_dataset(tmp_path_factory.mktemp("large"), recordings=1, size=(1280, 720), frames=40)
    return open_dataset(root)["000000"]


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    return Store(tmp_path_factory.mktemp("cache"))


@pytest.fixture(scope="module")
def opened(recording: Recording, store: Store) -> Opened:
    found = load_detections(recording, store=store)
    return Opened(recording, found, select_best_frame(found.views, pair=PAIR))


@pytest.fixture(scope="module")
def cameras(recording: Recording):
    return {name: recording.views[name].camera() for name in METHOD_VIEWS}


@pytest.fixture(scope="module")
def images(opened: Opened):
    pictures = {}
    for view in METHOD_VIEWS:
        with opened.recording.views[view].video() as video:
            pictures[view] = video[opened.frame]
    return pictures


@pytest.fixture
def shapes() -> Callable[[], ShapeParameters]:
    """Another L at each step, as when it is dragged."""
    values = itertools.cycle(range(100, 190, 3))
    return lambda: ShapeParameters(circumferences=next(values))


def as_json(figure) -> str:
    parts = figure.to_dict()
    parts["layout"].pop("template", None)
    return to_json_plotly(parts)


@slider
def test_slider_step(benchmark: BenchmarkFixture, opened: Opened, cameras, images, shapes) -> None:
    """What pages/shape.py does: fit, four figures, and their text for the browser."""

    def step() -> list[str]:
        shape = shapes()
        fit = opened.fit(shape)
        figures = [
            hull_figure(fit.hull, fit.dimensions, cameras=cameras),
            profile_figure(fit.hull, fit.dimensions, truth_mm=(61.0, 98.0, 119.0)),
        ]
        for view in PAIR:
            mask = opened.mask(view)
            figures.append(reprojection_figure(images[view], mask, cameras[view], fit.hull, points=shape.points))
        return [as_json(figure) for figure in figures]

    assert all(benchmark(step))


@slider
@pytest.mark.parametrize("name", ["hull", "profile", "reprojection"])
def test_one_figure(benchmark: BenchmarkFixture, opened: Opened, cameras, images, name: str) -> None:
    fit, view = opened.fit(ShapeParameters.paper()), PAIR[0]
    mask = opened.mask(view)
    make = {
        "hull": lambda: hull_figure(fit.hull, fit.dimensions, cameras=cameras),
        "profile": lambda: profile_figure(fit.hull, fit.dimensions, truth_mm=(61.0, 98.0, 119.0)),
        "reprojection": lambda: reprojection_figure(images[view], mask, cameras[view], fit.hull, points=19),
    }[name]
    assert benchmark(lambda: as_json(make()))


@slider
def test_fit_with_its_files_and_masks(benchmark: BenchmarkFixture, opened: Opened, shapes) -> None:
    assert benchmark(lambda: opened.fit(shapes())).ok


@slider
def test_bare_cost_the_fit_alone(benchmark: BenchmarkFixture, opened: Opened, cameras, shapes) -> None:
    masks, pair = [opened.mask(view) for view in PAIR], [cameras[view] for view in PAIR]
    assert benchmark(lambda: measure_hull(fit_hull(pair, masks, shapes()))).ok


@pytest.fixture
def next_frames(recording: Recording):
    """The three views' next frame at each call, from the beginning again after the end."""
    videos = {view: recording.views[view].video() for view in METHOD_VIEWS}
    numbers = itertools.cycle(range(min(len(video) for video in videos.values())))

    def advance() -> tuple[int, dict[str, Video]]:
        return next(numbers), videos

    yield advance
    for video in videos.values():
        video.close()


@stepping
def test_frame_step(benchmark: BenchmarkFixture, opened: Opened, next_frames) -> None:
    """What pages/frames.py does: decode, draw, encode, and the scores with their cursor."""

    def step() -> list[bytes]:
        frame, videos = next_frames()
        pictures = []
        for view, video in videos.items():
            detections = opened.found.views[view][frame]
            filtered = filter_detections(detections, centre_rule=opened.best.centre_rule)
            pictures.append(jpeg(draw_detections(video[frame], detections, filtered), width=PICTURE_WIDTH_PX))
        return [*pictures, as_json(score_figure(opened.best, frame=frame)).encode()]

    assert all(benchmark(step))


@stepping
def test_frame_jump_backwards(benchmark: BenchmarkFixture, next_frames) -> None:
    """Decoding where no step leads: each time 37 frames back."""

    def jump() -> list[int]:
        frame, videos = next_frames()
        return [int(video[(-37 * frame) % len(video)][0, 0, 0]) for video in videos.values()]

    assert len(benchmark.pedantic(jump, rounds=12, warmup_rounds=1)) == 3


@stepping
def test_bare_cost_decoding_alone(benchmark: BenchmarkFixture, next_frames) -> None:
    def step() -> list[int]:
        frame, videos = next_frames()
        return [int(video[frame][0, 0, 0]) for video in videos.values()]

    assert len(benchmark(step)) == 3


@stepping
def test_bare_cost_drawing_alone(benchmark: BenchmarkFixture, opened: Opened, images) -> None:
    detections = {view: opened.found.views[view][opened.frame] for view in METHOD_VIEWS}
    filtered = {
        view: filter_detections(found, centre_rule=opened.best.centre_rule) for view, found in detections.items()
    }
    benchmark(lambda: [draw_detections(images[view], detections[view], filtered[view]) for view in METHOD_VIEWS])


@stepping
def test_bare_cost_jpeg_alone(benchmark: BenchmarkFixture, images) -> None:
    assert all(benchmark(lambda: [jpeg(image, width=PICTURE_WIDTH_PX) for image in images.values()]))


@stepping
def test_bare_cost_the_figure_of_the_scores(benchmark: BenchmarkFixture, opened: Opened) -> None:
    assert benchmark(lambda: as_json(score_figure(opened.best, frame=3)))


@opening
def test_read_the_detections_files(benchmark: BenchmarkFixture, recording: Recording, store: Store) -> None:
    assert len(benchmark(load_detections, recording, store=store).views) >= 3


@opening
def test_score_all_frames_of_a_pair(benchmark: BenchmarkFixture, opened: Opened) -> None:
    assert benchmark(select_best_frame, opened.found.views, pair=PAIR).ok


@opening
def test_open_three_videos(benchmark: BenchmarkFixture, recording: Recording) -> None:
    def open_them() -> int:
        count = 0
        for view in METHOD_VIEWS:
            with recording.views[view].video() as video:
                count += video.frame_count
        return count

    assert benchmark(open_them) > 0


@pytest.mark.benchmark(group="importing, in a new process")
@pytest.mark.parametrize(
    "statement", ["pass", "import corsmal", "import corsmal.dataset", "import corsmal.batch, corsmal.figures"]
)
def test_import(benchmark: BenchmarkFixture, statement: str) -> None:
    command = [sys.executable, "-c", statement]
    benchmark.pedantic(subprocess.run, args=(command,), kwargs={"check": True, "cwd": ROOT}, rounds=3, warmup_rounds=1)
