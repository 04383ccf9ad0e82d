import shutil

import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.parameters import PAIRS
from corsmal.stages.detections import load_detections
from corsmal.stages.examination import ExamineTask, reprojection_error
from tests.tiny import write_tiny_dataset


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return write_tiny_dataset(tmp_path_factory.mktemp("set"), recordings=2, frames=4)


@pytest.fixture
def root(made, tmp_path):
    """A copy that a test may damage."""
    return shutil.copytree(made, tmp_path / "set")


def examined(root, tmp_path, *, deep=False):
    task = ExamineTask(tmp_path / "cache", deep=deep)
    return [task(recording) for recording in open_dataset(root)]


def named(row):
    return [str(finding) for finding in row["findings"]]


def test_sound_recordings_agree_and_nothing_is_broken(root, tmp_path):
    first, second = examined(root, tmp_path)
    assert (first["recording_id"], first["findings"], second["findings"]) == ("000000", [], [])
    assert max(first["reprojection"], second["reprojection"]) < 0.003  # the second lacks a view


@pytest.mark.parametrize(
    "file", ["view1/rgb/000000.mp4", "view2/calib/000000.pickle", "view3/detections/000000.json", "audio/000000.wav"]
)
def test_every_broken_file_is_named_once(root, tmp_path, file):
    (root / file).write_bytes(b"broken")
    first, second = examined(root, tmp_path)
    assert any(str(root / file) in sentence for sentence in named(first))
    assert len(first["findings"]) == len(set(first["findings"]))
    assert {(finding.severity, finding.recording) for finding in first["findings"]} == {("error", "000000")}
    assert second["findings"] == []


def test_a_video_that_breaks_off_is_found(root, tmp_path):
    path = root / "view1" / "rgb" / "000000.mp4"
    content = bytearray(path.read_bytes())
    start = content.index(b"mdat")
    content[start + 200 : start + 4000] = bytes(3800)
    path.write_bytes(content)
    assert any(str(path) in sentence for sentence in named(examined(root, tmp_path, deep=True)[0]))


def test_the_calibration_of_another_camera_does_not_agree(root, tmp_path):
    calib = {view: root / view / "calib" / "000000.pickle" for view in ("view1", "view3")}
    contents = {view: path.read_bytes() for view, path in calib.items()}
    calib["view1"].write_bytes(contents["view3"])
    calib["view3"].write_bytes(contents["view1"])
    assert examined(root, tmp_path)[0]["reprojection"] > 0.01  # the cup stands where the cameras look, all but mirrored


def test_the_error_is_the_distance_of_a_shifted_mask(made, store):
    """Two cameras side by side: a shift across the line between them cannot be explained by any point."""
    recording = open_dataset(made)["000000"]
    detections = load_detections(recording, store=store)
    cameras = {name: recording.views[name].camera() for name in PAIRS[0]}
    assert reprojection_error(detections, {"view3": cameras["view3"]}) is None
    honest = reprojection_error(detections, cameras)
    tilted = {**cameras, "view3": shifted(cameras["view3"], 40.0)}
    error = reprojection_error(detections, tilted)
    # half of the shift falls to each view, less what a nearer or farther point takes up
    assert honest < 0.003 < error < 40 / 640


def shifted(camera, pixels):
    intrinsic = np.array(camera.intrinsic)
    intrinsic[1, 2] += pixels
    return type(camera)(intrinsic, camera.rotation, camera.translation, camera.size)
