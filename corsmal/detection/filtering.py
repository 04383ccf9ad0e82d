"""Which detections of a frame count, and why the others do not (paper 3.1)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from corsmal.detection.record import Detections
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
    """

    kept: NDArray[np.int64]
    reasons: tuple[str | None, ...]

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
    centre on the border counts as inside); enough others score higher (ties: the first stay).

    Args:
        detections: one frame's.
        centre_rule: ``both thirds`` (the paper's), ``horizontal third`` (only the width) or ``none``.
        parameters: classes, least score and how many are kept.

    Raises:
        ArgumentError: ``centre_rule`` is none of the three.
    """
    check_choice("centre_rule", centre_rule, CENTRE_RULES)
    reasons = [
        _class_reason(label, parameters)
        or _score_reason(score, parameters)
        or _centre_reason(box, detections, centre_rule)
        for label, score, box in zip(detections.labels, detections.scores, detections.boxes, strict=True)
    ]
    passing = np.array([index for index, reason in enumerate(reasons) if reason is None], dtype=np.int64)
    ranked = passing[np.argsort(-detections.scores[passing], kind="stable")]
    most = parameters.detections_max
    for index in ranked[most:]:
        verb = "detection scores" if most == 1 else "detections score"
        reasons[index] = f"{COUNT_WORDS.get(most, most)} {verb} higher"
    kept = ranked[:most]
    kept.flags.writeable = False
    return Filtered(kept, tuple(reasons))


def _class_reason(label: int, parameters: SelectionParameters) -> str | None:
    return None if label in parameters.classes else f"class {label} is no container"


def _score_reason(score: float, parameters: SelectionParameters) -> str | None:
    if score >= parameters.score_min:
        return None
    # 0.4999 must not read as "0.50 is below 0.50".
    decimals = next((n for n in range(2, 17) if f"{score:.{n}f}" != f"{parameters.score_min:.{n}f}"), 17)
    return f"score {score:.{decimals}f} is below {parameters.score_min:.{decimals}f}"


def _centre_reason(box: NDArray[np.float64], detections: Detections, rule: CentreRule) -> str | None:
    height, width = detections.size
    axes = [] if rule == "none" else [("width", box[0] + box[2], width)]
    if rule == "both thirds":
        axes.append(("height", box[1] + box[3], height))
    # Twice the centre against two and four thirds of the side, so that a centre on the border is exactly inside.
    outside = [
        f"{50 * twice_centre / side:.0f} % of the {name}"
        for name, twice_centre, side in axes
        if not 2 * side <= 3 * twice_centre <= 4 * side
    ]
    return f"centre at {' and '.join(outside)} is outside the middle third" if outside else None
