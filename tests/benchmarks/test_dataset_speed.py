"""Reading a dataset. Compare the rows of one run, not the time of the day."""

import json
import os
import subprocess
import sys
from pathlib import Path

import av
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from corsmal.dataset import Recording, open_dataset
from corsmal.parameters import METHOD_VIEWS
from tests.tiny import CONTAINERS, annotation_row, write_json

ROOT = Path(__file__).resolve().parents[2]
RECORDINGS, FRAMES = 684, 30

indexing = pytest.mark.benchmark(group="index", max_time=0.5)
opening = pytest.mark.benchmark(group="open", max_time=0.3)
decoding = pytest.mark.benchmark(group="decode")
jumping = pytest.mark.benchmark(group="jump")
importing = pytest.mark.benchmark(group="import")


@pytest.fixture(scope="module")
def large_root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A set as large as the training set, of empty files."""
    root = tmp_path_factory.mktemp("large")
    parts = [
        (f"view{view}/{part}", suffix) for view in range(1, 5) for part, suffix in (("rgb", "mp4"), ("calib", "pickle"))
    ]
    for folder, suffix in (*parts, ("audio", "wav")):
        (root / folder).mkdir(parents=True)
        for number in range(RECORDINGS):
            (root / folder / f"{number:06d}.{suffix}").touch()
    rows = [annotation_row(number, CONTAINERS[number % 3]) for number in range(RECORDINGS)]
    write_json(root / "ccm_train_annotation.json", {"annotations": rows})
    return root


@indexing
def test_index_684_recordings(benchmark: BenchmarkFixture, large_root: Path) -> None:
    dataset = benchmark(open_dataset, large_root)
    assert len(dataset) == RECORDINGS
    assert dataset.table["missing"].eq("").all()


@indexing
def test_index_and_tabulate_684_recordings(benchmark: BenchmarkFixture, large_root: Path) -> None:
    assert len(benchmark(lambda: open_dataset(large_root).table)) == RECORDINGS


@indexing
def test_bare_listing_and_parsing_of_the_annotation(benchmark: BenchmarkFixture, large_root: Path) -> None:
    def listed() -> int:
        json.loads((large_root / "ccm_train_annotation.json").read_bytes())
        return sum(len(names) for _, _, names in os.walk(large_root))

    assert benchmark(listed) == 9 * RECORDINGS + 1


@opening
def test_open_three_videos(benchmark: BenchmarkFixture, recording: Recording) -> None:
    def frame_counts() -> list[int]:
        counts = []
        for view in METHOD_VIEWS:
            with recording.views[view].video() as video:
                counts.append(video.frame_count)
        return counts

    assert min(benchmark(frame_counts)) > FRAMES


@opening
def test_bare_opening_by_pyav(benchmark: BenchmarkFixture, recording: Recording) -> None:
    benchmark(lambda: [av.open(str(recording.views[view].video_path)).close() for view in METHOD_VIEWS])


@pytest.fixture(scope="module")
def video(recording: Recording):
    with recording.views["view3"].video() as video:
        yield video


@pytest.fixture(scope="module")
def container(recording: Recording):
    with av.open(str(recording.views["view3"].video_path)) as container:
        yield container


def decoded_from(container: av.container.InputContainer, pts: int):
    """Frames from the last key frame before a time stamp on."""
    container.seek(pts, stream=container.streams.video[0])
    return container.decode(video=0)


@decoding
@pytest.mark.parametrize("step", [1, -1], ids=["forwards", "backwards"])
def test_read_30_frames(benchmark: BenchmarkFixture, video, step: int) -> None:
    numbers = range(FRAMES)[::step]
    frames = benchmark.pedantic(lambda: [video[number].shape for number in numbers], rounds=8, warmup_rounds=1)
    assert len(frames) == FRAMES


@decoding
def test_bare_decoding_of_as_many_by_pyav(benchmark: BenchmarkFixture, container) -> None:
    def decode() -> list[tuple[int, ...]]:
        frames = decoded_from(container, 0)
        return [next(frames).to_ndarray(format="rgb24").shape for _ in range(FRAMES)]

    assert len(benchmark.pedantic(decode, rounds=8, warmup_rounds=1)) == FRAMES


def jumps(count: int) -> list[int]:
    """37 frames back each time, from the beginning."""
    return [(-37 * index) % count for index in range(12)]


@jumping
def test_read_12_frames_far_apart(benchmark: BenchmarkFixture, video) -> None:
    numbers = jumps(len(video))
    benchmark.pedantic(lambda: [video[number].shape for number in numbers], rounds=5, warmup_rounds=1)


@jumping
def test_bare_seeking_and_decoding_by_pyav(benchmark: BenchmarkFixture, video, container) -> None:
    times = [video._times[number] for number in jumps(len(video))]

    def seek() -> list[tuple[int, ...]]:
        wanted = [next(frame for frame in decoded_from(container, time) if frame.pts == time) for time in times]
        return [frame.to_ndarray(format="rgb24").shape for frame in wanted]

    benchmark.pedantic(seek, rounds=5, warmup_rounds=1)


def run_python(statement: str) -> None:
    subprocess.run([sys.executable, "-c", statement], check=True, cwd=ROOT)


@importing
@pytest.mark.parametrize("names", ["corsmal", "corsmal.dataset", "corsmal.stages, corsmal.engines, corsmal.figures"])
def test_start_python_and_import(benchmark: BenchmarkFixture, names: str) -> None:
    benchmark.pedantic(run_python, args=(f"import {names}",), rounds=3, warmup_rounds=1)


@importing
def test_bare_start_of_python(benchmark: BenchmarkFixture) -> None:
    benchmark.pedantic(run_python, args=("pass",), rounds=3, warmup_rounds=1)
