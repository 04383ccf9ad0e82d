"""What proposes masks from a box and strokes: GrabCut, or a promptable network such as a file in ONNX format."""

import os
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from corsmal.by_hand.drawing import Drawn
from corsmal.by_hand.proposing import Prompt, propose_mask
from corsmal.errors import ArgumentError, FileError
from corsmal.weights import file_sha256

VARIABLE = "CORSMAL_SEGMENTER"
"""Names the ``.onnx`` file in the environment. Nothing is downloaded."""

INPUTS = ("image", "box", "points", "labels")
THRESHOLD = 0.5


class Segmenter(Protocol):
    """What finds a container from a box and strokes."""

    @property
    def name(self) -> str:
        """For people, such as ``GrabCut``."""

    @property
    def digest(self) -> str:
        """Changes with everything that its masks depend on besides image and prompt."""

    def propose(self, image: NDArray[np.uint8], prompt: Prompt) -> Drawn:
        """The container's mask in an (H, W, 3) uint8 RGB image."""


class GrabCutSegmenter:
    """OpenCV's GrabCut, which needs no network, see ``propose_mask``."""

    name = "GrabCut"
    digest = "GrabCut 2"

    def propose(self, image: NDArray[np.uint8], prompt: Prompt) -> Drawn:
        """See ``Segmenter``."""
        return propose_mask(image, prompt)


class OnnxSegmenter:
    """A network in ONNX format. Needs the extra ``exchange``.

    Its inputs are ``image``, float32 RGB from 0 to 1, (1, 3, H, W); ``box``, float32 (1, 4) as x_min, y_min, x_max,
    y_max in pixels; ``points``, float32 (1, n, 2); ``labels``, float32 (1, n): 1 on the container, 0 beside it. Without
    strokes the box's middle is the only point. Its one output holds the container's probability, H·W numbers.

    Args:
        weights: the ``.onnx`` file.

    Raises:
        FileError: the file is absent, or holds no such network.
    """

    def __init__(self, weights: Path) -> None:
        try:
            import onnxruntime  # noqa: PLC0415 - of the extra exchange

            self.digest = f"ONNX {file_sha256(weights)}"
            self._session: Any = onnxruntime.InferenceSession(str(weights), providers=["CPUExecutionProvider"])
        except ImportError as error:
            raise FileError(weights, "needs onnxruntime: install corsmal[exchange]") from error
        except OSError as error:
            raise FileError(weights, f"cannot be read ({error.strerror}); name an .onnx file") from error
        except Exception as error:  # the runtime's own errors have no common class
            raise FileError(weights, f"is no network in ONNX format ({str(error)[:80]})") from error
        inputs = tuple(each.name for each in self._session.get_inputs())
        if set(inputs) != set(INPUTS) or len(self._session.get_outputs()) != 1:
            raise FileError(weights, f"has inputs {', '.join(inputs)}, expected {', '.join(INPUTS)} and one output")
        self.name = f"ONNX network, weights {weights.name}"

    def propose(self, image: NDArray[np.uint8], prompt: Prompt) -> Drawn:
        """See ``Segmenter``.

        Raises:
            ArgumentError: the network answers with another number of values than the picture has pixels.
        """
        points, labels = _points(prompt)
        given = {
            "image": np.ascontiguousarray(image.transpose(2, 0, 1)[None], dtype=np.float32) / 255,
            "box": np.array([prompt.box], dtype=np.float32),
            "points": points[None],
            "labels": labels[None],
        }
        [answer] = self._session.run(None, given)
        values = np.asarray(answer)
        if values.size != image.shape[0] * image.shape[1]:
            raise ArgumentError(f"{self.name} gives {values.size} values for {image.shape[1]}x{image.shape[0]} pixels")
        mask = values.reshape(image.shape[:2]) >= THRESHOLD
        return Drawn(mask, "" if mask.any() else "Nothing was found: draw a stroke on the container.")


def open_segmenter(weights: Path | None = None) -> Segmenter:
    """The network that is named, or else that of ``CORSMAL_SEGMENTER``, or else GrabCut.

    Raises:
        FileError: the file cannot be used.
    """
    named = weights or (Path(text).expanduser() if (text := os.environ.get(VARIABLE)) else None)
    return GrabCutSegmenter() if named is None else OnnxSegmenter(named)


def _points(prompt: Prompt) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """All strokes' points (n, 2), and which lie on the container (n,)."""
    strokes = [(np.asarray(stroke), 1.0) for stroke in prompt.inside]
    strokes += [(np.asarray(stroke), 0.0) for stroke in prompt.outside]
    if not any(label for _, label in strokes):
        x_min, y_min, x_max, y_max = prompt.box
        strokes.append((np.array([[(x_min + x_max) / 2, (y_min + y_max) / 2]]), 1.0))
    points = np.concatenate([points for points, _ in strokes]).astype(np.float32)
    labels = np.concatenate([np.full(len(points), label) for points, label in strokes]).astype(np.float32)
    return points, labels
