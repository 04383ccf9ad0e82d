"""The selection preset ``released``: the rules of the authors' program, against a slow version and by hand."""

import numpy as np
import pytest

from corsmal.detection import Detections, filter_detections
from corsmal.errors import ArgumentError
from corsmal.parameters import SELECTION_PRESETS, SelectionParameters
from corsmal.selection import (
    best_frame_of_view,
    frame_verdicts,
    score_frames,
    select_best_frame,
    union_penalty,
)

RELEASED = SelectionParameters.released()
PAIR = ("view1", "view2")
SIZE = (90, 120)
CUP, CHAIR = 47, 62


def detections_of(*rows):
    """Detections from (label, score, box); each mask is its box."""
    masks = np.zeros((len(rows), *SIZE), dtype=bool)
    for mask, (_, _, (x1, y1, x2, y2)) in zip(masks, rows, strict=True):
        mask[round(y1) : round(y2), round(x1) : round(x2)] = True
    return Detections(
        boxes=np.array([box for _, _, box in rows], dtype=float).reshape(-1, 4),
        scores=[score for _, score, _ in rows],
        labels=np.array([label for label, _, _ in rows], dtype=int),
        masks=masks,
    )


def cup(score, x, y=45, *, side=10):
    return (CUP, score, (x - side / 2, y - side / 2, x + side / 2, y + side / 2))


def slow_container(found):
    """The container's index, None without one, and all scores after it was looked for."""
    scores = found.scores.tolist()
    candidates = []
    for index in np.argsort(-found.scores, kind="stable").tolist():
        x1, _, x2, _ = found.boxes[index]
        if not SIZE[1] / 4 <= (x1 + x2) / 2 <= 3 * SIZE[1] / 4:
            continue
        if scores[index] >= 0.5 and found.labels[index] in (44, 46, 47, 84, 86) and len(candidates) < 3:
            columns = np.flatnonzero(found.mask(index).any(axis=0))
            candidates.append((columns[-1] if len(columns) else -1, index))
    candidates.sort()
    for weight, (_, index) in zip((0.5, 1, 1.5), candidates, strict=False):
        scores[index] = min(1.0, weight * scores[index])
    most = max((scores[index] for _, index in candidates), default=None)
    return next((index for _, index in candidates if scores[index] == most), None), scores


def slow_view(found):
    """Mask pixels less penalties, None where the frame does not count in this view."""
    container, scores = slow_container(found)
    centres = [((x1 + x2) / 2, (y1 + y2) / 2) for x1, y1, x2, y2 in found.boxes]
    objects = [(scores[index], *centres[index], index) for index in range(len(found)) if scores[index] >= 0.3]
    objects.sort(reverse=True)
    height, width = SIZE
    is_clear = any(width / 3 <= x <= 2 * width / 3 and height / 3 <= y <= 2 * height / 3 for _, x, y, _ in objects[:3])
    if container is None or not is_clear:
        return None
    score = found.mask(container).sum()
    boxes = [found.boxes[index] for *_, index in objects[:3]]
    for first in range(len(boxes)):
        for second in range(first + 1, len(boxes)):
            left, right = boxes[first], boxes[second]
            if left[0] > right[0]:
                left, right = right, left
            (xa, ya, _, ha), (xb, yb, wb, hb) = (
                (box[0], box[1], box[2] - box[0], box[3] - box[1]) for box in (left, right)
            )
            across = max(0, xb + wb - xa)
            score -= across * (max(0, ya + ha - yb) if ya < yb else max(0, yb + hb - ya))
    return score


def random_frame(rng):
    rows = []
    for _ in range(rng.integers(0, 8)):
        x, y = np.clip(rng.normal((60, 45), (20, 12)), 10, (SIZE[1] - 10, SIZE[0] - 10))
        half = rng.uniform(3, 9, 2)
        label = int(rng.choice([CUP, CUP, CUP, 44, CHAIR]))
        rows.append((label, rng.uniform(0.2, 1), (x - half[0], y - half[1], x + half[0], y + half[1])))
    return detections_of(*rows)


@pytest.mark.parametrize("seed", range(30))
def test_containers_are_those_of_the_slow_version(seed):
    found = random_frame(np.random.default_rng(seed))
    filtered = filter_detections(found, centre_rule="middle half", parameters=RELEASED)
    container, scores = slow_container(found)
    assert (filtered.container, filtered.scores.tolist()) == (container, scores)


