import numpy as np
import pytest

from corsmal.detection import Detections
from corsmal.errors import ArgumentError, NotFoundError
from corsmal.parameters import SelectionParameters
from corsmal.selection import FrameScore, score_frames, select_best_frame, total_penalty, view_score
from corsmal.selection.best import view_evidence

SIZE = (90, 90)
CUP, CHAIR = 47, 62


def detections_of(*boxes, scores=None, labels=None, pixels=None):
    """Detections with given boxes; each mask is the first ``pixels`` pixels of the image, else the box."""
    masks = np.zeros((len(boxes), *SIZE), dtype=bool)
    for i, (x1, y1, x2, y2) in enumerate(boxes):
        if pixels is None:
            masks[i, round(y1) : round(y2), round(x1) : round(x2)] = True
        else:
            masks[i].flat[: pixels[i]] = True
    return Detections(
        boxes=np.array(boxes, dtype=float).reshape(-1, 4),
        scores=np.array(scores if scores is not None else 0.9 - 0.1 * np.arange(len(boxes))),
        labels=np.array(labels if labels is not None else [CUP] * len(boxes), dtype=int),
        masks=masks,
    )


CENTRED = (40, 40, 50, 50)
LOW = (40, 70, 50, 80)
ASIDE = (5, 40, 15, 50)


def penalty(first, second):
    return total_penalty(detections_of(first, second))


def test_penalty_counts_the_pixels_in_both_boxes_twice():
    assert penalty((0, 0, 10, 10), (6, 7, 20, 20)) == 2 * 4 * 3
    assert penalty((0, 0, 10, 10), (10, 0, 20, 10)) == 0
    assert penalty((0, 0, 10, 10), (12, 12, 20, 20)) == 0


def test_penalty_rounds_boxes_to_whole_pixels():
    assert penalty((0.4, 0, 9.6, 10), (8.6, 0, 20, 10)) == 2 * 1 * 10


def test_total_penalty_is_twice_all_pairs():
    boxes = [(0, 0, 10, 10), (5, 0, 15, 10), (8, 0, 18, 10)]
    # overlaps 5, 2 and 7 columns of 10 rows
    assert total_penalty(detections_of(*boxes)) == 2 * (50 + 20 + 70)
    assert total_penalty(detections_of(boxes[0])) == 0
    assert total_penalty(detections_of()) == 0


def test_view_score_takes_the_penalties_of_both_views():
    first = detections_of((0, 0, 10, 10), (5, 0, 15, 10), pixels=[600, 30])
    second = detections_of((0, 0, 10, 10), (9, 9, 19, 19), pixels=[250, 30])
    assert view_score(first, second) == 600 - (2 * 50 + 2 * 1)
    assert view_score(second, first) == 250 - (2 * 50 + 2 * 1)
    with pytest.raises(ArgumentError, match="container"):
        view_score(detections_of(), first)


def test_frame_score_by_hand():
    score = FrameScore(4, (600, 250), (100, 2))
    assert score.view_scores == (498, 148)
    assert score.total == 646
    assert FrameScore(4, (600, None), (100, 0)).total is None


def test_best_frame_is_the_first_of_the_highest_scores():
    small, large = detections_of(CENTRED, pixels=[100]), detections_of(CENTRED, pixels=[300])
    overlapped = detections_of(CENTRED, (42, 42, 52, 52), pixels=[500, 10])
    views = {
        "view3": {0: small, 1: large, 2: large, 3: overlapped},
        "view1": {0: large, 1: large, 2: large, 3: small},
    }
    best = select_best_frame(views, pair=("view3", "view1"))
    # frame 3: overlap of 8 x 8 pixels in view3 makes TP = 128, taken off both views' scores
    assert [score.total for score in best.scores] == [400, 600, 600, 500 + 100 - 2 * 128]
    assert best.frame == 1
    assert best.centre_rule == "both thirds"
    assert best.score == best.scores[1]


def test_a_frame_needs_a_container_in_both_views():
    found, none = detections_of(CENTRED), detections_of()
    views = {"view3": {0: found, 1: found, 2: none}, "view1": {0: none, 1: found, 3: found}}
    best = select_best_frame(views, pair=("view3", "view1"))
    assert best.frame == 1
    assert [score.frame for score in best.scores] == [0, 1]
    assert best.scores[0].mask_pixels == (100, None)


@pytest.mark.parametrize(
    ("box", "rule"), [(CENTRED, "both thirds"), (LOW, "horizontal third"), (ASIDE, "none"), ((0, 0, 6, 6), "none")]
)
def test_the_ladder_stops_at_the_first_rung_that_leaves_a_frame(box, rule):
    views = {"view3": {0: detections_of(CENTRED)}, "view1": {0: detections_of(box)}}
    best = select_best_frame(views, pair=("view3", "view1"))
    assert (best.frame, best.centre_rule) == (0, rule)


def test_a_rung_is_left_only_if_no_frame_at_all_qualifies():
    views = {
        "view3": {0: detections_of(CENTRED), 1: detections_of(CENTRED, pixels=[1])},
        "view1": {0: detections_of(LOW, pixels=[5000]), 1: detections_of(CENTRED, pixels=[1])},
    }
    assert select_best_frame(views, pair=("view3", "view1")).frame == 1


def test_other_classes_and_low_scores_are_no_container():
    views = {
        "view3": {0: detections_of(CENTRED, labels=[CHAIR]), 1: detections_of(CENTRED, scores=[0.4])},
        "view1": {0: detections_of(CENTRED), 1: detections_of(CENTRED)},
    }
    best = select_best_frame(views, pair=("view3", "view1"))
    assert not best.ok
    assert "none of 2 inspected frames" in best.reason
    assert best.score is None


def test_a_view_without_detections_is_named():
    views = {"view3": {0: detections_of(CENTRED)}}
    best = select_best_frame(views, pair=("view3", "view2"))
    assert best.reason == "no detections for view2"
    with pytest.raises(NotFoundError, match="view2"):
        score_frames(views, pair=("view3", "view2"))


def test_views_without_a_common_frame_have_no_best_frame():
    views = {"view3": {0: detections_of(CENTRED)}, "view1": {1: detections_of(CENTRED)}}
    assert "no inspected frame" in select_best_frame(views, pair=("view3", "view1")).reason


def test_all_frames_at_once_are_as_frame_by_frame():
    rng = np.random.default_rng(5)

    def found():
        count = int(rng.integers(1, 9))
        corners = rng.uniform(0, 70, (count, 2))
        boxes = np.hstack([corners, corners + rng.uniform(0, 40, (count, 2))]).round(1)
        scores, labels = rng.choice([0.4, 0.5, 0.7, 0.9], count), rng.choice([CUP, CHAIR], count, p=[0.9, 0.1])
        return detections_of(*boxes.tolist(), scores=scores, labels=labels, pixels=rng.integers(0, 8000, count))

    views = {name: {frame: found() for frame in range(60)} for name in ("view3", "view1")}
    parameters = SelectionParameters(detections_max=2)
    for rule in parameters.centre_rules:
        scores = score_frames(views, pair=("view3", "view1"), centre_rule=rule, parameters=parameters)
        slow = [
            [view_evidence(view[frame], centre_rule=rule, parameters=parameters) for view in views.values()]
            for frame in range(60)
        ]
        assert [score.mask_pixels for score in scores] == [tuple(each.pixels for each in two) for two in slow]
        assert [score.penalties for score in scores] == [tuple(each.penalty for each in two) for two in slow]
        assert len({score.total for score in scores}) > 2
