"""Carrying a mask on to the next frame by dense optical flow, and checking the result against the pictures."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.errors import ArgumentError

if TYPE_CHECKING:
    from corsmal.dataset import Video

Image = NDArray[np.uint8]
Mask = NDArray[np.bool_]
Flow = NDArray[np.float32]

MARGIN_PX = 48
"""Around the mask: the flow is computed only there, and a container that moves farther in a frame is lost."""
RETURN_PX = 1.5
"""A pixel agrees if the flow there and back ends no farther from where it began."""
COLOUR = 30.0
"""A pixel agrees if its colour changed by no more, of 255, averaged over its channels."""
RETURNS_LEAST, MATCHES_LEAST = 0.5, 0.7
"""Shares of a mask's pixels that must agree in flow and in colour, else the container is lost.

Where the mask of a plain moving container was right, the flow of 0.55 to 0.9 of its pixels agreed.
"""
AREA_CHANGE_MAX = 0.25


@dataclass(frozen=True, eq=False)
class Followed:
    """A mask in the next frame.

    Args:
        mask: (H, W) bool.
        returns: share of its pixels whose flow there and back ends where it began, 0 to 1.
        matches: share of its pixels that have the colour they had, 0 to 1.
        lost: why the mask is not to be used; empty: it is.
    """

    mask: Mask
    returns: float
    matches: float
    lost: str = ""


def follow_mask(mask: Mask, before: Image, after: Image) -> Followed:
    """A mask of one frame in the next one, by OpenCV's DIS flow.

    Args:
        mask: (H, W) bool, in ``before``.
        before: (H, W, 3) uint8 RGB.
        after: likewise, the next frame.

    Raises:
        ArgumentError: the mask is empty, or the shapes differ.
    """
    if mask.shape != before.shape[:2] or before.shape != after.shape:
        raise ArgumentError(f"mask and pictures must have one size, got {mask.shape}, {before.shape}, {after.shape}")
    if not mask.any():
        raise ArgumentError("mask must not be empty: there is nothing to follow")
    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    top, left = max(0, y - MARGIN_PX), max(0, x - MARGIN_PX)
    window = np.s_[top : y + height + MARGIN_PX, left : x + width + MARGIN_PX]
    crops = [np.ascontiguousarray(image[window]) for image in (before, after)]
    forwards, backwards = _flow(crops[0], crops[1]), _flow(crops[1], crops[0])
    rows, columns = np.indices(crops[0].shape[:2], dtype=np.float32)
    grid = np.stack([columns, rows], axis=-1)
    carried = _sampled(mask[window].astype(np.float32), grid + backwards) >= 0.5
    found = np.zeros_like(mask)
    found[window] = carried
    if not carried.any():
        return Followed(found, 0.0, 0.0, "it left the part of the picture in which it was looked for")
    returned = backwards + _sampled(forwards, grid + backwards)
    returns = np.hypot(returned[..., 0], returned[..., 1])[carried] <= RETURN_PX
    colours = _sampled(crops[0].astype(np.float32), grid + backwards) - crops[1]
    matches = np.abs(colours).mean(axis=-1)[carried] <= COLOUR
    change = abs(int(carried.sum()) / int(mask.sum()) - 1)
    shares = float(returns.mean()), float(matches.mean())
    return Followed(found, *shares, lost=_lost(*shares, change))


def follow_on(video: "Video", mask: Mask, frame: int, *, frames: int) -> Iterator[tuple[int, Followed]]:
    """Carry a mask on from frame to frame; the first one in which it is lost is the last.

    Args:
        video: the view's.
        mask: (H, W) bool in ``frame``.
        frame: of the video.
        frames: how many frames to go on, at most.

    Yields:
        Each further frame and the mask in it.
    """
    before = video[frame]
    for number in range(frame + 1, min(frame + frames, video.frame_count - 1) + 1):
        after = video[number]
        found = follow_mask(mask, before, after)
        yield number, found
        if found.lost:
            return
        mask, before = found.mask, after


def _flow(first: Image, second: Image) -> Flow:
    """(H, W, 2) where each pixel of the first picture is in the second, less where it was."""
    greys = [cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) for image in (first, second)]
    flow: Any = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    found: Flow = flow.calc(*greys, None)
    return found


def _sampled(values: Flow, places: Flow) -> Flow:
    """The values between the pixels at places (H, W, 2), x and y."""
    x, y = np.ascontiguousarray(places[..., 0]), np.ascontiguousarray(places[..., 1])
    return cv2.remap(values, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE).astype(np.float32)


def _lost(returns: float, matches: float, change: float) -> str:
    if returns < RETURNS_LEAST:
        return f"the flow there and back agrees in {100 * returns:.0f} % of its pixels only"
    if matches < MATCHES_LEAST:
        return f"{100 * matches:.0f} % of its pixels have the colour that they had"
    if change > AREA_CHANGE_MAX:
        return f"its area changed by {100 * change:.0f} % within a frame"
    return ""