@pytest.mark.parametrize("seed", range(6))
def test_frames_and_scores_are_those_of_the_slow_version(seed):
    rng = np.random.default_rng(100 + seed)
    views = {name: {frame: random_frame(rng) for frame in range(40)} for name in PAIR}
    counted = range(0, 40, 3)
    best = select_best_frame(views, pair=PAIR, parameters=RELEASED, frames=counted)
    slow = {frame: [slow_view(views[name][frame]) for name in PAIR] for frame in counted}
    totals = {frame: None if None in scores else sum(scores) for frame, scores in slow.items()}
    assert {score.frame: score.total for score in best.scores} == {
        frame: None if total is None else pytest.approx(total) for frame, total in totals.items()
    }
    seen = {frame: total for frame, total in totals.items() if total is not None}
    assert len(seen) > 1
    assert best.frame == max(seen, key=seen.__getitem__)
    alone = {frame: score for frame in counted if (score := slow_view(views["view1"][frame])) is not None}
    assert best_frame_of_view(views["view1"], parameters=RELEASED, frames=counted) == max(alone, key=alone.__getitem__)


def test_the_rightmost_of_three_cups_is_preferred():
    found = detections_of(cup(0.9, 60), cup(0.8, 45), cup(0.7, 75))
    filtered = filter_detections(found, centre_rule="middle half", parameters=RELEASED)
    # from left to right 0.8 / 2, 0.9, 0.7 · 1.5 cut to 1
    assert filtered.scores.tolist() == [0.9, 0.4, 1.0]
    assert filtered.kept.tolist() == [2, 0, 1]
    alone = filter_detections(detections_of(cup(0.9, 60)), centre_rule="middle half", parameters=RELEASED)
    assert (alone.container, alone.scores.tolist()) == (0, [0.45])


def test_of_equal_weighted_scores_the_leftmost_is_the_container():
    found = detections_of(cup(0.7, 75), cup(1.0, 60), cup(0.6, 45))
    assert filter_detections(found, centre_rule="middle half", parameters=RELEASED).container == 1


@pytest.mark.parametrize(("x", "inside"), [(29.9, False), (30, True), (90, True), (90.1, False)])
def test_a_container_lies_in_the_middle_half_of_the_width_at_any_height(x, inside):
    found = detections_of(cup(0.9, x, 8))
    filtered = filter_detections(found, centre_rule="middle half", parameters=RELEASED)
    assert (filtered.container == 0) == inside
    assert inside or "middle half" in filtered.reasons[0]


def test_the_penalty_is_the_unions_width_times_the_overlaps_height():
    first, second = np.array([0.0, 0, 10, 10]), np.array([6.0, 7, 20, 20])
    assert union_penalty(first, second) == union_penalty(second, first) == 20 * 3
    assert (
        union_penalty(first, np.array([50.0, 2, 60, 4])) == 60 * 8
    )  # below its upper end, not just where they overlap
    assert union_penalty(first, np.array([6.0, 11, 20, 20])) == 0
    assert union_penalty(first, np.array([2.0, 0, 5, 10])) == 5 * 10


def test_score_of_a_frame_by_hand():
    middle = detections_of(cup(0.9, 60), (CHAIR, 0.4, (70, 44, 90, 60)), (CHAIR, 0.2, (0, 0, 120, 90)))
    plain = detections_of(cup(0.9, 60))
    (score,) = score_frames({"view1": {0: middle}, "view2": {0: plain}}, pair=PAIR, parameters=RELEASED)
    # the chair of 0.4 counts, that of 0.2 does not: from 55 to 90, and from 44 to 50
    assert (score.penalties, score.mask_pixels) == ((35 * 6, 0), (100, 100))
    assert (score.view_scores, score.total_penalty, score.total) == ((100 - 210, 100), 210, -10)


def test_a_frame_without_an_object_in_the_middle_does_not_count():
    aside = detections_of(cup(0.9, 35))
    chair = detections_of(cup(0.9, 35), (CHAIR, 0.5, (55, 40, 65, 50)))
    views = {"view1": {0: aside, 30: chair}, "view2": {0: chair, 30: chair}}
    best = select_best_frame(views, pair=PAIR, parameters=RELEASED)
    assert best.frame == 30
    assert best.scores[0].obstacles == ("no object in the middle", "")
    assert best.scores[0].total is None


