import numpy as np
import pytest

from corsmal.dataset import Recording, View
from corsmal.detection import Detections, ViewDetections
from corsmal.detection.parquet import write_parquet
from corsmal.errors import FileError, NotFoundError
from corsmal.stages.true_masks import true_masks, true_views

MASK = np.eye(4, 6, dtype=bool)


@pytest.fixture
def recording(tmp_path):
    """A recording with true masks of one frame in view1 and none in view3."""
    path = tmp_path / "truth" / "visible" / "view1" / "000000.parquet"
    path.parent.mkdir(parents=True)
    found = Detections([[0, 0, 4, 4]], [1.0], [47], MASK[None])
    write_parquet(ViewDetections({7: found}, size=(4, 6), source="truth"), path)
    views = {name: View(name, tmp_path / f"{name}.mp4") for name in ("view1", "view3")}
    return Recording("000000", views, truth_path=tmp_path / "truth" / "000000.json")


def test_masks_are_read_as_detections(recording):
    masks = true_masks(recording, "view1")
    assert masks.frames == (7,)
    np.testing.assert_array_equal(masks[7].mask(0), MASK)


def test_missing_masks_are_named(recording):
    with pytest.raises(NotFoundError, match=r"view3/000000\.parquet: the true masks are missing"):
        true_views(recording)
    with pytest.raises(NotFoundError, match="amodal/view1"):
        true_masks(recording, "view1", kind="amodal")


def test_broken_masks_are_reported(recording, tmp_path):
    (tmp_path / "truth" / "visible" / "view1" / "000000.parquet").write_bytes(b"PAR1")
    with pytest.raises(FileError, match="is broken; delete it"):
        true_masks(recording, "view1")
