"""Proposing a mask from a box and strokes, by OpenCV's GrabCut: no network is needed."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from corsmal.by_hand.drawing import REACH_MAX_PX, Drawn, numbers, stroke_mask
from corsmal.errors import ArgumentError

Image = NDArray[np.uint8]
Mask = NDArray[np.bool_]

ITERATIONS = 5
MARGIN = 0.35
"""Around the box, of its sides: what is seen of the background there is what the background looks like."""
SIDE_MAX_PX = 400
"""A larger part of the picture is made smaller first: the time grows with the number of pixels."""
STROKE_PX = 4.0


@dataclass(frozen=True, eq=False)
class Prompt:
    """What a person says of where the container is.

    Args:
        box: x_min, y_min, x_max, y_max in pixels; all of the container's visible pixels lie in it.
        inside: strokes on the container, (n, 2) points (x, y) each.
        outside: strokes beside it.

    Raises:
        ArgumentError: the box is no box, or a stroke has no points, or one that is far away.
    """

    box: tuple[float, float, float, float]
    inside: Sequence[ArrayLike] = ()
    outside: Sequence[ArrayLike] = ()

    def __post_init__(self) -> None:
        box = numbers(self.box, name="box", dimensions=1)
        if len(box) != 4 or (box[2:] - box[:2] < 2).any():
            raise ArgumentError(f"box must be x_min, y_min, x_max, y_max, at least 2 px wide and high, got {self.box}")
        for stroke in (*self.inside, *self.outside):
            points = numbers(stroke, name="strokes", dimensions=2)
            if points.shape[1] != 2 or not len(points) or np.abs(points).max() > REACH_MAX_PX:
                raise ArgumentError(f"strokes must be (n, 2) within {REACH_MAX_PX:g} px, got shape {points.shape}")


def propose_mask(image: Image, prompt: Prompt) -> Drawn:
    """Part the container from the background by their colours.

    Args:
        image: (H, W, 3) uint8 RGB.
        prompt: where the container is.

    Returns:
        The mask, (H, W) bool: the largest part of what was found, its holes filled, and parts with a stroke in them;
        empty, with a sentence, where nothing was found.

    Raises:
        ArgumentError: the image is none, or the box lies outside it.
    """
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8:
        raise ArgumentError(f"image must be (H, W, 3) uint8, got {image.shape} of {image.dtype}")
    window, box = _window(image.shape[:2], prompt.box)
    crop = np.ascontiguousarray(image[window])
    scale = min(1.0, SIDE_MAX_PX / max(crop.shape[:2]))
    small: Image = crop
    if scale < 1:
        small = cv2.resize(crop, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA).astype(np.uint8)
    origin = np.array([window[1].start, window[0].start], dtype=np.float64)
    marks = _marks(small.shape[:2], box, origin, scale, prompt)
    found = _cut(small, marks)
    if found is None or not found.any():
        return Drawn(np.zeros(image.shape[:2], dtype=bool), "Nothing was found: draw a stroke on the container.")
    kept = _pieces(found, marks == cv2.GC_FGD)
    mask = np.zeros(image.shape[:2], dtype=bool)
    mask[window] = cv2.resize(kept.astype(np.float32), crop.shape[1::-1], interpolation=cv2.INTER_LINEAR) >= 0.5
    return Drawn(mask)


def _window(shape: tuple[int, int], box: Sequence[float]) -> tuple[tuple[slice, slice], NDArray[np.float64]]:
    """The part of the picture around the box, and the box's part that is in the picture."""
    x_min, y_min, x_max, y_max = np.clip(box, 0, [shape[1], shape[0]] * 2)
    if x_max - x_min < 2 or y_max - y_min < 2:
        raise ArgumentError(f"box must lie in the picture of {shape[1]}x{shape[0]}, got {tuple(box)}")
    across, down = MARGIN * (x_max - x_min) + 4, MARGIN * (y_max - y_min) + 4
    rows = slice(max(0, int(y_min - down)), min(shape[0], int(np.ceil(y_max + down))))
    columns = slice(max(0, int(x_min - across)), min(shape[1], int(np.ceil(x_max + across))))
    return (rows, columns), np.array([x_min, y_min, x_max, y_max])


def _marks(
    shape: tuple[int, int], box: NDArray[np.float64], origin: NDArray[np.float64], scale: float, prompt: Prompt
) -> NDArray[np.uint8]:
    """What is known of each pixel: outside the box it is background, the strokes are sure."""
    marks = np.full(shape, cv2.GC_BGD, dtype=np.uint8)
    left, top, right, bottom = np.rint((box - np.tile(origin, 2)) * scale).astype(int)
    marks[top:bottom, left:right] = cv2.GC_PR_FGD
    for strokes, mark in ((prompt.inside, cv2.GC_FGD), (prompt.outside, cv2.GC_BGD)):
        for stroke in strokes:
            points = (np.asarray(stroke, dtype=np.float64) - origin) * scale
            marks[stroke_mask(shape, points, radius_px=max(1.0, STROKE_PX * scale))] = mark
    return marks


def _cut(image: Image, marks: NDArray[np.uint8]) -> Mask | None:
    """GrabCut's foreground; None where the marks leave it nothing to tell apart."""
    has_inside = np.isin(marks, (cv2.GC_FGD, cv2.GC_PR_FGD)).any()
    if not has_inside or not (marks == cv2.GC_BGD).any():
        return marks != cv2.GC_BGD if has_inside else None
    cv2.setRNGSeed(0)  # its clusters begin at random
    found, colours = marks.copy(), np.zeros((2, 1, 65))
    cv2.grabCut(image, found, (0, 0, 0, 0), colours[0], colours[1], ITERATIONS, cv2.GC_INIT_WITH_MASK)
    return np.isin(found, (cv2.GC_FGD, cv2.GC_PR_FGD))


def _pieces(found: Mask, sure: Mask) -> Mask:
    """The largest piece and those with a stroke in them, without holes."""
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(found.view(np.uint8), connectivity=8)
    largest = 1 + int(np.argmax(statistics[1:, cv2.CC_STAT_AREA]))
    kept = np.isin(labels, [largest, *np.unique(labels[sure & found])]) & found
    outlines, _ = cv2.findContours(kept.view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    whole = np.zeros(found.shape, dtype=np.uint8)
    cv2.drawContours(whole, outlines, -1, 1, -1)
    return whole.view(np.bool_)
