"""What each rule of selection says about one frame of a pair of views."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from corsmal.detection import Detections
from corsmal.parameters import SelectionParameters
from corsmal.selection.best import FrameDetections, ViewEvidence, score_frames, view_evidence
from corsmal.selection.records import BestFrame


@dataclass(frozen=True)
class Verdict:
    """What one rule says about a frame.

    Args:
        rule: for people.
        passed: whether the frame passes; None where the rule only counts pixels.
        of_pair: what it says about the frame, for people; empty where it is about the views.
        of_views: likewise of each view of the pair.
    """

    rule: str
    passed: bool | None
    of_pair: str = ""
    of_views: tuple[str, ...] = ()


def frame_verdicts(
    views: Mapping[str, FrameDetections],
    best: BestFrame,
    frame: int,
    *,
    parameters: SelectionParameters,
    frames: Collection[int] | None = None,
) -> tuple[Verdict, ...]:
    """What each rule says about a frame, in the order in which the rules are applied.

    Args:
        views: per view, the unfiltered detections by frame index.
        best: of the pair, selected with the same arguments.
        frame: frame index.
        parameters: the rules.
        frames: those that count; None: all.
    """
    found = [views.get(name, {}).get(frame) for name in best.pair]
    sampled = _sampled(frame, parameters, frames)
    inspected = Verdict(
        "inspected by a detector",
        all(each is not None for each in found),
        of_views=tuple("no" if each is None else f"detections: {len(each)}" for each in found),
    )
    seen = [each for each in found if each is not None]
    if len(seen) < len(found):
        return (*sampled, inspected)
    evidence = [view_evidence(each, centre_rule=best.centre_rule, parameters=parameters) for each in seen]
    containers = Verdict(
        f"container ({best.centre_rule}{'; score → by place' if parameters.place_weights else ''})",
        all(each.pixels is not None for each in evidence),
        of_views=tuple(map(_container_text, seen, evidence)),
    )
    rules = [*sampled, inspected, *_stricter_rungs(seen, best, parameters), containers]
    if parameters.object_score_min is not None:
        rules.append(
            Verdict(
                f"object in the middle (any class, {parameters.detections_max} highest)",
                all(each.central is not None for each in evidence),
                of_views=tuple(map(_central_text, evidence)),
            )
        )
    pixels = ("none" if each.pixels is None else f"{each.pixels:,} px" for each in evidence)
    rules.append(Verdict("N, the container's mask", None, of_views=tuple(pixels)))
    name = "overlaps, twice" if parameters.score_rule == "overlaps" else "union's width × overlap's height"
    rules.append(Verdict(f"penalties ({name})", None, of_views=tuple(f"{each.penalty:,.0f} px" for each in evidence)))
    return (*rules, _score_verdict(views, best, frame, parameters, frames))


def _sampled(frame: int, parameters: SelectionParameters, frames: Collection[int] | None) -> list[Verdict]:
    if parameters.interval_s is None or frames is None:
        return []
    text = "counts" if frame in frames else f"does not count; nearest: {min(frames, key=lambda one: abs(one - frame))}"
    return [Verdict(f"one frame per {parameters.interval_s:g} s, and the last", frame in frames, of_pair=text)]


def _stricter_rungs(seen: list[Detections], best: BestFrame, parameters: SelectionParameters) -> list[Verdict]:
    """The centre rules that were tried before the one that was used: they left no frame."""
    tried = parameters.centre_rules[: parameters.centre_rules.index(best.centre_rule)]
    verdicts = []
    for rule in tried:
        evidence = [view_evidence(each, centre_rule=rule, parameters=parameters) for each in seen]
        texts = tuple(map(_container_text, seen, evidence))
        is_shown = all(each.pixels is not None for each in evidence)
        verdicts.append(Verdict(f"container ({rule}; leaves no frame)", is_shown, of_views=texts))
    return verdicts


def _container_text(detections: Detections, evidence: ViewEvidence) -> str:
    container = evidence.filtered.container
    if container is None:
        return "none"
    score, weighted = detections.scores[container], evidence.filtered.scores[container]
    weight = "" if score == weighted else f" → {weighted:.2f}"
    return f"no. {container + 1}: {score:.2f}{weight}"


def _central_text(evidence: ViewEvidence) -> str:
    if evidence.central is not None:
        return f"no. {evidence.central + 1}"
    numbers = ", ".join(str(index + 1) for index in evidence.leading)
    return f"none of no. {numbers}" if numbers else "no object"


def _score_verdict(
    views: Mapping[str, FrameDetections],
    best: BestFrame,
    frame: int,
    parameters: SelectionParameters,
    frames: Collection[int] | None,
) -> Verdict:
    scores = score_frames(
        {name: {frame: views[name][frame]} for name in best.pair},
        pair=best.pair,
        centre_rule=best.centre_rule,
        parameters=parameters,
        frames=frames,
    )
    total = scores[0].total if scores else None
    if total is None:
        fallback = "; it is taken because no frame has one" if best.is_fallback and frame == best.frame else ""
        return Verdict("score of the pair", False, of_pair=f"none{fallback}")
    if best.score is None or best.score.total is None:
        return Verdict("score of the pair", False, of_pair=f"{total:,.0f} px")
    behind = best.score.total - total
    text = "the best frame" if frame == best.frame else f"{behind:,.0f} px less than frame {best.frame}"
    return Verdict("score of the pair", frame == best.frame, of_pair=f"{total:,.0f} px: {text}")
