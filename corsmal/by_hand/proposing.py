"""Proposing a mask from a box, strokes and the mask so far, by OpenCV's GrabCut: no network is needed.

GrabCut parts colours, and a glass has those of what is behind it. What it begins with therefore says where a container
is in a box around it: where the mask so far is, or else where containers mostly are.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from corsmal.by_hand.drawing import REACH_MAX_PX, Drawn, numbers, stroke_mask
from corsmal.errors import ArgumentError

Image = NDArray[np.uint8]
Mask = NDArray[np.bool_]
Box = tuple[slice, slice]

ITERATIONS = 2
MARGIN = 0.35
"""Around the box, of its sides: what is seen of the background there is what the background looks like."""
SIDE_MAX_PX = 400
"""A larger part of the picture is made smaller first: the time grows with the number of pixels."""
STROKE_PX = 4.0

LIKELY = np.array(
    [
        [8, 29, 40, 46, 47, 47],
        [20, 80, 94, 98, 98, 98],
        [13, 71, 89, 96, 97, 95],
        [8, 55, 76, 89, 95, 94],
        [5, 39, 60, 70, 77, 80],
        [3, 30, 49, 59, 65, 70],
        [3, 23, 44, 57, 66, 69],
        [4, 25, 41, 53, 62, 70],
        [6, 30, 46, 57, 64, 73],
        [7, 32, 50, 66, 73, 83],
        [7, 30, 55, 78, 89, 95],
        [2, 10, 22, 35, 46, 52],
    ]
)
"""How many of 100 containers are seen in a part of the box around them: twelve rows, six columns from the left to the
middle, the right half as the left one. Means of cups, glasses and boxes, 120 true masks of 24 recordings of the demo
(seed 0, none of the six that come with it); hands hide the middle most."""
SURE, UNLIKELY = 90, 35
SAME_BOX = 0.6
"""Intersection over union of the mask's own box with the one that was drawn, from which on the mask is begun with."""
INNER, OUTER = 0.06, 0.03
"""How far from the edge of the mask so far its pixels count as sure, and the others as background, of its size."""
REACH = 0.3
"""How far a stroke that contradicts the mask so far puts it in question, of its size."""


@dataclass(frozen=True, eq=False)
class Prompt:
    """What a person says of where the container is.

    Args:
        box: x_min, y_min, x_max, y_max in pixels; all of the container's visible pixels lie in it.
        inside: strokes on the container, (n, 2) points (x, y) each.
        outside: strokes beside it.
        start: the mask so far, (H, W) bool, if it is to be refined; one with another box is not used.

    Raises:
        ArgumentError: the box is no box, or a stroke has no points, or one that is far away.
    """

    box: tuple[float, float, float, float]
    inside: Sequence[ArrayLike] = ()
    outside: Sequence[ArrayLike] = ()
    start: Mask | None = None

    def __post_init__(self) -> None:
        box = numbers(self.box, name="box", dimensions=1)
        if len(box) != 4 or (box[2:] - box[:2] < 2).any():
            raise ArgumentError(f"box must be x_min, y_min, x_max, y_max, at least 2 px wide and high, got {self.box}")
        for stroke in (*self.inside, *self.outside):
            points = numbers(stroke, name="strokes", dimensions=2)
            if points.shape[1] != 2 or not len(points) or np.abs(points).max() > REACH_MAX_PX:
                raise ArgumentError(f"strokes must be (n, 2) within {REACH_MAX_PX:g} px, got shape {points.shape}")


