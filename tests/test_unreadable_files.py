"""A dataset in which something else stands in the place of a file, or a file that may not be read."""

import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from corsmal.dataset import open_dataset
from corsmal.filling import FillingPredictor
from corsmal.stages.estimates import Predictors, load_estimate
from corsmal.stages.examination import ExamineTask
from corsmal.store import Store
from corsmal.weights import network_digest
from tests.networks import write_networks
from tests.test_store import DAMAGES, as_another_user
from tests.tiny import write_tiny_dataset

FILES = {
    "video": "view1/rgb/000000.mp4",
    "calibration": "view3/calib/000000.pickle",
    "detections": "view1/detections/000000.json",
    "sound": "audio/000000.wav",
    "annotation": "ccm_tiny_annotation.json",
}
OTHERS = ("folder", "pipe", "socket", "link to nowhere", "link to itself", "endless")


@pytest.fixture(scope="module")
def made() -> Iterator[Path]:
    with tempfile.TemporaryDirectory() as folder:  # pytest's own folders are closed to others
        os.chmod(folder, 0o777)
        write_tiny_dataset(Path(folder) / "made", recordings=1, frames=4)
        yield Path(folder)


@pytest.fixture
def root(made: Path) -> Iterator[Path]:
    yield Path(shutil.copytree(made / "made", made / "train"))
    shutil.rmtree(made / "train")


@pytest.fixture(scope="module")
def predictors(tmp_path_factory: pytest.TempPathFactory) -> Predictors:
    paths = write_networks(tmp_path_factory.mktemp("networks"))
    return Predictors(filling=FillingPredictor(paths["filling"]))


def row_of(root: Path, predictors: Predictors, store: Store) -> dict[str, object]:
    """The row of the only recording, after it was examined."""
    [recording] = open_dataset(root)
    ExamineTask(store.root)(recording)
    return load_estimate(recording, predictors, store=store)


@pytest.mark.parametrize("what", OTHERS)
@pytest.mark.parametrize("part", FILES)
def test_what_is_no_file_is_as_good_as_absent_and_named(root, predictors, store, part, what):
    DAMAGES[what](root / FILES[part])
    row = row_of(root, predictors, store)
    assert "unexpectedly" not in str(row["notes"])
    assert "\n" not in str(row["notes"])
    found = open_dataset(root)
    said = "; ".join([*map(str, found.findings), *found["000000"].missing, *found.problems])
    assert part in said or Path(FILES[part]).name in said or "whole set has no" in said


@pytest.mark.parametrize("part", FILES)
def test_a_file_that_may_not_be_read_costs_its_part_and_is_named(root, predictors, part):
    path = root / FILES[part]
    path.chmod(0)
    with as_another_user():
        row = row_of(root, predictors, Store(root.parent / "cache"))
        found = open_dataset(root)
    assert "unexpectedly" not in str(row["notes"])
    assert "\n" not in str(row["notes"])
    assert path.name in "; ".join([str(row["notes"]), *map(str, found.findings), *found.problems])
    path.chmod(0o644)
    again = row_of(root, predictors, Store(root.parent / "cache"))
    assert (again["status"], "Permission denied" in str(again["notes"])) == ("fitted", False)


@pytest.mark.parametrize("what", OTHERS)
def test_weights_that_are_no_file_are_one_sentence(tmp_path, what):
    path = write_networks(tmp_path)["filling"]
    DAMAGES[what](path)
    for read in (FillingPredictor, lambda each: network_digest("filling", each)):
        with pytest.raises(Exception, match=path.name) as caught:
            read(path)
        assert type(caught.value).__name__ == "FileError"
        assert "\n" not in str(caught.value)
