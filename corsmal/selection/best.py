"""View Scores of frames, and the best frame (paper 3.1, equations 3 to 5)."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from itertools import combinations

from corsmal.detection import Detections, Filtered, filter_detections
from corsmal.errors import ArgumentError, NotFoundError
from corsmal.parameters import PAIRS, CentreRule, Pair, SelectionParameters
from corsmal.selection.columns import ViewColumns
from corsmal.selection.penalties import is_central, leading_objects, total_penalty, union_penalty
from corsmal.selection.records import BestFrame, FrameScore

FrameDetections = Mapping[int, Detections]


@dataclass(frozen=True)
class ViewEvidence:
    """What one view shows in one frame.

    Args:
        filtered: which of its detections are left.
        pixels: of the container's mask; None without one.
        penalty: of the view, pixels.
        leading: indices of the objects that decide whether the frame counts; empty where none are asked.
        central: the first of them that lies in the middle; None where none does.
        obstacle: why the frame does not count; empty where it does, or where there is no container.
    """

    filtered: Filtered
    pixels: int | None
    penalty: float
    leading: tuple[int, ...] = ()
    central: int | None = None
    obstacle: str = ""


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
    centre_rule: CentreRule | None = None,
    parameters: SelectionParameters | None = None,
    frames: Collection[int] | None = None,
) -> tuple[FrameScore, ...]:
    """Score the frames that were inspected in both views of a pair.

    Args:
        views: per view, the unfiltered detections by frame index.
        pair: names of the two views.
        centre_rule: where the centre of a detection's box must lie; default: the first of the parameters' rules.
        parameters: the other rules; default: the paper's.
        frames: those that count, see ``SelectionParameters.counted_frames``; default: all.

    Raises:
        NotFoundError: a view of the pair has no detections at all.
    """
    parameters = parameters or SelectionParameters()
    missing = [name for name in pair if name not in views]
    if missing:
        raise NotFoundError(f"no detections for {' and '.join(missing)}: the pair {' + '.join(pair)} needs both")
    scoring = _Scoring([views[name] for name in pair], parameters, frames)
    return scoring(centre_rule or parameters.centre_rules[0])


def select_best_frame(
    views: Mapping[str, FrameDetections],
    *,
    pair: Pair = PAIRS[0],
    parameters: SelectionParameters | None = None,
    frames: Collection[int] | None = None,
) -> BestFrame:
    """The frame with the highest score of a pair, on the first rung of the ladder that leaves any (equation 5).

    The paper keeps detections whose box centre lies in the middle third of both axes. Where no frame qualifies, only
    the horizontal third counts; where still none does, no centre rule. Args are as in ``score_frames``.

    Returns:
        The best frame (of equal scores the first, with ``union widths`` the last). Where no frame has a score, because
        none that counts has a container in both views, it is the ``fallback_frame``, or ``ok`` is false, both with the
        reason. Without detections in a view ``ok`` is false.
    """
    parameters = parameters or SelectionParameters()
    missing = [name for name in pair if name not in views]
    if missing:
        reason = f"no detections for {' and '.join(missing)}"
        return BestFrame(pair, None, parameters.centre_rules[0], (), reason)
    scoring = _Scoring([views[name] for name in pair], parameters, frames)
    scores: tuple[FrameScore, ...] = ()
    for centre_rule in parameters.centre_rules:
        scores = scoring(centre_rule)
        best = _highest(scores, parameters)
        if best is not None:
            return BestFrame(pair, best, centre_rule, scores)
    inspected = f"none of {len(scores)} inspected frames shows" if scores else "no inspected frame shows"
    middle = "" if parameters.object_score_min is None else " and an object in the middle"
    reason = f"{inspected} a container{middle} in both {' and '.join(pair)}"
    if frames is not None:
        reason = f"of the {len(frames)} frames that count {reason}"
    if parameters.fallback_frame is not None:
        reason += f": frame {parameters.fallback_frame} is taken"
    return BestFrame(pair, parameters.fallback_frame, parameters.centre_rules[-1], scores, reason)


def best_frame_of_view(
    detections: FrameDetections, *, parameters: SelectionParameters, frames: Collection[int] | None = None
) -> int | None:
    """The best frame of one view by itself; the fallback or None where none has a score. Args as in ``score_frames``.

    The authors' program predicts the container's mass from the frontal view in this frame.
    """
    scoring = _Scoring([detections], parameters, frames)
    for centre_rule in parameters.centre_rules:
        best = _highest(scoring(centre_rule), parameters)
        if best is not None:
            return best
    return parameters.fallback_frame


def view_evidence(detections: Detections, *, centre_rule: CentreRule, parameters: SelectionParameters) -> ViewEvidence:
    """What one view shows in one frame under a centre rule."""
    filtered = filter_detections(detections, centre_rule=centre_rule, parameters=parameters)
    kept = detections[filtered.kept]
    pixels = int(kept.mask_areas[0]) if len(kept) else None
    if parameters.object_score_min is None:
        return ViewEvidence(filtered, pixels, total_penalty(kept))
    leading = tuple(leading_objects(detections, filtered.scores, parameters).tolist())
    central = next((index for index in leading if is_central(detections.boxes[index], detections.size)), None)
    obstacle = "no object in the middle" if central is None and pixels is not None else ""
    if parameters.score_rule == "overlaps":
        taken: float = total_penalty(kept)
    else:
        taken = sum(union_penalty(*detections.boxes[list(two)]) for two in combinations(leading, 2))
    return ViewEvidence(filtered, pixels, taken, leading, central, obstacle)


class _Scoring:
    """Scores some frames of views under one centre rule after the other."""

    def __init__(
        self, views: list[FrameDetections], parameters: SelectionParameters, frames: Collection[int] | None
    ) -> None:
        common = set(views[0]).intersection(*views[1:])
        self._frames = sorted(common if frames is None else common.intersection(frames))
        self._views, self._parameters = views, parameters
        self._columns: list[ViewColumns] = []
        if parameters.is_of_containers and self._frames:
            self._columns = [ViewColumns.of(view, self._frames) for view in views]

    def __call__(self, centre_rule: CentreRule) -> tuple[FrameScore, ...]:
        if self._columns:
            pixels, penalties = zip(
                *(columns.evidence(centre_rule, self._parameters) for columns in self._columns), strict=True
            )
            return tuple(map(FrameScore, self._frames, zip(*pixels, strict=True), zip(*penalties, strict=True)))
        return tuple(self._score(frame, centre_rule) for frame in self._frames)

    def _score(self, frame: int, centre_rule: CentreRule) -> FrameScore:
        evidence = [
            view_evidence(view[frame], centre_rule=centre_rule, parameters=self._parameters) for view in self._views
        ]
        obstacles = tuple(each.obstacle for each in evidence)
        return FrameScore(
            frame,
            tuple(each.pixels for each in evidence),
            tuple(each.penalty for each in evidence),
            is_shared=self._parameters.score_rule == "overlaps",
            obstacles=obstacles if any(obstacles) else (),
        )


def _highest(scores: tuple[FrameScore, ...], parameters: SelectionParameters) -> int | None:
    totals = {score.frame: total for score in scores if (total := score.total) is not None}
    if not totals:
        return None
    in_order = list(totals) if parameters.score_rule == "overlaps" else list(reversed(totals))
    return max(in_order, key=lambda frame: totals[frame])
