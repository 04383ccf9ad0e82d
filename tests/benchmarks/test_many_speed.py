"""Hundreds of recordings, by the commands' own functions. Compare the rows of one run."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import av
import pytest
import soundfile
from pytest_benchmark.fixture import BenchmarkFixture

from corsmal.dataset import Dataset, open_dataset
from corsmal.engines.engine import Engine, in_turn
from corsmal.engines.local import local_engine
from corsmal.engines.processes import cores
from corsmal.parameters import ShapeParameters
from corsmal.runs import make_run
from corsmal.stages.settings import EstimateSettings, default_settings
from corsmal.store import Store
from tests.benchmarks.conftest import REAL

RECORDINGS, MANY, FEW = 30, 684, 2
"""The last where nothing is measured."""

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not REAL.is_dir(), reason="needs the real recording, which is copied"),
]
estimating = pytest.mark.benchmark(group="run")
examining = pytest.mark.benchmark(group="doctor")


def copies(folder: Path, count: int) -> Path:
    """A dataset of one real recording, many times: links to a copy of its files."""
    one = Path(shutil.copytree(REAL, folder / "one"))
    for path in [path for path in one.rglob("*") if path.is_file()]:
        place = folder / "many" / path.relative_to(one)
        place.parent.mkdir(parents=True, exist_ok=True)
        if path.stem != "000618":
            os.link(path, place)
            continue
        for number in range(count):
            os.link(path, place.with_stem(f"{number:06d}"))
    return folder / "many"


@pytest.fixture
def many(benchmark: BenchmarkFixture, tmp_path: Path) -> Path:
    return copies(tmp_path, MANY if benchmark.enabled else FEW)


@pytest.fixture
def thirty(benchmark: BenchmarkFixture, tmp_path: Path) -> Dataset:
    return open_dataset(copies(tmp_path, RECORDINGS if benchmark.enabled else FEW))


@pytest.fixture
def ids(benchmark: BenchmarkFixture) -> list[str]:
    return [f"{number:06d}" for number in range(RECORDINGS if benchmark.enabled else FEW)]


@pytest.fixture
def fresh(tmp_path: Path) -> Callable[[], Store]:
    numbers = iter(range(100))
    return lambda: Store(tmp_path / str(next(numbers)))


def settings_of(dataset: Dataset, preset: str) -> EstimateSettings:
    return default_settings(dataset, shape=getattr(ShapeParameters, preset)(), filling="demo", mass="demo")


@estimating
@pytest.mark.goal(ratio=1.2)
@pytest.mark.parametrize("preset", ["paper", "tuned"])
def test_run_of_30_recordings(benchmark: BenchmarkFixture, thirty: Dataset, ids, fresh, preset: str) -> None:
    """From detections, with the start of the workers, by a process that has everything imported and read."""

    def run(engine: Engine, wanted: list[str]) -> None:
        made = make_run(None, thirty, settings_of(thirty, preset), store=fresh(), recordings=wanted, engine=engine)
        assert len(made.rows) == len(wanted)

    run(in_turn, ids[:1])
    benchmark.pedantic(run, args=(local_engine(len(ids), forks=True), ids), rounds=2)


@estimating
@pytest.mark.parametrize("preset", ["paper", "tuned"])
def test_bare_estimates_of_a_core_s_share(
    benchmark: BenchmarkFixture, thirty: Dataset, ids, fresh, preset: str
) -> None:
    """One after the other, in a process that has everything imported and read."""

    def run(share: list[str]) -> None:
        make_run(None, thirty, settings_of(thirty, preset), store=fresh(), recordings=share, engine=in_turn)

    run(ids[:1])
    benchmark.pedantic(run, args=(ids[: max(1, len(ids) // cores())],), rounds=2)


@examining
@pytest.mark.goal(seconds=45)
def test_doctor_of_684_recordings(benchmark: BenchmarkFixture, many: Path) -> None:
    command = [sys.executable, "-m", "corsmal", "doctor", str(many)]
    run = partial(subprocess.run, command, check=False, capture_output=True, text=True)
    assert "every file can be read" in benchmark.pedantic(run, rounds=1).stdout


@examining
def test_bare_opening_of_the_headers(benchmark: BenchmarkFixture, many: Path) -> None:
    def opened() -> None:
        for path in many.glob("view*/rgb/*.mp4"):
            av.open(str(path)).close()
        for path in many.glob("audio/*.wav"):
            soundfile.info(path)

    benchmark.pedantic(opened, rounds=1)
