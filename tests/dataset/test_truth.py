from pathlib import Path

import pytest

from corsmal.dataset import Recording
from corsmal.dataset.truth import true_mask_path
from corsmal.errors import NotFoundError


def test_the_masks_of_a_synthetic_recording_lie_beside_its_truth():
    recording = Recording("000003", truth_path=Path("demo/truth/000003.json"))
    assert recording.is_synthetic
    found = true_mask_path(recording, "view1", kind="amodal")
    assert found == Path("demo/truth/amodal/view1/000003.parquet")


def test_a_real_recording_has_no_truth():
    recording = Recording("000618")
    assert not recording.is_synthetic
    with pytest.raises(NotFoundError, match="recording 000618 has no truth"):
        true_mask_path(recording, "view1", kind="amodal")
