from itertools import islice

import numpy as np
import pytest
import torch

from corsmal.detection import SmallDetector
from corsmal.detection.small import SmallMaskRCNN, SmallMaskRCNNConfig, read_detector, save_detector
from corsmal.errors import FileError
from corsmal.synthetic.training.detector import begin_with, train_detector
from corsmal.synthetic.training.frames import (
    CONTAINER,
    JUG,
    DetectorTraining,
    RenderedFrames,
    as_target,
    augmented,
    cropped,
)

TINY = DetectorTraining(steps=2, batch=2, crop=(128, 96), whole=0.0, warm_up=1, replay=8)


@pytest.fixture
def sample():
    """A dark picture with a bright container of 40 x 30 pixels at the left."""
    image, objects = np.full((180, 320, 3), 30, np.uint8), np.zeros((180, 320), np.uint8)
    objects[60:90, 20:60] = CONTAINER
    image[objects == CONTAINER] = (200, 180, 160)
    return image, objects, 47


@pytest.fixture
def beside_a_jug(sample):
    """The same with a jug at the right."""
    image, objects, label = sample
    objects[100:150, 260:300] = JUG
    return image, objects, label


def bounds(mask):
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    return columns[0], rows[0], columns[-1] + 1, rows[-1] + 1


def test_mirroring_moves_the_mask_along(sample):
    seen = set()
    for seed in range(12):
        image, objects, label = augmented(sample, np.random.default_rng(seed))
        mask = objects == CONTAINER
        assert (image.shape, image.dtype) == ((180, 320, 3), np.uint8)
        assert (objects.shape, objects.dtype) == ((180, 320), np.uint8)
        assert label == 47
        assert bounds(mask) in {(20, 60, 60, 90), (260, 60, 300, 90)}
        assert image[mask].mean() > 2 * image[~mask].mean()
        seen.add(bounds(mask)[0])
    assert seen == {20, 260}


def test_colours_change_and_the_sample_itself_does_not(sample):
    before = sample[0].copy()
    brightness = [augmented(sample, np.random.default_rng(seed))[0].mean() for seed in range(8)]
    assert np.ptp(brightness) > 10
    np.testing.assert_array_equal(sample[0], before)


@pytest.mark.parametrize("place", [(0, 0), (150, 80), (280, 150)])
def test_window_holds_the_containers_middle(sample, place):
    image = sample[0]
    objects = np.zeros((180, 320), np.uint8)
    x, y = place
    objects[y : y + 30, x : x + 40] = CONTAINER
    image = np.where(objects[..., None] == CONTAINER, 255, image).astype(np.uint8)
    corners = set()
    for seed in range(20):
        window, part, label = cropped((image, objects, 84), (128, 96), np.random.default_rng(seed))
        assert (window.shape, part.shape, label) == ((96, 128, 3), (96, 128), 84)
        np.testing.assert_array_equal(part == CONTAINER, (window == 255).all(axis=2))
        assert part.sum() >= 20 * 15
        left, top, right, bottom = bounds(part)
        corners.add((right, bottom))
        if place == (150, 80):  # far enough from the border for the middle to be in the window's middle half
            assert 32 <= (left + right) / 2 <= 96
            assert 24 <= (top + bottom) / 2 <= 72
    assert len(corners) > 1 or place != (150, 80)


