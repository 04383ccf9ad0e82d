import json
from dataclasses import asdict, replace

import numpy as np
import pytest
import safetensors
import safetensors.torch
import torch

from corsmal.detection import SmallDetector
from corsmal.detection.small import SmallMaskRCNN, SmallMaskRCNNConfig, read_detector, save_detector
from corsmal.errors import FileError
from corsmal.synthetic.render.frame import render_frame
from corsmal.synthetic.scene.scene import make_scene
from corsmal.weights import bundled_path

CONFIG = SmallMaskRCNNConfig(
    widths=(8, 8, 8, 8), blocks=(1, 1, 1, 1), pyramid=8, box_head=16, mask_layers=(8,), image_side_min=90,
    image_side_max=160,
)  # fmt: skip
ADVICE = "use the bundled file"


@pytest.fixture(scope="module")
def network():
    with torch.random.fork_rng():
        torch.manual_seed(5)
        return SmallMaskRCNN(CONFIG)


@pytest.fixture(scope="module")
def weights(network, tmp_path_factory):
    path = tmp_path_factory.mktemp("weights") / "untrained.safetensors"
    save_detector(path, network)
    return path


@pytest.fixture
def write(tmp_path, network):
    """Writes a file of weights in which something was changed."""

    def write(*, config=None, metadata=None, **changes):
        state = {
            name: value.half() if value.is_floating_point() else value for name, value in network.state_dict().items()
        }
        state = {name: value for name, value in {**state, **changes}.items() if value is not None}
        path = tmp_path / "changed.safetensors"
        if metadata is None:
            metadata = {"config": json.dumps(asdict(CONFIG) | (config or {}))}
        metadata = {"kind": "detector"} | metadata
        safetensors.torch.save_file(state, path, metadata)
        return path

    return write


def image(width, height, seed=0):
    return np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)


def iou(mask, other):
    return (mask & other).sum() / (mask | other).sum()


def test_weights_come_back_in_half_precision_and_statistics_as_they_are(network, weights):
    trained = dict(network.named_parameters())
    with safetensors.safe_open(weights, "pt") as file:
        kinds = {file.get_tensor(name).dtype for name in file.keys() if name in trained}  # noqa: SIM118
    assert kinds == {torch.float16}
    read = read_detector(weights)
    assert read.config == CONFIG
    state = read.state_dict()
    assert state.keys() == network.state_dict().keys()
    for name, value in network.state_dict().items():
        assert state[name].dtype == value.dtype
        expected = value.half().float() if name in trained else value
        torch.testing.assert_close(state[name], expected, rtol=0, atol=0)


@pytest.mark.parametrize("size", [(160, 90), (320, 180), (1280, 720), (90, 160), (64, 64)])
def test_detections_are_in_the_pixels_of_the_image_and_have_coco_numbers(weights, size):
    detector = SmallDetector(weights, device="cpu", score_min=0.0)
    still = image(*size)
    still.flags.writeable = False
    [found] = detector.detect([still])
    assert found.size == size[::-1]
    assert 0 < len(found) <= 10
    assert set(found.labels.tolist()) <= {44, 46, 47, 84, 86}
    assert (np.diff(found.scores) <= 0).all()
    assert (found.boxes >= 0).all()
    assert (found.boxes <= [*size, *size]).all()
    assert found.masks.shape == (len(found), *size[::-1])


def test_every_class_of_the_network_is_a_coco_number(weights, monkeypatch):
    detector = SmallDetector(weights, device="cpu")
    answer = {
        "boxes": torch.tensor([[2.0, 3, 8, 9]] * 5),
        "scores": torch.linspace(0.9, 0.5, 5),
        "labels": torch.arange(1, 6),
        "masks": torch.full((5, 1, 90, 160), 0.7),
    }
    monkeypatch.setattr(detector, "_network", lambda _: [answer])
    [found] = detector.detect([image(160, 90)])
    assert found.labels.tolist() == [44, 46, 47, 84, 86]


def test_classes_that_are_not_to_be_reported_are_left_out(tmp_path, monkeypatch):
    config = SmallMaskRCNNConfig(labels=(47,), unreported=1)
    save_detector(tmp_path / "weights.safetensors", SmallMaskRCNN(config))
    detector = SmallDetector(tmp_path / "weights.safetensors", device="cpu")
    answer = {
        "boxes": torch.tensor([[2.0, 3, 8, 9], [4, 5, 6, 7], [1, 1, 4, 4]]),
        "scores": torch.tensor([0.9, 0.8, 0.7]),
        "labels": torch.tensor([2, 1, 2]),
        "masks": torch.full((3, 1, 90, 160), 0.7),
    }
    monkeypatch.setattr(detector, "_network", lambda _: [answer])
    [found] = detector.detect([image(160, 90)])
    assert found.labels.tolist() == [47]
    assert found.boxes.tolist() == [[4, 5, 6, 7]]
    assert found.masks.shape == (1, 90, 160)


def test_images_of_different_sizes_go_together_and_none_gives_nothing(weights):
    detector = SmallDetector(weights, device="cpu", score_min=0.0)
    together = detector.detect([image(160, 90), image(320, 180, seed=1)])
    assert [found.size for found in together] == [(90, 160), (180, 320)]
    assert detector.detect([]) == []


