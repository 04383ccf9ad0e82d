"""What the score of a frame is lessened by: objects that overlap, and objects that are not in the middle."""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from corsmal.detection import Detections
from corsmal.parameters import SelectionParameters

Box = NDArray[np.float64]


def total_penalties(boxes: NDArray[np.float64]) -> NDArray[np.int64]:
    """TP of frames of one view: twice the overlaps of all pairs of remaining detections (equation 3).

    Args:
        boxes: (..., n, 4) ``x1 y1 x2 y2`` of n detections in each frame, pixels; rounded to whole pixels first.

    Returns:
        (...) pixels.
    """
    rounded, total = np.rint(boxes), np.zeros(boxes.shape[:-2])
    for first, second in combinations(range(boxes.shape[-2]), 2):
        one, other = rounded[..., first, :], rounded[..., second, :]
        sides = np.minimum(one[..., 2:], other[..., 2:]) - np.maximum(one[..., :2], other[..., :2])
        total += np.prod(np.maximum(sides, 0), axis=-1)
    return 2 * total.astype(np.int64)


def total_penalty(detections: Detections) -> int:
    """TP of one view's remaining detections in one frame, pixels (equation 3)."""
    return int(total_penalties(detections.boxes))


def union_penalty(box: Box, other: Box) -> float:
    """The penalty of two boxes (4,) in the authors' released program, pixels.

    It is meant to be their overlap, but its width is that from the left box' left side to the right box' right side.
    """
    left, right = (box, other) if box[0] <= other[0] else (other, box)
    upper, lower = (left, right) if left[1] < right[1] else (right, left)
    return float(max(0.0, right[2] - left[0]) * max(0.0, upper[3] - lower[1]))


def leading_objects(
    detections: Detections, scores: NDArray[np.float64], parameters: SelectionParameters
) -> NDArray[np.intp]:
    """The objects of any class that decide whether a frame counts, those with the highest scores first.

    Args:
        detections: of one view in one frame.
        scores: (n,) of them, those of the containers weighted by their places.
        parameters: ``object_score_min`` and ``detections_max`` are used.

    Returns:
        Their indices; of equal scores the one further right, then lower, is the first.
    """
    least = parameters.object_score_min or 0.0
    centres = (detections.boxes[:, :2] + detections.boxes[:, 2:]) / 2
    order = np.lexsort([-centres[:, 1], -centres[:, 0], -scores])
    return order[scores[order] >= least][: parameters.detections_max]


def is_central(box: Box, size: tuple[int, int]) -> bool:
    """Whether the centre of a box (4,) lies in the middle third of both sides of an image of ``size`` (H, W)."""
    sides = np.array(size[::-1])
    twice_centre = box[:2] + box[2:]
    return bool(((2 * sides <= 3 * twice_centre) & (3 * twice_centre <= 4 * sides)).all())
