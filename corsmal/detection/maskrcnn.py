"""Mask R-CNN with a ResNet-50 FPN backbone, torchvision's, trained on COCO (He et al., ICCV 2017)."""

import pickle
from pathlib import Path

import safetensors
import safetensors.torch
import torch
from torchvision.models.detection import maskrcnn_resnet50_fpn

from corsmal.detection.coco_weights import COCO_WEIGHTS_URL, coco_weights, is_coco
from corsmal.detection.torch_detector import TorchDetector
from corsmal.errors import ArgumentError, FileError
from corsmal.weights import file_sha256

CLASS_COUNT = 91
"""COCO's category numbers up to 90, and 0 for the background."""

UNREADABLE = (
    OSError, RuntimeError, pickle.UnpicklingError, EOFError, ValueError, TypeError, LookupError, AttributeError,
    safetensors.SafetensorError,
)  # fmt: skip


class MaskRCNNDetector(TorchDetector):
    """Finds objects of COCO's classes, with a box and a mask each.

    Args:
        weights: a state dict of torchvision's ``maskrcnn_resnet50_fpn``, ``.pth`` or ``.safetensors``. Default:
            torchvision's COCO weights from the folder that ``CORSMAL_WEIGHTS`` names or else PyTorch's own, downloaded
            there on first use (170 MB).
        device: such as ``cuda:0``; default: a GPU when there is one, else the CPU.
        score_min: detections with a lower score are not reported.
        image_side_min_px: to which the shorter side of images is scaled (800 in training).

    Raises:
        ArgumentError: a number is out of range or there is no such device.
        FileError: the weights are absent, broken or of another network.
    """

    def __init__(
        self,
        weights: Path | None = None,
        *,
        device: str | None = None,
        score_min: float = 0.05,
        image_side_min_px: int = 800,
    ) -> None:
        if not 0 <= score_min <= 1:
            raise ArgumentError(f"score_min must lie in 0..1, got {score_min}")
        if image_side_min_px < 1:
            raise ArgumentError(f"image_side_min_px must be positive, got {image_side_min_px}")
        path = coco_weights() if weights is None else Path(weights)
        try:
            sha256 = file_sha256(path)
        except OSError as error:
            raise FileError(path, f"cannot be read ({error.strerror}); name a .pth or .safetensors file") from error
        if weights is None and not is_coco(path, sha256):
            raise FileError(path, f"is not the file of {COCO_WEIGHTS_URL}; delete it, and it is downloaded again")
        network = maskrcnn_resnet50_fpn(
            weights=None,
            weights_backbone=None,
            num_classes=CLASS_COUNT,
            box_score_thresh=score_min,
            min_size=image_side_min_px,
        )
        try:
            network.load_state_dict(_read_state(path))
        except RuntimeError as error:
            first = " ".join(str(error).split("\n")[1:2]).strip() or error
            raise FileError(path, f"holds weights of another network than maskrcnn_resnet50_fpn ({first})") from error
        super().__init__(
            network,
            name="Mask R-CNN, " + ("COCO weights" if weights is None else f"weights {path.name}"),
            digest=f"Mask R-CNN {sha256}, score {score_min!r}, side {image_side_min_px}",
            device=device,
        )


def _read_state(path: Path) -> dict[str, torch.Tensor]:
    """The state dict of a file, finite values by name."""
    try:
        if path.suffix == ".safetensors":
            state = safetensors.torch.load_file(path)
        else:
            state = torch.load(path, map_location="cpu", weights_only=True)
    except UNREADABLE as error:
        raise FileError(
            path, "is broken or no file of weights; expected a PyTorch state dict or safetensors"
        ) from error
    if not isinstance(state, dict) or not all(
        isinstance(name, str) and isinstance(value, torch.Tensor) for name, value in state.items()
    ):
        raise FileError(path, "is not a state dict (names to tensors)")
    if not all(torch.isfinite(values).all() for values in state.values()):
        raise FileError(path, "holds weights that are not finite; take another file")
    return state