def test_frame_0_is_the_last_resort():
    aside = detections_of(cup(0.9, 35))
    views = {"view1": {0: aside, 30: aside}, "view2": {0: aside, 30: aside}}
    best = select_best_frame(views, pair=PAIR, parameters=RELEASED, frames=(0, 30, 60))
    assert (best.frame, best.is_fallback, best.ok) == (0, True, True)
    assert "frame 0 is taken" in best.reason
    assert best_frame_of_view(views["view1"], parameters=RELEASED) == 0
    assert not select_best_frame(views, pair=("view1", "view3"), parameters=RELEASED).ok


def test_of_equal_scores_the_last_frame_wins():
    found = detections_of(cup(0.9, 60))
    views = {name: {0: found, 30: found, 45: found} for name in PAIR}
    assert select_best_frame(views, pair=PAIR, parameters=RELEASED).frame == 45
    assert select_best_frame(views, pair=PAIR).frame == 0


@pytest.mark.parametrize(
    ("fps", "frames", "counted"),
    [
        (30.0, 61, (0, 30, 60)),
        (30.0, 65, (0, 30, 60, 64)),
        (29.97, 31, (0, 30)),
        (0.4, 3, (0, 1, 2)),
        (0.0, 90, None),
        (30.0, 0, None),
    ],
)
def test_a_frame_per_second_and_the_last_count(fps, frames, counted):
    assert RELEASED.counted_frames(fps=fps, frames=frames) == counted


def test_all_frames_count_for_the_paper():
    assert SELECTION_PRESETS["paper"].counted_frames(fps=30.0, frames=90) is None


@pytest.mark.parametrize(
    "changes",
    [
        {"centre_rules": ()},
        {"centre_rules": ("left",)},
        {"place_weights": (1.0,)},
        {"place_weights": (0.5, 1.0, -1.0)},
        {"interval_s": 0.0},
        {"object_score_min": 2.0},
        {"score_rule": "areas"},
        {"score_rule": "union widths"},
        {"fallback_frame": -1},
        {"mass_frame": "any"},
    ],
)
def test_impossible_rules_are_refused(changes):
    name = "object_score_min" if changes == {"score_rule": "union widths"} else next(iter(changes))
    with pytest.raises(ArgumentError, match=name):
        SelectionParameters(**changes)


def verdicts(views, frame, *, parameters=RELEASED, frames=None):
    best = select_best_frame(views, pair=PAIR, parameters=parameters, frames=frames)
    found = frame_verdicts(views, best, frame, parameters=parameters, frames=frames)
    return {verdict.rule.partition(" (")[0].partition(",")[0]: verdict for verdict in found}


def test_each_rule_says_what_it_thinks_of_a_frame():
    chair = (CHAIR, 0.5, (55, 40, 65, 50))
    views = {
        "view1": {0: detections_of(cup(0.9, 35)), 29: detections_of(), 30: detections_of(cup(0.9, 35), chair)},
        "view2": {0: detections_of(cup(0.9, 60)), 29: detections_of(), 30: detections_of(cup(0.9, 60), cup(0.8, 80))},
    }
    first, between, best = (verdicts(views, frame, frames=(0, 30, 60)) for frame in (0, 29, 30))
    assert first["one frame per 1 s"].passed
    assert not between["one frame per 1 s"].passed
    assert between["one frame per 1 s"].of_pair == "does not count; nearest: 30"
    assert first["container"].of_views == ("no. 1: 0.90 → 0.45",) * 2
    assert between["container"].of_views == ("none", "none")
    assert first["object in the middle"].of_views == ("none of no. 1", "no. 1")
    assert not first["object in the middle"].passed
    assert best["container"].of_views[1] == "no. 2: 0.80"
    assert best["score of the pair"].passed
    assert "the best frame" in best["score of the pair"].of_pair
    assert first["score of the pair"].of_pair == "none"
    assert not verdicts(views, 7)["inspected by a detector"].passed


def test_the_papers_rungs_that_left_no_frame_are_named():
    low = detections_of(cup(0.9, 60, 80))
    found = verdicts({name: {0: low, 1: low} for name in PAIR}, 1, parameters=SelectionParameters.paper())
    assert list(found) == [
        "inspected by a detector",
        "container",
        "N",
        "penalties",
        "score of the pair",
    ]
    best = select_best_frame({name: {0: low} for name in PAIR}, pair=PAIR)
    rules = [
        each.rule
        for each in frame_verdicts({name: {0: low} for name in PAIR}, best, 0, parameters=SelectionParameters())
    ]
    assert "container (both thirds; leaves no frame)" in rules
    assert "container (horizontal third)" in rules
