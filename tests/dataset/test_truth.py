import json
import math

import numpy as np
import pytest

from corsmal.dataset import Recording
from corsmal.dataset.truth import read_truth, true_mask_path
from corsmal.errors import FileError, NotFoundError

CONTENT = {
    "base_m": [[0, 0, 0.1], [0, 0, 0.2]],
    "rotation": [np.eye(3).tolist()] * 2,
    "fill": [0, 0.5],
    "profile": {
        "outer_heights_mm": [0, 72],
        "outer_radii_mm": [21, 34.5],
        "inner_heights_mm": [],
        "inner_radii_mm": [],
    },
    "events_s": {"lift_s": 1.5},
}


@pytest.fixture
def recording(tmp_path):
    """A synthetic recording of two frames; ``CONTENT`` is its truth."""
    path = tmp_path / "truth" / "000003.json"
    path.parent.mkdir()
    path.write_text(json.dumps(CONTENT), encoding="utf-8")
    return Recording("000003", truth_path=path)


def test_the_truth_is_what_the_file_says(recording):
    truth = read_truth(recording)
    assert truth.base_m[1].tolist() == [0, 0, 0.2]
    assert truth.rotation.shape == (2, 3, 3)
    assert truth.fill.tolist() == [0, 0.5]
    assert math.isclose(truth.profile_mm[1][1], 34.5)
    assert truth.events_s == {"lift_s": 1.5}


def test_boxes_have_no_profile(recording):
    recording.truth_path.write_text(json.dumps(CONTENT | {"profile": None}), encoding="utf-8")
    assert read_truth(recording).profile_mm is None


@pytest.mark.parametrize(
    "content",
    ["", "[]", '{"base_m": 3}', json.dumps(CONTENT | {"fill": [0]}), json.dumps(CONTENT | {"profile": {"outer": 1}})],
)
def test_a_broken_file_is_reported(recording, content):
    recording.truth_path.write_text(content, encoding="utf-8")
    with pytest.raises(FileError, match=r"000003\.json: is broken.*delete it"):
        read_truth(recording)


def test_a_real_recording_has_no_truth():
    recording = Recording("000618")
    assert not recording.is_synthetic
    with pytest.raises(NotFoundError, match="recording 000618 has no truth"):
        read_truth(recording)
    with pytest.raises(NotFoundError, match="recording 000618 has no truth"):
        true_mask_path(recording, "view1", kind="amodal")
