"""From opening an uninspected recording to its best frame, with the demo's detector.

The bare cost is the forward passes of the frames that a search inspects, with a process per core, images in memory.
"""

import itertools
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import streamlit as st
from pytest_benchmark.fixture import BenchmarkFixture

from corsmal.dataset import open_dataset
from corsmal.demo.opening import PACK
from corsmal.engines.processes import Processes, cores
from corsmal.parameters import METHOD_VIEWS
from corsmal.stages.detections import load_detections
from corsmal.stages.settings import find_detector
from corsmal.store import Store
from corsmal.ui import detecting, shared
from corsmal.ui.following import NEXT_S, is_due
from corsmal.ui.opened import OpenedRecording
from tests.app.driver import Visitor

RECORDING = "000000"
WAIT_S = 600

by_itself = pytest.mark.benchmark(group="best frame")


@pytest.fixture(scope="module")
def uninspected(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The ready-made demo's recordings without its results."""
    return Path(shutil.copytree(PACK / "recordings", tmp_path_factory.mktemp("uninspected") / "demo"))


@pytest.fixture
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], Path]]:
    """A function that begins with an empty store, and names it."""
    numbers = itertools.count()

    def begin() -> Path:
        cache = tmp_path / str(next(numbers))
        monkeypatch.setenv("CORSMAL_CACHE", str(cache))
        shared.jobs().stop()
        for function in (shared.store, shared.jobs):
            function.cache_clear()
        st.cache_resource.clear()
        return cache

    monkeypatch.setattr(sys, "argv", ["app.py"])
    monkeypatch.setattr(detecting, "BY_ITSELF_S", 1e6)  # however slow the machine is
    yield begin
    shared.inspector(find_detector("demo")).close()


def ended(key: str) -> None:
    """Wait until the job of a key has ended as it should."""
    deadline_s = time.monotonic() + WAIT_S
    while shared.jobs().is_active(key) and time.monotonic() < deadline_s:
        time.sleep(0.01)
    assert shared.jobs().state(key) == "done"


def opened_until_found(root: Path) -> None:
    """Open a recording on the Overview, which runs again as in a browser, until the search has ended."""
    visitor = Visitor(root, begins="overview", recording=RECORDING)
    key, shown = OpenedRecording(open_dataset(root)[RECORDING]).job_key, 0
    while shared.jobs().is_active(key):
        time.sleep(0.02)
        job = shared.jobs().get(key)
        if job is not None and is_due(job, shown, next_s=visitor.test.session_state[NEXT_S]):
            shown = job.results
            visitor.test.run()
    ended(key)


@by_itself
@pytest.mark.goal(ratio=1.5)
@pytest.mark.long
def test_open_to_best_frame_with_processes_started_before(
    benchmark: BenchmarkFixture, uninspected: Path, fresh: Callable[[], Path]
) -> None:
    fresh()
    opened_until_found(uninspected)
    benchmark.pedantic(opened_until_found, args=(uninspected,), setup=lambda: fresh() and None, rounds=3)


@by_itself
@pytest.mark.long
def test_bare_forward_passes(benchmark: BenchmarkFixture, uninspected: Path, fresh: Callable[[], Path]) -> None:
    store = Store(fresh())
    opened_until_found(uninspected)
    recording = open_dataset(uninspected)[RECORDING]
    frames = {name: view.frames for name, view in load_detections(recording, store=store).views.items()}
    passes = Passes(uninspected, {RECORDING: frames})
    benchmark.pedantic(passes, rounds=3)
    passes.close()


class Passes:
    """The forward passes of some frames in a process per core, which hold the images."""

    def __init__(self, root: Path, frames: dict[str, dict[str, tuple[int, ...]]]) -> None:
        chosen = [
            (str(root), name, view, frame)
            for name, views in frames.items()
            for view in METHOD_VIEWS
            for frame in views[view]
        ]
        self._shares = [chosen[first :: cores()] for first in range(cores())]
        self._processes = Processes(cores(), stays=True)
        self()

    def __call__(self) -> None:
        outcomes = list(self._processes(forward_passes, self._shares))
        assert [outcome.problem for outcome in outcomes] == [""] * cores()

    def close(self) -> None:
        self._processes.close()


IMAGES: dict[tuple[str, str, str, int], object] = {}
NETWORKS: list[object] = []


def forward_passes(chosen: list[tuple[str, str, str, int]]) -> dict[str, int]:
    """Run the network on images that are decoded at the first call only."""
    import torch  # noqa: PLC0415 - in the other process

    from corsmal.detection import SmallDetector  # noqa: PLC0415
    from corsmal.weights import bundled_path  # noqa: PLC0415

    if not NETWORKS:
        NETWORKS.append(SmallDetector(bundled_path("detector"))._network)
    for key in set(chosen) - IMAGES.keys():
        root, name, view, frame = key
        with open_dataset(root)[name].views[view].video() as video:
            IMAGES[key] = torch.from_numpy(video[frame].copy()).permute(2, 0, 1) / 255
    with torch.inference_mode():
        for first in range(0, len(chosen), 2):
            NETWORKS[0]([IMAGES[key] for key in chosen[first : first + 2]])  # type: ignore[operator]
    return {"passes": len(chosen)}
