"""Hundreds of recordings, by the commands' own functions. Compare the rows of one run."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import av
import pytest
import soundfile
from pytest_benchmark.fixture import BenchmarkFixture

from corsmal.dataset import Dataset, open_dataset
from corsmal.engines.engine import in_turn
from corsmal.engines.local import local_engine
from corsmal.engines.processes import cores
from corsmal.parameters import ShapeParameters
from corsmal.runs import make_run
from corsmal.stages.settings import EstimateSettings, default_settings
from corsmal.store import Store
from tests.benchmarks.conftest import REAL

RECORDINGS, MANY = 30, 684
IDS = [f"{number:06d}" for number in range(RECORDINGS)]

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


@pytest.fixture(scope="module")
def many(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return copies(tmp_path_factory.mktemp("doctor"), MANY)


@pytest.fixture(scope="module")
def thirty(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return open_dataset(copies(tmp_path_factory.mktemp("run"), RECORDINGS))


@pytest.fixture
def fresh(tmp_path: Path) -> Callable[[], Store]:
    numbers = iter(range(100))
    return lambda: Store(tmp_path / str(next(numbers)))


def settings_of(dataset: Dataset, preset: str) -> EstimateSettings:
    return default_settings(dataset, shape=getattr(ShapeParameters, preset)(), filling="demo", mass="demo")


@estimating
@pytest.mark.goal(ratio=1.2)
@pytest.mark.parametrize("preset", ["paper", "tuned"])
def test_run_of_30_recordings(benchmark: BenchmarkFixture, thirty: Dataset, fresh, preset: str) -> None:
    """From detections, with the processes' start."""

    def run() -> None:
        made = make_run(
            None, thirty, settings_of(thirty, preset), store=fresh(), recordings=IDS, engine=local_engine(RECORDINGS)
        )
        assert len(made.rows) == RECORDINGS

    benchmark.pedantic(run, rounds=2)


@estimating
@pytest.mark.parametrize("preset", ["paper", "tuned"])
def test_bare_estimates_of_a_core_s_share(benchmark: BenchmarkFixture, thirty: Dataset, fresh, preset: str) -> None:
    """One after the other, in a process that has everything imported and read."""

    def run(share: list[str]) -> None:
        make_run(None, thirty, settings_of(thirty, preset), store=fresh(), recordings=share, engine=in_turn)

    run(IDS[:1])
    benchmark.pedantic(run, args=(IDS[: RECORDINGS // cores()],), rounds=2)


@examining
@pytest.mark.goal(seconds=45)
def test_doctor_of_684_recordings(benchmark: BenchmarkFixture, many: Path) -> None:
    command = [sys.executable, "-m", "corsmal", "doctor", str(many)]
    benchmark.pedantic(subprocess.run, args=(command,), kwargs={"check": True, "capture_output": True}, rounds=1)


@examining
def test_bare_opening_of_the_headers(benchmark: BenchmarkFixture, many: Path) -> None:
    def opened() -> None:
        for path in many.glob("view*/rgb/*.mp4"):
            av.open(str(path)).close()
        for path in many.glob("audio/*.wav"):
            soundfile.info(path)

    benchmark.pedantic(opened, rounds=1)