def test_window_of_a_frame_without_a_container_is_anywhere():
    columns = np.broadcast_to(np.arange(320, dtype=np.uint16)[None, :, None] // 2, (180, 320, 3)).astype(np.uint8)
    starts = {
        int(cropped((columns, np.zeros((180, 320), np.uint8), 47), (128, 96), np.random.default_rng(seed))[0][0, 0, 0])
        for seed in range(40)
    }
    assert min(starts) < 24
    assert max(starts) > 72


def test_target_has_the_box_the_class_and_the_mask(sample):
    image, target = as_target(*sample, network=SmallMaskRCNNConfig())
    assert image.shape == (3, 180, 320)
    assert image.dtype == torch.float32
    torch.testing.assert_close(image[:, 70, 30] * 255, torch.tensor([200.0, 180, 160]))
    assert target["boxes"].tolist() == [[20, 60, 60, 90]]
    assert target["labels"].tolist() == [3]  # bottle, wine glass, cup
    assert target["masks"].shape == (1, 180, 320)
    assert target["masks"].sum() == 40 * 30


def test_frame_without_a_container_has_no_object(sample):
    image, target = as_target(sample[0], np.zeros((180, 320), np.uint8), 47, network=SmallMaskRCNNConfig())
    assert image.shape == (3, 180, 320)
    assert target["boxes"].shape == (0, 4)
    assert target["labels"].shape == (0,)
    assert target["masks"].shape == (0, 180, 320)


def test_jug_is_an_object_of_a_network_with_a_class_for_it(beside_a_jug):
    _, without = as_target(*beside_a_jug, network=SmallMaskRCNNConfig())
    assert without["labels"].tolist() == [3]
    _, target = as_target(*beside_a_jug, network=SmallMaskRCNNConfig(unreported=1))
    assert target["labels"].tolist() == [3, 6]
    assert target["boxes"].tolist() == [[20, 60, 60, 90], [260, 100, 300, 150]]
    assert target["masks"].sum(dim=(1, 2)).tolist() == [40 * 30, 40 * 50]


@pytest.mark.parametrize(("jug", "seen"), [(0.0, {CONTAINER}), (1.0, {JUG}), (0.5, {CONTAINER, JUG})])
def test_windows_are_around_the_jug_as_often_as_asked(beside_a_jug, jug, seen):
    found = [cropped(beside_a_jug, (100, 80), np.random.default_rng(seed), jug=jug)[1] for seed in range(12)]
    assert {int(part.max()) for part in found} == seen


def test_weights_of_a_network_with_fewer_classes_are_taken_over():
    fewer, more = (SmallMaskRCNN(SmallMaskRCNNConfig(unreported=count)) for count in (0, 1))
    name = "roi_heads.box_predictor.cls_score.weight"
    own = more.state_dict()[name][6].clone()
    begin_with(more, fewer.state_dict())
    torch.testing.assert_close(more.state_dict()[name][:6], fewer.state_dict()[name])
    torch.testing.assert_close(more.state_dict()[name][6], own)
    with pytest.raises(RuntimeError, match=r"(?i)sizes? "):
        begin_with(more, SmallMaskRCNN(SmallMaskRCNNConfig(pyramid=32)).state_dict())


def batches(training, count, *, start=0):
    return list(islice(RenderedFrames(training, start=start), count))


def test_batches_have_windows_and_matching_targets():
    for batch in batches(TINY, 3):
        assert len(batch) == 2
        for image, target in batch:
            assert image.shape == (3, 96, 128)
            assert 0 <= image.min() <= image.max() <= 1
            objects = len(target["boxes"])
            assert objects in (0, 1, 2)
            assert target["masks"].shape == (objects, 96, 128)
            assert target["labels"].shape == (objects,)
            for (left, top, right, bottom), mask in zip(target["boxes"].int().tolist(), target["masks"], strict=True):
                assert bounds(mask.numpy().astype(bool)) == (left, top, right, bottom)


def test_some_steps_see_whole_frames():
    [batch] = batches(DetectorTraining(batch=2, whole=1.0), 1)
    assert [tuple(image.shape) for image, _ in batch] == [(3, 360, 640)] * 2


def test_seeds_and_later_starts_see_other_frames_and_the_same_seed_the_same():
    first, again = (batches(TINY, 1)[0][0][0] for _ in range(2))
    assert torch.equal(first, again)
    other_seed = batches(DetectorTraining(batch=2, crop=(128, 96), whole=0.0, seed=1), 1)[0][0][0]
    later = batches(TINY, 1, start=1)[0][0][0]
    assert not torch.equal(first, other_seed)
    assert not torch.equal(first, later)


@pytest.fixture(scope="module")
def training_root(tmp_path_factory):
    """The folder of a training, once the renderer is compiled: the training's own process need not do it again."""
    batches(TINY, 1)
    return tmp_path_factory.mktemp("training") / "run"


def test_training_writes_weights_and_goes_on_where_it_was_stopped(training_root):
    path = train_detector(training_root, TINY)
    last = training_root / "checkpoints" / "last.ckpt"
    assert path == training_root / "detector.safetensors"
    assert torch.load(last, map_location="cpu", weights_only=True)["global_step"] == 2
    first = read_detector(path).state_dict()
    assert SmallDetector(path, device="cpu").detect([np.zeros((90, 160, 3), np.uint8)])[0].size == (90, 160)
    longer = DetectorTraining(**{**vars(TINY), "steps": 3})
    second = read_detector(train_detector(training_root, longer)).state_dict()
    assert torch.load(last, map_location="cpu", weights_only=True)["global_step"] == 3
    assert first.keys() == second.keys()
    assert any(not torch.equal(first[name], second[name]) for name in first)


def test_weights_of_another_network_are_no_beginning(tmp_path):
    config = SmallMaskRCNNConfig(pyramid=32)
    save_detector(tmp_path / "other.safetensors", SmallMaskRCNN(config))
    with pytest.raises(FileError, match="another network") as raised:
        train_detector(tmp_path / "run", TINY, init=tmp_path / "other.safetensors")
    assert raised.value.path == tmp_path / "other.safetensors"


@pytest.mark.parametrize("content", [b"", b"no checkpoint", b"PK\x03\x04" + bytes(40)])
def test_broken_checkpoint_is_named(tmp_path, content):
    path = tmp_path / "checkpoints" / "last.ckpt"
    path.parent.mkdir()
    path.write_bytes(content)
    with pytest.raises(FileError, match="delete it to begin again") as raised:
        train_detector(tmp_path, TINY)
    assert raised.value.path == path
