"""The path only: the network's weights are random ones."""

import numpy as np
import pytest
import torch
from torchvision.models.video import r2plus1d_18

from corsmal.detection import coco_weights
from corsmal.errors import ArgumentError, FileError
from corsmal.filling.clips import CLIP_WEIGHTS_URL, DEVIATION, MEAN, ClipNetwork, _clips, seen_by_network, square_around


@pytest.fixture(scope="module")
def weights(tmp_path_factory):
    """Of a randomly initialised R(2+1)D-18, with torchvision's names."""
    torch.manual_seed(0)
    path = tmp_path_factory.mktemp("clips") / "untrained.pth"
    torch.save(r2plus1d_18(weights=None).state_dict(), path)
    return path


def frames(count, *, seed=0):
    rng = np.random.default_rng(seed)
    return [rng.integers(0, 256, (72, 128, 3), dtype=np.uint8) for _ in range(count)]


def test_a_clip_becomes_the_networks_last_features(weights):
    given = frames(16)
    rows = ClipNetwork(weights, device="cpu").rows(given)
    network = r2plus1d_18(weights=None).eval()
    network.load_state_dict(torch.load(weights, weights_only=True))
    kept = []
    network.avgpool.register_forward_hook(lambda *call: kept.append(call[2].flatten(1)))
    clip = np.stack([seen_by_network(frame) for frame in given])
    with torch.inference_mode():
        network(torch.from_numpy(clip).permute(3, 0, 1, 2)[None])
    assert rows.shape == (1, 512)
    assert rows == pytest.approx(kept[0].numpy(), abs=1e-4)


def test_a_video_is_cut_into_whole_clips():
    given = [np.full((112, 112, 3), number, np.float32) for number in range(37)]
    found = [clip[:, 0, 0, 0].tolist() for clip in _clips(iter(given))]
    assert found == [list(range(16)), list(range(16, 32))]
    [short] = _clips(iter(given[:3]))
    assert short[:, 0, 0, 0].tolist() == [0, 1, 2] + [2] * 13
    assert list(_clips(iter([]))) == []


def test_the_middle_of_the_picture_is_seen_standardised():
    frame = np.zeros((128, 171, 3), np.uint8)
    frame[8:120, 29:141] = (255, 0, 51)  # the 112 x 112 in its middle
    seen = seen_by_network(frame)
    assert seen.shape == (112, 112, 3)
    assert seen[0, 0] == pytest.approx((np.array([1, 0, 0.2]) - MEAN) / DEVIATION, abs=1e-5)
    assert np.ptp(seen.reshape(-1, 3), axis=0).max() == 0
    crop = seen_by_network(frame, crop=(29, 8, 141, 120))
    assert np.array_equal(crop, seen)
    for wrong in ((0, 0, 0, 10), (-1, 0, 10, 10), (0, 0, 172, 10)):
        with pytest.raises(ArgumentError, match="crop must lie"):
            seen_by_network(frame, crop=wrong)


def test_square_holds_all_boxes_and_stays_in_the_picture():
    boxes = np.array([[40, 40, 50, 60], [45, 42, 60, 50]], np.float64)
    assert square_around(boxes, width=200, height=100) == (35, 35, 65, 65)  # 20 x 20 and half as much again
    assert square_around(np.array([[0.0, 0, 20, 20]]), width=200, height=100) == (0, 0, 30, 30)
    assert square_around(np.array([[0.0, 0, 190, 90]]), width=200, height=100) == (45, 0, 145, 100)


def test_no_frame_is_refused(weights):
    with pytest.raises(ArgumentError, match="at least one frame"):
        ClipNetwork(weights, device="cpu").rows([])


def test_other_files_are_refused(tmp_path):
    torch.save({"conv.weight": torch.zeros(1)}, tmp_path / "other.pth")
    (tmp_path / "text.pth").write_text("weights", encoding="utf-8")
    for name in ("other.pth", "text.pth", "absent.pth"):
        with pytest.raises(FileError, match="not a file of the weights of R"):
            ClipNetwork(tmp_path / name, device="cpu")


def test_without_internet_one_sentence_says_what_to_put_where(tmp_path, monkeypatch):
    def offline(*_args, **_options):
        raise OSError("no network")

    monkeypatch.setenv("CORSMAL_WEIGHTS", str(tmp_path))
    monkeypatch.setattr(coco_weights.urllib.request, "urlopen", offline)
    with pytest.raises(FileError, match=r"download https.* and put it there") as raised:
        ClipNetwork(device="cpu")
    assert raised.value.path == tmp_path / CLIP_WEIGHTS_URL.rsplit("/", 1)[-1]
