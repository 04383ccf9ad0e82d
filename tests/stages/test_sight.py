import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.errors import NotFoundError
from corsmal.stages.sight import recording_sight
from corsmal.store import Store
from tests.tiny import write_tiny_dataset


class FakeNetwork:
    """Two rows of a view: its first frame's mean, and how wide it is shown; ``calls`` counts."""

    def __init__(self, digest="first"):
        self.digest, self.calls = digest, 0

    def rows(self, frames, *, crop=None):
        self.calls += 1
        first = np.asarray(next(iter(frames)), dtype=np.float32)
        width = first.shape[1] if crop is None else crop[2] - crop[0]
        return np.repeat(np.array([[first.mean() / 256], [width / 256]], np.float32), 512, axis=1)


@pytest.fixture
def root(tmp_path):
    return write_tiny_dataset(tmp_path / "set", recordings=1, frames=3)


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "cache")


def test_rows_stand_in_the_order_of_the_views_and_are_kept(root, store):
    recording, network = open_dataset(root)["000000"], FakeNetwork()
    sight = recording_sight(recording, network, store=store)
    assert (sight.shape, sight.dtype) == ((3, 2, 512), np.float16)
    for index, name in enumerate(("view1", "view2", "view3")):
        with recording.views[name].video() as video:
            assert float(sight[index, 0, 0]) == pytest.approx(video[0].mean() / 256, abs=1e-3)
    assert network.calls == 3
    assert np.array_equal(recording_sight(recording, network, store=store), sight)
    assert network.calls == 3
    recording_sight(recording, FakeNetwork("second"), store=store)
    assert network.calls == 3


def test_missing_view_is_zero_and_no_view_is_refused(root, store):
    (root / "view2" / "rgb" / "000000.mp4").unlink()
    sight = recording_sight(open_dataset(root)["000000"], FakeNetwork(), store=store)
    assert sight[0].any()
    assert not sight[1].any()
    for name in ("view1", "view3"):
        (root / name / "rgb" / "000000.mp4").unlink()
    with pytest.raises(NotFoundError, match="no videos"):
        recording_sight(open_dataset(root)["000000"], FakeNetwork(), store=store)


def test_network_may_be_shown_the_container_only(root, store):
    recording = open_dataset(root)["000000"]
    whole = recording_sight(recording, FakeNetwork(), store=store)
    near = recording_sight(recording, FakeNetwork(), store=store, around_container=True)
    assert (near[:, 1, 0] < whole[:, 1, 0]).all()
    (root / "view1" / "detections" / "000000.json").unlink()
    again = recording_sight(open_dataset(root)["000000"], FakeNetwork(), store=store, around_container=True)
    assert again[0, 1, 0] == whole[0, 1, 0]
    assert again[1, 1, 0] == near[1, 1, 0]