def test_digest_tells_weights_and_settings_apart(weights, write):
    detector = SmallDetector(weights, device="cpu")
    assert detector.name == "small Mask R-CNN, weights untrained.safetensors"
    assert SmallDetector(weights, device="cpu").digest == detector.digest
    assert SmallDetector(weights, device="cpu", score_min=0.5).digest != detector.digest
    bias = torch.ones(16).half()
    changed = write(**{"roi_heads.box_head.fc7.bias": bias})
    assert SmallDetector(changed, device="cpu").digest != detector.digest


@pytest.mark.parametrize("content", [b"", b"no weights", b"\x08" + bytes(7) + b"{}", b"\xff" * 64, b"{" * 100])
def test_a_file_that_holds_no_weights_is_an_error(tmp_path, content):
    path = tmp_path / "broken.safetensors"
    path.write_bytes(content)
    with pytest.raises(FileError, match=ADVICE) as raised:
        SmallDetector(path, device="cpu")
    assert raised.value.path == path


@pytest.mark.parametrize("share", [0.01, 0.5, 0.999])
def test_a_truncated_file_is_an_error(weights, tmp_path, share):
    path = tmp_path / "cut.safetensors"
    content = weights.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(FileError, match=ADVICE):
        SmallDetector(path, device="cpu")


def test_an_absent_file_and_a_folder_are_errors(tmp_path):
    for path in (tmp_path / "absent.safetensors", tmp_path):
        with pytest.raises(FileError) as raised:
            SmallDetector(path, device="cpu")
        assert raised.value.path == path


@pytest.mark.parametrize("metadata", [{}, {"config": "{"}, {"config": "[]"}, {"config": "3"}, {"format": "pt"}])
def test_weights_without_a_config_are_an_error(write, metadata):
    with pytest.raises(FileError, match=ADVICE):
        SmallDetector(write(metadata=metadata), device="cpu")


@pytest.mark.parametrize(
    "config",
    [
        {"colour": 3},
        {"widths": 3},
        {"widths": "wide"},
        {"widths": ["a", "b", "c", "d"]},
        {"widths": [8, 8]},
        {"widths": [8, 8, 8, 16]},
        {"widths": [-1, 8, 8, 8]},
        {"blocks": [0, 0, 0, 0]},
        {"blocks": [1, 1, 1, 2]},
        {"pyramid": 0},
        {"pyramid": 1.5},
        {"mask_layers": []},
        {"mask_side": "x"},
        {"labels": [44]},
        {"labels": []},
        {"anchor_sizes": [[], [], [], []]},
        {"anchor_sizes": [[20, 32], [48], [104, 150], [200, 260]]},
        {"anchor_ratios": [-1.0]},
        {"mask_side": 13},
        {"labels": None},
        {"unreported": -1},
        {"unreported": 0.5},
        {"labels": ["cup", "glass", "box", "jug", "vase"]},
        {"anchor_sizes": [[20], [40]]},
        {"anchor_ratios": ["x"]},
        {"image_side_min": 0},
        {"image_side_min": None},
        {"image_side_max": -5},
    ],
)
def test_weights_with_a_config_of_another_network_are_an_error(write, config):
    path = write(config=config)
    with pytest.raises(FileError, match=ADVICE) as raised:
        SmallDetector(path, device="cpu")
    assert raised.value.path == path


@pytest.mark.parametrize("value", [torch.nan, torch.inf])
def test_weights_that_are_not_finite_are_an_error(write, value):
    with pytest.raises(FileError, match="not finite"):
        SmallDetector(write(**{"roi_heads.box_head.fc7.bias": torch.full((16,), value).half()}), device="cpu")


@pytest.mark.parametrize("change", [None, torch.zeros(3).half()])
def test_weights_of_another_network_are_an_error(write, change):
    with pytest.raises(FileError, match="do not fit the sizes"):
        SmallDetector(write(**{"roi_heads.box_head.fc7.bias": change}), device="cpu")


@pytest.mark.parametrize("changes", [{}, {"anchor_ratios": (0.5, 2.0), "mask_side": 14, "labels": (47, 84)}])
def test_config_survives_the_file(changes, tmp_path):
    config = replace(CONFIG, **changes)
    path = tmp_path / "weights.safetensors"
    save_detector(path, SmallMaskRCNN(config))
    assert read_detector(path).config == config


@pytest.fixture(scope="module")
def shipped():
    return SmallDetector(bundled_path("detector"), device="cpu")


def test_shipped_weights_are_small(shipped):
    assert bundled_path("detector").stat().st_size <= 10_000_000
    assert sum(values.numel() for values in shipped._network.parameters()) < 3_000_000


@pytest.mark.parametrize("size", [(640, 360), (1280, 720)])
def test_shipped_detector_finds_a_cup_on_the_table(shipped, size):
    truth = render_frame(make_scene(0, container=1, scenario=0), "view3", 0, size=size)
    [found] = shipped.detect([truth.image])
    assert found.scores[0] > 0.5
    assert found.labels[0] == 47
    assert iou(found.mask(0), truth.visible) > 0.5
