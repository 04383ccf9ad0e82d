"""Which detections of a frame count, and why the others do not (paper 3.1)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from corsmal.detection.coco_classes import CLASS_MAX
from corsmal.detection.record import Detections
from corsmal.detection.rle import Size, rightmost_columns
from corsmal.errors import check_choice
from corsmal.parameters import CENTRE_RULES, CentreRule, SelectionParameters

PAPER = SelectionParameters()
COUNT_WORDS = {1: "one", 2: "two", 3: "three"}


class Rows(Protocol):
    """Detections as columns: (n, 4) boxes, (n,) scores and labels, in images of one size (H, W)."""

    @property
    def boxes(self) -> NDArray[np.float64]:
        """``x1 y1 x2 y2``, pixels."""

    @property
    def scores(self) -> NDArray[np.float64]:
        """From 0 to 1."""

    @property
    def labels(self) -> NDArray[np.int64]:
        """COCO category numbers."""

    @property
    def size(self) -> Size:
        """Of the images, pixels."""


@dataclass(frozen=True, eq=False)
class Filtered:
    """What is left of one frame's detections.

    Args:
        kept: (k,) indices of the detections that are left, the highest score first.
        reasons: per detection why it was dropped, None where it was kept.
        scores: (n,) of all detections, those of the kept ones times the weights of their places.
    """

    kept: NDArray[np.int64]
    reasons: tuple[str | None, ...]
    scores: NDArray[np.float64]

    @property
    def container(self) -> int | None:
        """The index of the detection that is taken for the container: the first kept; None where none is."""
        return int(self.kept[0]) if len(self.kept) else None


def filter_detections(
    detections: Detections, *, centre_rule: CentreRule = "both thirds", parameters: SelectionParameters = PAPER
) -> Filtered:
    """Drop detections by class, score and place, then keep those with the highest scores (paper 3.1).

    The rules are applied in this order, and a detection's reason is the first that it breaks: its class is no
    container; its score is too low; its box centre lies outside the middle third of the width or of the height (a
    centre on the border counts as inside); enough others score higher (ties: the first stay). Where places have
    weights, the kept ones are ordered by their weighted scores (ties: the leftmost first).

    Args:
        detections: one frame's.
        centre_rule: ``both thirds`` (the paper's), ``horizontal third`` (only the width), ``none``, or ``middle half``
            (from one to three quarters of the width).
        parameters: classes, least score, how many are kept, and the weights of places.

    Raises:
        ArgumentError: ``centre_rule`` is none of these.
    """
    check_choice("centre_rule", centre_rule, CENTRE_RULES)
    of_class, of_score, of_centre = broken_rules(detections, centre_rule, parameters)
    reasons: list[str | None] = [None] * len(detections)
    for index in np.flatnonzero(of_class | of_score | of_centre).tolist():
        if of_class[index]:
            reasons[index] = f"class {detections.labels[index]} is no container"
        elif of_score[index]:
            reasons[index] = _score_reason(detections.scores[index], parameters)
        else:
            reasons[index] = _centre_reason(detections.boxes[index], detections.size, centre_rule)
    passing = np.flatnonzero(~(of_class | of_score | of_centre))
    ranked = passing[np.argsort(-detections.scores[passing], kind="stable")]
    most = parameters.detections_max
    for index in ranked[most:]:
        verb = "detection scores" if most == 1 else "detections score"
        reasons[index] = f"{COUNT_WORDS.get(most, most)} {verb} higher"
    kept, scores = _weighted(detections, ranked[:most], parameters.place_weights)
    kept.flags.writeable = False
    return Filtered(kept, tuple(reasons), scores)


def _weighted(
    detections: Detections, kept: NDArray[np.int64], weights: Sequence[float]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """The kept detections by their scores times the weights of their places from left to right, and all scores."""
    if not weights or not len(kept):
        return kept, detections.scores
    columns = rightmost_columns([detections.counts[index] for index in kept], detections.size)
    from_left = kept[np.lexsort([kept, columns])]
    scores = detections.scores.copy()
    scores[from_left] = np.minimum(1.0, scores[from_left] * np.array(weights)[: len(kept)])
    return from_left[np.argsort(-scores[from_left], kind="stable")], scores


def broken_rules(
    found: Rows, centre_rule: CentreRule, parameters: SelectionParameters
) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """Which of n detections, of one frame or of many, break the rules that look at each by itself.

    Returns:
        Three times (n,): whose class is no container, whose score is too low, whose box centre lies outside.
    """
    of_class = _foreign_classes(parameters.classes)[found.labels]
    is_outside = np.zeros(len(found.labels), dtype=np.bool_)
    for _, _, is_off in _off_centre(found.boxes, found.size, centre_rule):
        is_outside |= is_off
    return of_class, found.scores < parameters.score_min, is_outside


@lru_cache
def _foreign_classes(classes: frozenset[int]) -> NDArray[np.bool_]:
    """Per COCO category number whether it is none of some classes."""
    return ~np.isin(np.arange(CLASS_MAX + 1), list(classes))


def _score_reason(score: float, parameters: SelectionParameters) -> str:
    # 0.4999 must not read as "0.50 is below 0.50".
    decimals = next((n for n in range(2, 17) if f"{score:.{n}f}" != f"{parameters.score_min:.{n}f}"), 17)
    return f"score {score:.{decimals}f} is below {parameters.score_min:.{decimals}f}"


def _centre_reason(box: NDArray[np.float64], size: Size, rule: CentreRule) -> str:
    axes = _off_centre(box[None], size, rule)
    outside = [f"{percent[0]:.0f} % of the {axis}" for axis, percent, is_off in axes if is_off[0]]
    return f"centre at {' and '.join(outside)} is outside the middle {'half' if rule == 'middle half' else 'third'}"


def _off_centre(
    boxes: NDArray[np.float64], size: Size, rule: CentreRule
) -> list[tuple[str, NDArray[np.float64], NDArray[np.bool_]]]:
    """Per axis that a rule looks at: its name, where the centres of n boxes lie in per cent, and which lie outside."""
    axes = {"none": (), "both thirds": ("width", "height")}.get(rule, ("width",))
    parts = 4 if rule == "middle half" else 3
    found = []
    for axis in axes:
        first, side = (0, size[1]) if axis == "width" else (1, size[0])
        # Twice the centre against shares of twice the side, so that a centre on the border is exactly inside.
        twice_centre = boxes[:, first] + boxes[:, first + 2]
        is_off = (parts * twice_centre < 2 * side) | (parts * twice_centre > 2 * (parts - 1) * side)
        found.append((axis, 50 * twice_centre / side, is_off))
    return found
