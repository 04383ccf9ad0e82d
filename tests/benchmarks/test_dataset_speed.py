from pathlib import Path

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from corsmal.dataset import Video, open_dataset
from tests.tiny import CONTAINERS, annotation_row, write_json, write_video

RECORDINGS = 684


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


def test_index_684_recordings(benchmark: BenchmarkFixture, large_root: Path) -> None:
    dataset = benchmark(open_dataset, large_root)
    assert len(dataset) == RECORDINGS
    assert dataset.table["missing"].eq("").all()


def test_tabulate_684_recordings(benchmark: BenchmarkFixture, large_root: Path) -> None:
    table = benchmark(lambda: open_dataset(large_root).table)
    assert len(table) == RECORDINGS


@pytest.mark.parametrize("step", [1, -1])
def test_step_through_a_video(benchmark: BenchmarkFixture, tmp_path: Path, step: int) -> None:
    images = [np.full((180, 320, 3), number, dtype=np.uint8) for number in range(60)]
    with Video(write_video(tmp_path / "v.mp4", images, gop=250)) as video:
        frames = benchmark(lambda: [video[index].shape for index in range(len(video))[::step]])
        assert len(frames) == 60
