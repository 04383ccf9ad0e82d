"""View Scores and the best frame of a pair of views (paper 3.1, equations 3 to 5)."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from corsmal.detection import Detections, filter_detections
from corsmal.errors import ArgumentError, NotFoundError
from corsmal.parameters import CENTRE_RULES, PAIRS, CentreRule, SelectionParameters

FrameDetections = Mapping[int, Detections]
Pair = tuple[str, str]


@dataclass(frozen=True)
class FrameScore:
    """What the two views of a pair show in one frame.

    Args:
        frame: frame index.
        mask_pixels: N of each view's container, pixels; None where the view has no container.
        penalties: TP of each view, pixels (equation 3).
    """

    frame: int
    mask_pixels: tuple[int | None, int | None]
    penalties: tuple[int, int]

    @property
    def view_scores(self) -> tuple[int | None, int | None]:
        """S of each view, pixels (equation 4); None where the view has no container."""
        penalty = sum(self.penalties)
        first, second = self.mask_pixels
        return (None if first is None else first - penalty, None if second is None else second - penalty)

    @property
    def total(self) -> int | None:
        """The pair's score, pixels (equation 5); None unless both views have a container."""
        first, second = self.view_scores
        return None if first is None or second is None else first + second


@dataclass(frozen=True)
class BestFrame:
    """The best frame of one pair of views, and every inspected frame's score under the rule that was used.

    Args:
        frame: index of the best frame, None if no frame has a container in both views.
        centre_rule: the rung of the ladder that the scores were computed with.
        scores: one per frame that was inspected in both views, by frame index.
        reason: why there is no best frame; empty if there is one.
        is_by_fit: whether an estimate took this frame because it explains it best, instead of for its score.
    """

    pair: Pair
    frame: int | None
    centre_rule: CentreRule
    scores: tuple[FrameScore, ...]
    reason: str = ""
    is_by_fit: bool = False

    @property
    def ok(self) -> bool:
        """Whether there is a best frame."""
        return self.frame is not None

    @property
    def score(self) -> FrameScore | None:
        """The best frame's score."""
        return next((score for score in self.scores if score.frame == self.frame), None)


def penalty(box: NDArray[np.float64], other: NDArray[np.float64]) -> int:
    """Pixels that lie in both of two boxes (4,) ``x1 y1 x2 y2``, each rounded to whole pixels first."""
    first, second = np.rint(box), np.rint(other)
    overlap = np.minimum(first[2:], second[2:]) - np.maximum(first[:2], second[:2])
    return int(np.prod(np.maximum(overlap, 0)))


def total_penalty(detections: Detections) -> int:
    """TP of one view's remaining detections, at most three: twice the overlaps of all pairs (equation 3)."""
    return 2 * sum(penalty(first, second) for first, second in combinations(detections.boxes, 2))


def view_score(detections: Detections, partner: Detections) -> int:
    """S of a view in a pair: the container's mask pixels less the penalties of both views (equation 4).

    Args:
        detections: the view's remaining detections in one frame, the container first; not empty.
        partner: the other view's.

    Raises:
        ArgumentError: ``detections`` is empty.
    """
    if len(detections) == 0:
        raise ArgumentError("detections must hold at least the container, got none")
    return int(detections.mask_areas[0]) - (total_penalty(detections) + total_penalty(partner))


def score_frames(
    views: Mapping[str, FrameDetections],
    *,
    pair: Pair,
    centre_rule: CentreRule = "both thirds",
    parameters: SelectionParameters | None = None,
) -> tuple[FrameScore, ...]:
    """Score every frame that was inspected in both views of a pair.

    Args:
        views: per view, the unfiltered detections by frame index.
        pair: names of the two views.
        centre_rule: where the centre of a detection's box must lie.
        parameters: the filter's other numbers; default: the paper's.

    Raises:
        NotFoundError: a view of the pair has no detections at all.
    """
    missing = [name for name in pair if name not in views]
    if missing:
        raise NotFoundError(f"no detections for {' and '.join(missing)}: the pair {' + '.join(pair)} needs both")
    first, second = (views[name] for name in pair)
    scores = []
    for frame in sorted(set(first) & set(second)):
        evidence = [
            _evidence(view[frame], centre_rule=centre_rule, parameters=parameters or SelectionParameters())
            for view in (first, second)
        ]
        scores.append(FrameScore(frame, (evidence[0][0], evidence[1][0]), (evidence[0][1], evidence[1][1])))
    return tuple(scores)


def select_best_frame(
    views: Mapping[str, FrameDetections],
    *,
    pair: Pair = PAIRS[0],
    parameters: SelectionParameters | None = None,
) -> BestFrame:
    """The frame with the highest score of a pair, on the first rung of the ladder that leaves any (equation 5).

    The paper keeps detections whose box centre lies in the middle third of both axes. Where no frame qualifies, only
    the horizontal third counts; where still none does, no centre rule. Args are as in ``score_frames``.

    Returns:
        The best frame (of equal scores the first); ``ok`` is false, with a reason, where no frame has a container in
        both views or a view has no detections.
    """
    missing = [name for name in pair if name not in views]
    if missing:
        return BestFrame(pair, None, CENTRE_RULES[0], (), f"no detections for {' and '.join(missing)}")
    scores: tuple[FrameScore, ...] = ()
    for centre_rule in CENTRE_RULES:
        scores = score_frames(views, pair=pair, centre_rule=centre_rule, parameters=parameters)
        totals = {score.frame: score.total for score in scores if score.total is not None}
        if totals:
            return BestFrame(pair, max(totals, key=totals.__getitem__), centre_rule, scores)
    inspected = f"none of {len(scores)} inspected frames shows" if scores else "no inspected frame shows"
    return BestFrame(pair, None, CENTRE_RULES[-1], scores, f"{inspected} a container in both {' and '.join(pair)}")


def _evidence(
    detections: Detections, *, centre_rule: CentreRule, parameters: SelectionParameters
) -> tuple[int | None, int]:
    """Mask pixels of the container (None without one) and the total penalty of one view in one frame."""
    kept = filter_detections(detections, centre_rule=centre_rule, parameters=parameters).kept
    if len(kept) == 0:
        return None, 0
    remaining = detections[kept]
    return int(remaining.mask_areas[0]), total_penalty(remaining)
