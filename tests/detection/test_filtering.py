import numpy as np
import pytest

from corsmal.detection import Detections, filter_detections
from corsmal.errors import ArgumentError
from corsmal.parameters import SelectionParameters

SIZE = (90, 120)
MIDDLE = (60, 45)


def detections_at(*rows):
    """Detections of 4x4 boxes from (label, score, centre)."""
    return Detections(
        boxes=[[x - 2, y - 2, x + 2, y + 2] for _, _, (x, y) in rows],
        scores=[score for _, score, _ in rows],
        labels=[label for label, _, _ in rows],
        masks=np.zeros((len(rows), *SIZE), dtype=bool),
    )


def test_nothing_detected_leaves_nothing():
    filtered = filter_detections(detections_at())
    assert filtered.kept.tolist() == []
    assert filtered.reasons == ()
    assert filtered.container is None


@pytest.mark.parametrize("label", [44, 46, 47, 84, 86])
def test_a_container_in_the_middle_is_kept(label):
    filtered = filter_detections(detections_at((label, 0.5, MIDDLE)))
    assert filtered.reasons == (None,)
    assert filtered.container == 0


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        ((64, 0.9, MIDDLE), "class 64 is no container"),
        ((47, 0.42, MIDDLE), "score 0.42 is below 0.50"),
        ((47, 0.4999, MIDDLE), "score 0.4999 is below 0.5000"),
        ((47, 0.9, (60, 70)), "centre at 78 % of the height is outside the middle third"),
        ((47, 0.9, (12, 45)), "centre at 10 % of the width is outside the middle third"),
        ((47, 0.9, (108, 9)), "centre at 90 % of the width and 10 % of the height is outside the middle third"),
        ((64, 0.1, (0, 0)), "class 64 is no container"),
        ((47, 0.1, (0, 0)), "score 0.10 is below 0.50"),
    ],
)
def test_the_first_rule_that_is_broken_is_the_reason(row, reason):
    filtered = filter_detections(detections_at(row))
    assert filtered.reasons == (reason,)
    assert filtered.kept.tolist() == []


@pytest.mark.parametrize(("x", "inside"), [(39, False), (40, True), (80, True), (80.5, False)])
def test_a_centre_on_the_border_of_the_third_counts_as_inside(x, inside):
    assert (filter_detections(detections_at((47, 0.9, (x, 45)))).container == 0) == inside


@pytest.mark.parametrize(("y", "inside"), [(29, False), (30, True), (60, True), (61, False)])
def test_the_height_has_its_own_third(y, inside):
    assert (filter_detections(detections_at((47, 0.9, (60, y)))).container == 0) == inside


@pytest.mark.parametrize(("rule", "kept"), [("both thirds", [0]), ("horizontal third", [0, 1]), ("none", [0, 1, 2])])
def test_each_rung_of_the_ladder_lets_more_pass(rule, kept):
    detections = detections_at((47, 0.9, MIDDLE), (47, 0.8, (60, 70)), (47, 0.7, (10, 70)))
    assert filter_detections(detections, centre_rule=rule).kept.tolist() == kept


def test_the_three_highest_scores_stay_highest_first():
    detections = detections_at(*((47, score, MIDDLE) for score in (0.6, 0.9, 0.7, 0.8)))
    filtered = filter_detections(detections)
    assert filtered.kept.tolist() == [1, 3, 2]
    assert filtered.container == 1
    assert filtered.reasons == ("three detections score higher", None, None, None)


def test_of_equal_scores_the_first_stay():
    detections = detections_at(*((47, 0.8, MIDDLE) for _ in range(5)))
    assert filter_detections(detections).kept.tolist() == [0, 1, 2]


def test_dropped_detections_take_no_place_among_the_three():
    rows = [(64, 1.0, MIDDLE), (47, 1.0, (0, 0)), *((47, 0.6, MIDDLE) for _ in range(3))]
    assert filter_detections(detections_at(*rows)).kept.tolist() == [2, 3, 4]


def test_the_parameters_are_obeyed():
    detections = detections_at((64, 0.3, MIDDLE), (64, 0.2, MIDDLE), (47, 0.9, MIDDLE))
    parameters = SelectionParameters(score_min=0.2, detections_max=1, classes=frozenset({64}))
    filtered = filter_detections(detections, parameters=parameters)
    assert filtered.kept.tolist() == [0]
    assert filtered.reasons == (None, "one detection scores higher", "class 47 is no container")


def test_an_unknown_centre_rule_is_an_error():
    with pytest.raises(ArgumentError, match="centre_rule must be one of"):
        filter_detections(detections_at(), centre_rule="thirds")