def propose_mask(image: Image, prompt: Prompt) -> Drawn:
    """Part the container from the background by their colours, from what is likely before any colour is known.

    What is likely is the mask so far, where the prompt has one whose box is about the drawn one: only pixels near its
    edge change, and the parts that a stroke contradicts. Else it is where containers mostly are in their box.

    Args:
        image: (H, W, 3) uint8 RGB.
        prompt: where the container is.

    Returns:
        The mask, (H, W) bool: the largest part of what was found, its holes filled, and parts with a stroke in them;
        empty, with a sentence, where nothing was found.

    Raises:
        ArgumentError: the image is none, the box lies outside it, or the mask so far is of another size.
    """
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8:
        raise ArgumentError(f"image must be (H, W, 3) uint8, got {image.shape} of {image.dtype}")
    if prompt.start is not None and (prompt.start.shape != image.shape[:2] or prompt.start.dtype != np.bool_):
        got = f"{prompt.start.shape} of {prompt.start.dtype}"
        raise ArgumentError(f"start must be {image.shape[:2]} bool like the image, got {got}")
    window, box = _window(image.shape[:2], prompt.box)
    crop = np.ascontiguousarray(image[window])
    scale = min(1.0, SIDE_MAX_PX / max(crop.shape[:2]))
    small: Image = crop
    if scale < 1:
        small = cv2.resize(crop, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA).astype(np.uint8)
    origin = np.array([window[1].start, window[0].start], dtype=np.float64)
    left, top, right, bottom = np.rint((box - np.tile(origin, 2)) * scale).astype(int)
    inside = np.s_[top:bottom, left:right]
    drawn = _marks(small.shape[:2], inside, origin, scale, prompt)
    marks = _likely(drawn, inside)
    if prompt.start is not None and _has_box(prompt.start, box):
        part = np.ascontiguousarray(prompt.start[window]).view(np.uint8)
        start = cv2.resize(part, small.shape[1::-1], interpolation=cv2.INTER_NEAREST).astype(np.uint8)
        marks = _near(start, drawn, inside)
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
    shape: tuple[int, int], box: Box, origin: NDArray[np.float64], scale: float, prompt: Prompt
) -> NDArray[np.uint8]:
    """What is known of each pixel: outside the box it is background, the strokes are sure."""
    marks = np.full(shape, cv2.GC_BGD, dtype=np.uint8)
    marks[box] = cv2.GC_PR_FGD
    for strokes, mark in ((prompt.inside, cv2.GC_FGD), (prompt.outside, cv2.GC_BGD)):
        for stroke in strokes:
            points = (np.asarray(stroke, dtype=np.float64) - origin) * scale
            marks[stroke_mask(shape, points, radius_px=max(1.0, STROKE_PX * scale))] = mark
    return marks


def _likely(drawn: NDArray[np.uint8], box: Box) -> NDArray[np.uint8]:
    """Marks to begin with: of the box's pixels those are sure that belong to nearly every container."""
    whole = np.hstack([LIKELY, LIKELY[:, ::-1]]).astype(np.float32)
    likely, marks = np.zeros(drawn.shape, dtype=np.float32), drawn.copy()
    likely[box] = cv2.resize(whole, likely[box].shape[::-1], interpolation=cv2.INTER_LINEAR)
    is_open = drawn == cv2.GC_PR_FGD
    marks[is_open & (likely < UNLIKELY)] = cv2.GC_PR_BGD
    marks[is_open & (likely > SURE)] = cv2.GC_FGD
    return marks


def _has_box(start: Mask, box: NDArray[np.float64]) -> bool:
    """Whether a mask's own box is about the one that was drawn."""
    left, top, width, height = cv2.boundingRect(start.view(np.uint8))
    low, high = np.maximum(box[:2], (left, top)), np.minimum(box[2:], (left + width, top + height))
    both = float(np.prod(np.maximum(high - low, 0)))
    return both > SAME_BOX * (float(np.prod(box[2:] - box[:2])) + width * height - both)


def _near(start: NDArray[np.uint8], drawn: NDArray[np.uint8], box: Box) -> NDArray[np.uint8]:
    """Marks to begin with: a mask, of which only what is near its edge is in question.

    What is near a stroke that contradicts the mask is in question too: one outside within it, or one inside beside it.
    """
    marks, is_open, size = drawn.copy(), drawn == cv2.GC_PR_FGD, float(np.sqrt(np.count_nonzero(start)))
    marks[is_open & (start == 0)] = cv2.GC_PR_BGD
    is_outside = np.zeros(drawn.shape, dtype=bool)
    is_outside[box] = drawn[box] == cv2.GC_BGD
    is_inside = drawn == cv2.GC_FGD
    depth, distance = _distance_px(start > 0), _distance_px(start == 0)
    is_doubted = _distance_px(~(is_outside & (start > 0))) <= REACH * size
    marks[is_open & (depth > INNER * size) & ~is_doubted] = cv2.GC_FGD
    is_doubted = _distance_px(~(is_inside & (start == 0))) <= REACH * size
    marks[is_open & (distance > OUTER * size) & ~is_doubted] = cv2.GC_BGD
    return marks


def _distance_px(pixels: Mask) -> NDArray[np.float32]:
    """How far each pixel is from the next one that is not among ``pixels``; far where all are."""
    return np.asarray(cv2.distanceTransform(pixels.view(np.uint8), cv2.DIST_L2, 5), dtype=np.float32)


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
