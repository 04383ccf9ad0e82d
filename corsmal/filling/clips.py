"""Video features of recordings: R(2+1)D-18 on clips of 16 frames, one row of 512 numbers a clip."""

import pickle
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn
from torchvision.models.video import R2Plus1D_18_Weights, r2plus1d_18

from corsmal.detection.coco_weights import fetched_weights
from corsmal.errors import ArgumentError, FileError
from corsmal.filling.sight import CLIP_FRAMES
from corsmal.weights import choose_device, file_sha256

CLIP_WEIGHTS_URL: str = R2Plus1D_18_Weights.KINETICS400_V1.url
"""torchvision's weights for Kinetics-400; the name ends in the first digits of their SHA-256."""

WHOLE = (128, 171)
"""Height and width that a whole picture is scaled to before its middle is cut out."""

SIDE = 112
"""Pixels of the square that the network sees."""

MEAN = np.array([0.43216, 0.394666, 0.37645], np.float32)
DEVIATION = np.array([0.22803, 0.22145, 0.216989], np.float32)
"""Of RGB in Kinetics, as torchvision has them."""

CLIPS_AT_ONCE = 4

Box = tuple[int, int, int, int]
"""Left, top, right and bottom in pixels, right and bottom excluded."""


class ClipNetwork:
    """torchvision's ``r2plus1d_18`` without its last layer.

    Args:
        weights: a file of its state, such as torchvision's; default: the weights for Kinetics-400, downloaded on first
            use into the folder of the COCO weights.
        device: such as ``cuda:0``; default: a GPU when there is one, else the CPU.

    Raises:
        FileError: the weights are missing and cannot be downloaded, or are of something else.
        ArgumentError: there is no such device.
    """

    def __init__(self, weights: Path | None = None, *, device: str | None = None) -> None:
        self._device = choose_device(device, prefer_gpu=True)
        path = fetched_weights(CLIP_WEIGHTS_URL) if weights is None else weights
        network = r2plus1d_18(weights=None)
        network.fc = nn.Identity()
        try:
            state = torch.load(path, map_location="cpu", weights_only=True)
            network.load_state_dict({name: value for name, value in state.items() if not name.startswith("fc.")})
            sha256 = file_sha256(path)
        except (OSError, AttributeError, EOFError, KeyError, RuntimeError, TypeError, pickle.UnpicklingError) as error:
            raise FileError(path, "is not a file of the weights of R(2+1)D-18; name torchvision's") from error
        self._network = network.to(self._device).eval()
        self.digest = f"r2plus1d_18 {sha256}"

    def rows(self, frames: Iterable[NDArray[np.uint8]], *, crop: Box | None = None) -> NDArray[np.float32]:
        """The features of a video, (T, 512), T = frames // 16; those of a shorter one are of one clip that ends still.

        Args:
            frames: (H, W, 3) uint8 RGB each, in their order.
            crop: what the network sees of each; default: the middle of the whole, as in torchvision's evaluation.

        Raises:
            ArgumentError: there is no frame, or the crop lies outside.
        """
        clips = _clips(seen_by_network(frame, crop=crop) for frame in frames)
        found: list[NDArray[np.float32]] = []
        while batch := list(islice(clips, CLIPS_AT_ONCE)):
            found.append(self._answers(np.stack(batch)))
        if not found:
            raise ArgumentError("frames must hold at least one frame, got none")
        return np.concatenate(found)

    @torch.inference_mode()
    def _answers(self, clips: NDArray[np.float32]) -> NDArray[np.float32]:
        """(n, 512) from (n, 16, 112, 112, 3)."""
        given = torch.from_numpy(clips).movedim(4, 1).to(self._device)  # (n, 3, 16, 112, 112)
        answers: NDArray[np.float32] = self._network(given).cpu().numpy()
        return answers


def seen_by_network(frame: NDArray[np.uint8], *, crop: Box | None = None) -> NDArray[np.float32]:
    """``square_seen``, standardised, (112, 112, 3) float32."""
    square = square_seen(frame, crop=crop)
    seen: NDArray[np.float32] = ((square / np.float32(255) - MEAN) / DEVIATION).astype(np.float32)
    return seen


def square_seen(frame: NDArray[np.uint8], *, crop: Box | None = None) -> NDArray[np.uint8]:
    """(112, 112, 3) uint8 RGB of a frame: its middle, or a crop of it.

    Raises:
        ArgumentError: the crop is empty or lies outside.
    """
    if crop is None:
        scaled = cv2.resize(frame, WHOLE[::-1], interpolation=cv2.INTER_AREA)
        top, left = ((length - SIDE) // 2 for length in WHOLE)
        return scaled[top : top + SIDE, left : left + SIDE].astype(np.uint8)
    left, top, right, bottom = crop
    if not (0 <= left < right <= frame.shape[1] and 0 <= top < bottom <= frame.shape[0]):
        raise ArgumentError(f"crop must lie in a frame of {frame.shape[1]} x {frame.shape[0]}, got {crop}")
    shown = cv2.resize(frame[top:bottom, left:right], (SIDE, SIDE), interpolation=cv2.INTER_AREA)
    return shown.astype(np.uint8)


def square_around(boxes: NDArray[np.floating], *, width: int, height: int, margin: float = 0.5) -> Box:
    """The square around all boxes, wider by a share of its side, moved into the picture and no larger than it.

    Args:
        boxes: (n, 4) left, top, right and bottom in pixels, n at least 1.
        width: of the picture.
        height: of the picture.
        margin: of the side, on all sides together.
    """
    left, top = boxes[:, :2].min(axis=0)
    right, bottom = boxes[:, 2:].max(axis=0)
    side = int(min(np.ceil(max(right - left, bottom - top) * (1 + margin)), width, height))
    first_x = int(np.clip((left + right - side) / 2, 0, width - side))
    first_y = int(np.clip((top + bottom - side) / 2, 0, height - side))
    return first_x, first_y, first_x + side, first_y + side


def _clips(frames: Iterator[NDArray[np.float32]]) -> Iterator[NDArray[np.float32]]:
    """(16, 112, 112, 3) each; what is left at the end is a clip only if it is the first."""
    is_first = True
    while clip := list(islice(frames, CLIP_FRAMES)):
        if len(clip) < CLIP_FRAMES and not is_first:
            return
        yield np.stack(clip + clip[-1:] * (CLIP_FRAMES - len(clip)))
        is_first = False
