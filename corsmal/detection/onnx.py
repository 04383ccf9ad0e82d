"""A network in ONNX format as a detector, an example of one behind an entry point. Needs the extra ``exchange``."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from corsmal.detection.record import Detections
from corsmal.errors import ArgumentError, FileError
from corsmal.weights import file_sha256

MASK_THRESHOLD = 0.5
OUTPUTS = 4


class OnnxDetector:
    """Runs a network that was exported from torchvision's Mask R-CNN, or another of the same form.

    Its input is one picture, float32 RGB from 0 to 1, (3, H, W) or (1, 3, H, W); its outputs are boxes (n, 4) as x_min,
    y_min, x_max, y_max, COCO numbers of the classes (n,), scores (n,), mask probabilities (n, 1, H, W), in this order.

    Args:
        weights: the ``.onnx`` file.
        device: ``cpu``, or ``cuda`` and a number; default: a GPU if the ONNX runtime that is installed has one.

    Raises:
        FileError: the file is absent, or holds no such network.
    """

    def __init__(self, weights: Path, *, device: str | None = None) -> None:
        import onnxruntime  # noqa: PLC0415 - of the extra exchange

        wanted = ["CUDAExecutionProvider", "CPUExecutionProvider"] if device != "cpu" else ["CPUExecutionProvider"]
        providers = [provider for provider in wanted if provider in onnxruntime.get_available_providers()]
        try:
            self.digest = f"ONNX {file_sha256(weights)}"
            self._session: Any = onnxruntime.InferenceSession(str(weights), providers=providers)
        except OSError as error:
            raise FileError(weights, f"cannot be read ({error.strerror}); name an .onnx file") from error
        except Exception as error:  # the runtime's own errors have no common class
            raise FileError(weights, f"is no network in ONNX format ({str(error)[:80]})") from error
        inputs, outputs = self._session.get_inputs(), self._session.get_outputs()
        if len(inputs) != 1 or len(outputs) != OUTPUTS:
            raise FileError(weights, f"has {len(inputs)} inputs and {len(outputs)} outputs, expected 1 and {OUTPUTS}")
        self._input = inputs[0].name
        self._has_batch = len(inputs[0].shape) == 4
        self.name = f"ONNX network, weights {weights.name}"

    def detect(self, frames: Sequence[NDArray[np.uint8]]) -> list[Detections]:
        """Detect in images, (H, W, 3) uint8 RGB each, one after the other."""
        return [self._one(frame) for frame in frames]

    def _one(self, frame: NDArray[np.uint8]) -> Detections:
        picture = np.ascontiguousarray(frame.transpose(2, 0, 1), dtype=np.float32) / 255
        given = picture[None] if self._has_batch else picture
        boxes, labels, scores, masks = self._session.run(None, {self._input: given})
        return Detections(
            boxes=boxes,
            scores=np.clip(scores, 0, 1),
            labels=np.asarray(labels, dtype=np.int64),
            masks=np.asarray(masks).reshape(-1, *frame.shape[:2]) >= MASK_THRESHOLD,
        )


def open_detector(weights: Path | None = None, *, device: str | None = None) -> OnnxDetector:
    """The entry point ``onnx``.

    Raises:
        ArgumentError: no weights are named.
    """
    if weights is None:
        raise ArgumentError("the detector onnx needs a file: --weights network.onnx")
    return OnnxDetector(weights, device=device)
