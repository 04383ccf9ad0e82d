import numpy as np
import pytest
import safetensors.torch
import torch
from torchvision.models.detection import maskrcnn_resnet50_fpn

from corsmal.detection import MaskRCNNDetector
from corsmal.errors import ArgumentError, FileError

HEIGHT, WIDTH = 48, 64


@pytest.fixture(scope="module")
def state():
    with torch.random.fork_rng():
        torch.manual_seed(3)
        return maskrcnn_resnet50_fpn(weights=None, weights_backbone=None, num_classes=91).state_dict()


@pytest.fixture(scope="module")
def weights(state, tmp_path_factory):
    path = tmp_path_factory.mktemp("weights") / "untrained.pth"
    torch.save(state, path)
    return path


@pytest.fixture(scope="module")
def detector(weights):
    return MaskRCNNDetector(weights, score_min=0.0, image_side_min_px=HEIGHT, device="cpu")


def image(seed=0):
    return np.random.default_rng(seed).integers(0, 256, (HEIGHT, WIDTH, 3), dtype=np.uint8)


def test_detections_have_the_image_s_size_and_highest_scores_first(detector):
    still = image()
    still.flags.writeable = False
    [detections] = detector.detect([still])
    assert detections.size == (HEIGHT, WIDTH)
    assert len(detections) > 0
    assert (np.diff(detections.scores) <= 0).all()
    assert (detections.boxes >= 0).all()
    assert (detections.boxes <= [WIDTH, HEIGHT, WIDTH, HEIGHT]).all()
    assert detector.name == "Mask R-CNN, weights untrained.pth"


def answer(label, probability):
    """What the network says of an image in which it is that sure of a 4x4 block."""
    probabilities = torch.zeros(1, 1, HEIGHT, WIDTH)
    probabilities[0, 0, 3:7, 5:9] = probability
    return {
        "boxes": torch.tensor([[5.0, 3, 9, 7]]),
        "scores": torch.tensor([0.75]),
        "labels": torch.tensor([label]),
        "masks": probabilities,
    }


def test_the_network_sees_one_batch_of_rgb_from_0_to_1_and_masks_are_cut_at_a_half(detector, monkeypatch):
    batches = []
    answers = [answer(47, 0.5), answer(44, 0.49)]
    monkeypatch.setattr(detector, "_network", lambda images: batches.append(images) or answers)
    frames = [image(2), image(3)]
    cup, bottle = detector.detect(frames)
    [batch] = batches
    for frame, seen in zip(frames, batch, strict=True):
        np.testing.assert_allclose(seen.numpy(), np.moveaxis(frame, 2, 0) / 255, atol=1e-6)
    assert (cup.labels.tolist(), bottle.labels.tolist()) == ([47], [44])
    assert (cup.mask_areas.tolist(), bottle.mask_areas.tolist()) == ([16], [0])
    assert cup.mask(0)[3:7, 5:9].all()
    assert cup.boxes.tolist() == [[5, 3, 9, 7]]
    assert cup.scores.tolist() == [0.75]


def test_no_image_gives_no_result(detector):
    assert detector.detect([]) == []


@pytest.mark.parametrize(
    "frame", [np.zeros((4, 6), np.uint8), np.zeros((4, 6, 4), np.uint8), np.zeros((4, 6, 3), np.float32)]
)
def test_an_image_of_another_form_is_an_error(detector, frame):
    with pytest.raises(ArgumentError, match=r"frames\[1\] must be \(H, W, 3\) uint8"):
        detector.detect([image(), frame])


def test_safetensors_load_too_and_the_digest_tells_weights_and_settings_apart(state, detector, tmp_path):
    path = tmp_path / "untrained.safetensors"
    safetensors.torch.save_file(state, path)
    other = MaskRCNNDetector(path, score_min=0.5, image_side_min_px=HEIGHT, device="cpu")
    for name, values in other._network.state_dict().items():
        assert torch.equal(values, state[name])
    weights_sha256, settings = detector.digest.split(", ", 1)
    other_sha256, other_settings = other.digest.split(", ", 1)
    assert weights_sha256 != other_sha256
    assert settings != other_settings


@pytest.mark.parametrize("suffix", [".pth", ".safetensors"])
@pytest.mark.parametrize("content", [b"", b"not weights at all", b"\x80\x02N.", b"PK\x03\x04" + bytes(40)])
def test_a_file_that_holds_no_weights_is_an_error(tmp_path, suffix, content):
    path = tmp_path / f"broken{suffix}"
    path.write_bytes(content)
    with pytest.raises(FileError, match="broken"):
        MaskRCNNDetector(path, device="cpu")


def test_a_truncated_file_is_an_error(weights, tmp_path):
    path = tmp_path / "cut.pth"
    path.write_bytes(weights.read_bytes()[:1_000_000])
    with pytest.raises(FileError, match="is broken"):
        MaskRCNNDetector(path, device="cpu")


class RunsCode:
    def __reduce__(self):
        return print, ("run",)


def test_code_in_a_file_of_weights_is_not_run(tmp_path, capsys):
    path = tmp_path / "code.pth"
    torch.save({"weight": RunsCode()}, path)
    with pytest.raises(FileError, match="is broken"):
        MaskRCNNDetector(path, device="cpu")
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"weight": torch.zeros(2)}, "another network"),
        ([torch.zeros(2)], "not a state dict"),
        ({"weight": 3}, "not a state dict"),
        ({3: torch.zeros(2)}, "not a state dict"),
    ],
)
def test_other_weights_are_an_error(tmp_path, content, message):
    path = tmp_path / "other.pth"
    torch.save(content, path)
    with pytest.raises(FileError, match=message):
        MaskRCNNDetector(path, device="cpu")


def test_weights_that_are_not_finite_are_an_error(tmp_path):
    broken = {"bias": torch.tensor([0, torch.nan])}
    path = tmp_path / "nan.safetensors"
    safetensors.torch.save_file(broken, path)
    with pytest.raises(FileError, match="not finite"):
        MaskRCNNDetector(path, device="cpu")


def test_an_absent_file_is_an_error(tmp_path):
    with pytest.raises(FileError, match="cannot be read"):
        MaskRCNNDetector(tmp_path / "absent.pth", device="cpu")


def test_the_folder_of_weights_can_be_named_and_its_file_is_checked(tmp_path, monkeypatch):
    monkeypatch.setenv("CORSMAL_WEIGHTS", str(tmp_path))
    path = tmp_path / "maskrcnn_resnet50_fpn_coco-bf2d0c1e.pth"
    path.write_bytes(b"something else")
    with pytest.raises(FileError, match="delete it") as caught:
        MaskRCNNDetector(device="cpu")
    assert caught.value.path == path


@pytest.mark.parametrize("change", [{"score_min": 1.5}, {"image_side_min_px": 0}, {"device": "abacus"}])
def test_arguments_out_of_range_are_errors(weights, change):
    with pytest.raises(ArgumentError, match=next(iter(change))):
        MaskRCNNDetector(weights, **change)
