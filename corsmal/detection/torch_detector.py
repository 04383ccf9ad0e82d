"""A torchvision Mask R-CNN behind the detectors' interface."""

from collections.abc import Mapping, Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torchvision.models.detection import MaskRCNN

from corsmal.detection.record import Detections
from corsmal.errors import ArgumentError
from corsmal.weights import choose_device

MASK_THRESHOLD = 0.5


class TorchDetector:
    """Runs a Mask R-CNN and turns what it returns into records.

    Args:
        network: torchvision's network.
        name: for people: the method and its weights.
        digest: of the weights' content and the settings that the detections depend on.
        device: such as ``cuda:0``; default: a GPU when there is one, else the CPU.
        labels: COCO number of each of the network's classes but the background, 0 for a class that is not reported;
            default: they are the same.

    Raises:
        ArgumentError: there is no such device.
    """

    def __init__(
        self,
        network: MaskRCNN,
        *,
        name: str,
        digest: str,
        device: str | None = None,
        labels: Sequence[int] | None = None,
    ) -> None:
        self.device = choose_device(device, prefer_gpu=True)
        self._network = network.to(self.device).eval()
        self.name, self.digest = name, digest
        self._labels = None if labels is None else np.array([0, *labels])

    @torch.inference_mode()
    def detect(self, frames: Sequence[NDArray[np.uint8]]) -> list[Detections]:
        """Detect in one batch of images, (H, W, 3) uint8 RGB each; sizes may differ.

        Returns:
            One record per image, highest score first; pixels count to a mask from a probability of 0.5 on.

        Raises:
            ArgumentError: an image has another shape or type.
        """
        for index, frame in enumerate(frames):
            if frame.ndim != 3 or frame.shape[2] != 3 or frame.dtype != np.uint8:
                raise ArgumentError(f"frames[{index}] must be (H, W, 3) uint8, got {frame.shape} of {frame.dtype}")
        if not frames:
            return []
        images = [torch.tensor(frame, device=self.device).permute(2, 0, 1) / 255 for frame in frames]
        return [self._record(output) for output in self._network(images)]

    def _record(self, output: Mapping[str, torch.Tensor]) -> Detections:
        labels = output["labels"].cpu().numpy()
        labels = labels if self._labels is None else self._labels[labels]
        reported = labels > 0
        masks = output["masks"][torch.from_numpy(reported), 0] >= MASK_THRESHOLD  # (n, 1, H, W) probabilities
        return Detections(
            boxes=output["boxes"].cpu().numpy()[reported],
            scores=output["scores"].cpu().numpy()[reported],
            labels=labels[reported],
            masks=masks.cpu().numpy(),
        )
