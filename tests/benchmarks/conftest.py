"""The recording that is measured on, and one table at the end: every stage beside the bare cost of its group.

A group holds what stands beside one bare cost, a test whose name begins with ``test_bare``; where the bare cost has
parameters, each stands beside its own. Tests named ``test_plain`` are the same done the obvious way; they are left out.
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from corsmal.dataset import Recording, open_dataset
from corsmal.engines.processes import cores
from corsmal.estimation import Fit, container_mask, fit_frame
from corsmal.parameters import METHOD_VIEWS, PAIRS, SelectionParameters, ShapeParameters
from corsmal.selection import BestFrame, select_best_frame
from corsmal.stages.detections import DetectionSet, load_detections
from corsmal.store import Store
from tests.tiny import write_tiny_dataset

REAL = Path(__file__).resolve().parents[3] / "shared" / "ccm" / "train"
BARE, PLAIN = "bare ", "plain "


@dataclass(frozen=True)
class Goal:
    """The most that a test may take: a ratio to its bare cost, or seconds where the goal is one of waiting."""

    ratio: float | None = None
    seconds: float | None = None

    def __str__(self) -> str:
        return "" if self == Goal() else f"{self.ratio:g} x" if self.ratio else f"{1000 * (self.seconds or 0):g} ms"


@dataclass(frozen=True)
class Measured:
    """The median time of one test."""

    name: str
    group: str
    case: str | None
    median_s: float
    goal: Goal = Goal()


@dataclass(frozen=True)
class Row:
    """A line of the table."""

    ours: Measured
    bare: Measured

    @property
    def work(self) -> str:
        return self.ours.name if self.ours.case is None else f"{self.ours.name}, {self.ours.case}"

    @property
    def ratio(self) -> float:
        return self.ours.median_s / self.bare.median_s

    @property
    def verdict(self) -> str:
        goal = self.ours.goal
        if goal == Goal():
            return ""
        is_met = self.ratio <= goal.ratio if goal.ratio else self.ours.median_s <= (goal.seconds or 0)
        return "met" if is_met else "not met"

    @property
    def cells(self) -> tuple[str, ...]:
        times = (f"{1000 * each.median_s:.2f}" for each in (self.ours, self.bare))
        return (
            self.work,
            self.bare.name.removeprefix(BARE),
            *times,
            f"{self.ratio:.2f}",
            str(self.ours.goal),
            self.verdict,
        )


MEASURED = pytest.StashKey[list[Measured]]()
COLUMNS = ("work", "bare cost", "ours, ms", "bare, ms", "ratio", "goal", "")


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("benchmarks of corsmal")
    group.addoption("--long", action="store_true", help="Measure also what takes minutes.")
    group.addoption("--table", type=Path, help="Write the table to this file, in Markdown.")


@pytest.fixture(autouse=True)
def _compared(benchmark: BenchmarkFixture, request: pytest.FixtureRequest) -> None:
    """What is only there to be compared with needs no run where nothing is measured."""
    if not benchmark.enabled and request.node.originalname.startswith(("test_bare", "test_plain")):
        benchmark(int)  # else the plugin warns that its fixture was not used
        pytest.skip("nothing is measured")
    if (
        benchmark.enabled
        and request.node.get_closest_marker("long")
        and not request.config.getoption("--long", default=False)
    ):
        benchmark(int)
        pytest.skip("takes minutes; --long measures it")


@pytest.fixture(autouse=True)
def _noted(benchmark: BenchmarkFixture, request: pytest.FixtureRequest, _compared: None) -> Iterator[None]:
    yield
    if benchmark.stats is not None:
        words = request.node.originalname.removeprefix("test_").replace("_", " ")
        marker = request.node.get_closest_marker("goal")
        goal = Goal(**marker.kwargs) if marker else Goal()
        measured = Measured(words, benchmark.group, benchmark.param, benchmark.stats.stats.median, goal)
        request.config.stash.setdefault(MEASURED, []).append(measured)


def rows_of(found: list[Measured]) -> list[Row]:
    """The lines of the table: those with a goal first, the largest ratio first."""
    bare = {(row.group, row.case): row for row in found if row.name.startswith(BARE)}
    rows = []
    for row in found:
        beside = bare.get((row.group, row.case)) or bare.get((row.group, None))
        if beside is not None and not row.name.startswith((BARE, PLAIN)):
            rows.append(Row(row, beside))
    return sorted(rows, key=lambda row: (not row.verdict, -row.ratio))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Print the table, and write it where it was asked for."""
    rows = rows_of(config.stash.get(MEASURED, []))
    if not rows:
        return
    lines = [COLUMNS, *(row.cells for row in rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    terminalreporter.section(f"medians on {machine()}")
    for line in lines:
        terminalreporter.line("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip())
    path = config.getoption("--table", default=None)
    if path is not None:
        ruled = [COLUMNS, ("---",) * len(COLUMNS), *lines[1:]]
        table = "\n".join(f"| {' | '.join(cells)} |" for cells in ruled)
        path.write_text(f"Medians on {machine()}.\n\n{table}\n", encoding="utf-8")


def machine() -> str:
    """The processor, its instructions, cores and load."""
    import torch  # noqa: PLC0415 - only where something was measured

    described = Path("/proc/cpuinfo").read_text(encoding="utf-8") if Path("/proc/cpuinfo").exists() else ""
    name = next(
        (line.split(": ", 1)[1] for line in described.splitlines() if line.startswith("model name")), "a processor"
    )
    load = f", load {os.getloadavg()[0]:.1f} at the end" if hasattr(os, "getloadavg") else ""
    return f"{name}, {torch.backends.cpu.get_cpu_capability()}, {cores()} cores{load}"


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
