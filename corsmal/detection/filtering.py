"""Which detections of a frame count, and why the others do not (paper 3.1)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from corsmal.detection.record import Detections
from corsmal.detection.rle import Size, rightmost_columns
from corsmal.errors import check_choice
from corsmal.parameters import CENTRE_RULES, CentreRule, SelectionParameters

PAPER = SelectionParameters()
COUNT_WORDS = {1: "one", 2: "two", 3: "three"}


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
    reasons = [
        _class_reason(label, parameters)
        or _score_reason(score, parameters)
        or _centre_reason(box, detections.size, centre_rule)
        for label, score, box in zip(
            detections.labels.tolist(), detections.scores.tolist(), detections.boxes.tolist(), strict=True
        )
    ]
    passing = np.array([index for index, reason in enumerate(reasons) if reason is None], dtype=np.int64)
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


def _class_reason(label: int, parameters: SelectionParameters) -> str | None:
    return None if label in parameters.classes else f"class {label} is no container"


def _score_reason(score: float, parameters: SelectionParameters) -> str | None:
    if score >= parameters.score_min:
        return None
    # 0.4999 must not read as "0.50 is below 0.50".
    decimals = next((n for n in range(2, 17) if f"{score:.{n}f}" != f"{parameters.score_min:.{n}f}"), 17)
    return f"score {score:.{decimals}f} is below {parameters.score_min:.{decimals}f}"


def _centre_reason(box: list[float], size: Size, rule: CentreRule) -> str | None:
    height, width = size
    axes = [] if rule == "none" else [("width", box[0] + box[2], width)]
    if rule == "both thirds":
        axes.append(("height", box[1] + box[3], height))
    parts, name = (4, "half") if rule == "middle half" else (3, "third")
    # Twice the centre against shares of twice the side, so that a centre on the border is exactly inside.
    outside = [
        f"{50 * twice_centre / side:.0f} % of the {axis}"
        for axis, twice_centre, side in axes
        if not 2 * side <= parts * twice_centre <= 2 * (parts - 1) * side
    ]
    return f"centre at {' and '.join(outside)} is outside the middle {name}" if outside else None
