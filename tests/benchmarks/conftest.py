"""The recording that is measured on, and one table at the end: every stage beside the bare cost of its group.

A group holds what stands beside one bare cost, a test whose name begins with ``test_bare``; where the bare cost has
parameters, each stands beside its own. Tests named ``test_plain`` are the same done the obvious way; they are left out.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from corsmal.dataset import Recording, open_dataset
from corsmal.estimation import Fit, container_mask, fit_frame
from corsmal.parameters import METHOD_VIEWS, PAIRS, SelectionParameters, ShapeParameters
from corsmal.selection import BestFrame, select_best_frame
from corsmal.stages.detections import DetectionSet, load_detections
from corsmal.store import Store
from tests.tiny import write_tiny_dataset

REAL = Path(__file__).resolve().parents[3] / "shared" / "ccm" / "train"
BARE, PLAIN = "bare ", "plain "


@dataclass(frozen=True)
class Measured:
    """The median time of one test."""

    name: str
    group: str
    case: str | None
    median_s: float


MEASURED = pytest.StashKey[list[Measured]]()


@pytest.fixture(autouse=True)
def _compared(benchmark: BenchmarkFixture, request: pytest.FixtureRequest) -> None:
    """What is only there to be compared with needs no run where nothing is measured."""
    if not benchmark.enabled and request.node.originalname.startswith(("test_bare", "test_plain")):
        benchmark(int)  # else the plugin warns that its fixture was not used
        pytest.skip("nothing is measured")


@pytest.fixture(autouse=True)
def _noted(benchmark: BenchmarkFixture, request: pytest.FixtureRequest) -> Iterator[None]:
    yield
    if benchmark.stats is not None:
        words = request.node.originalname.removeprefix("test_").replace("_", " ")
        measured = Measured(words, benchmark.group, benchmark.param, benchmark.stats.stats.median)
        request.config.stash.setdefault(MEASURED, []).append(measured)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Print the table, the largest ratio first."""
    found = config.stash.get(MEASURED, [])
    bare = {(row.group, row.case): row for row in found if row.name.startswith(BARE)}
    rows = []
    for row in found:
        beside = bare.get((row.group, row.case)) or bare.get((row.group, None))
        if beside is not None and not row.name.startswith((BARE, PLAIN)):
            name = row.name if row.case is None else f"{row.name}, {row.case}"
            rows.append((row.median_s / beside.median_s, name, row.median_s, beside))
    if rows:
        terminalreporter.section("medians, ms")
        terminalreporter.line(f"{'stage':<50} {'ours':>9} {'bare':>9} {'ratio':>7}  what the bare cost is")
    for ratio, name, ours_s, beside in sorted(rows, key=lambda row: -row[0]):
        times = f"{1000 * ours_s:9.3f} {1000 * beside.median_s:9.3f} {ratio:7.2f}"
        terminalreporter.line(f"{name:<50} {times}  {beside.name.removeprefix(BARE)}")


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

    def fit(self, shape: ShapeParameters) -> Fit:
        return fit_frame(
            self.recording,
            self.found.views,
            pair=PAIRS[0],
            frame=self.frame,
            centre_rule=self.best.centre_rule,
            shape=shape,
        )


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """The real recording 000618; where it is absent, a generated one of the same size."""
    if REAL.is_dir():
        return open_dataset(REAL)["000618"]
    root = write_tiny_dataset(tmp_path_factory.mktemp("large"), recordings=1, size=(1280, 720), frames=40)
    return open_dataset(root)["000000"]


@pytest.fixture(scope="session")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    return Store(tmp_path_factory.mktemp("cache"))


@pytest.fixture(scope="session")
def opened(recording: Recording, store: Store) -> Opened:
    found = load_detections(recording, store=store)
    return Opened(recording, found, select_best_frame(found.views, pair=PAIRS[0]))


@pytest.fixture(scope="session")
def cameras(recording: Recording):
    return {name: recording.views[name].camera() for name in METHOD_VIEWS}


@pytest.fixture(scope="session")
def images(opened: Opened):
    pictures = {}
    for view in METHOD_VIEWS:
        with opened.recording.views[view].video() as video:
            pictures[view] = video[opened.frame]
    return pictures
