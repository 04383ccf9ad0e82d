from dataclasses import replace

import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.estimation import (
    Fit,
    choose_frames,
    estimate,
    file_detections,
    fit_frame,
)
from corsmal.estimation.intervals import BOX_SCALES, CAPACITY_SCALE, LENGTH_SCALE, ROUND_SCALES, frame_intervals
from corsmal.estimation.several import APART_WEIGHT, BOX_LOSS, BOX_SLOPE, combine_fits, expected_error_pct
from corsmal.parameters import ShapeParameters
from corsmal.quantities import GEOMETRY
from corsmal.selection import select_best_frame
from corsmal.shape import Dimensions, Hull
from tests.tiny import tiny_cameras

PAIR = ("view3", "view1")


class SeenView:
    def __init__(self, camera):
        self.camera = lambda: camera


class Seen:
    """A recording of which only the cameras are known."""

    def __init__(self):
        self.views = {name: SeenView(camera) for name, camera in tiny_cameras().items()}


SEEN = Seen()


def fit(frame, *, overlap, capacity_ml=500.0, depth_mm=None, box_gain=None, error_pct=None):
    hull = Hull(
        np.array([0.0, 100.0]),
        np.array([40.0, 40.0]),
        np.ones(2, dtype=bool),
        np.array([0.0, 0.0, 0.05]),
        depth_mm=depth_mm,
        overlap=overlap,
        box_gain=box_gain,
        error_pct=error_pct,
    )
    return Fit(PAIR, frame, hull, Dimensions(capacity_ml, 80.0, 80.0, 100.0))


def test_the_weighted_median_of_all_fits_counts():
    fits = [fit(n, overlap=0.9, capacity_ml=500.0 + 10 * n) for n in range(9)]
    found = combine_fits(fits, SEEN)
    assert found.fit.frame == 0
    assert found.values["capacity_ml"] == pytest.approx(540)
    assert found.values["height_mm"] == 100


def test_what_explains_the_masks_better_counts_more():
    # squares of the overlaps: 0.64, 0.16, 0.16; the first one's middle is at 0.32, the second's at 0.72, half at 0.48
    capacities = {0: (0.8, 400.0), 1: (0.4, 500.0), 2: (0.4, 600.0)}
    fits = [fit(frame, overlap=overlap, capacity_ml=value) for frame, (overlap, value) in capacities.items()]
    assert combine_fits(fits, SEEN).values["capacity_ml"] == pytest.approx(400 + 100 * (0.48 - 0.32) / (0.72 - 0.32))


def test_a_smaller_predicted_error_counts_with_its_square():
    # inverse squares: 1/4, 1/16, 1/16; the first one's middle is at 0.125, the second's at 0.28125, half at 0.1875
    errors = {0: (2.0, 400.0), 1: (4.0, 500.0), 2: (4.0, 600.0)}
    fits = [fit(n, overlap=0.8, capacity_ml=value, error_pct=error) for n, (error, value) in errors.items()]
    middle = 400 + 100 * (0.1875 - 0.125) / (0.28125 - 0.125)
    assert combine_fits(fits, SEEN).values["capacity_ml"] == pytest.approx(middle)


def test_intervals_hold_spread_and_a_pixel():
    found = combine_fits([fit(n, overlap=0.9, capacity_ml=480.0 + 5 * n) for n in range(9)], SEEN)
    low, high = found.intervals["height_mm"]
    camera_mm = [
        1000 * np.linalg.norm(view.camera().centre_m - [0, 0, 0.05]) / view.camera().intrinsic[0, 0]
        for view in (SEEN.views[name] for name in PAIR)
    ]
    assert (high - low) / 2 == pytest.approx(LENGTH_SCALE * np.mean(camera_mm))
    low, high = found.intervals["capacity_ml"]
    pixels = 500 * np.mean(camera_mm) * (1 / 80 + 1 / 80 + 1 / 100)
    assert (low + high) / 2 == pytest.approx(500)
    spread = 5 * 0.8 * 9 / 2  # between the first and the last tenth of the nine
    assert (high - low) / 2 == pytest.approx(CAPACITY_SCALE * np.hypot(spread, pixels))


def test_all_fits_decide_whether_it_is_a_box_by_how_much_better_boxes_explain():
    votes = [fit(n, overlap=0.8, capacity_ml=900.0, box_gain=-0.02) for n in range(3)]
    votes += [fit(n, overlap=0.8, depth_mm=50.0, box_gain=0.04) for n in (3, 4, 5)]
    found = combine_fits(votes, SEEN)
    assert found.values["capacity_ml"] == 500
    assert found.fit.hull.depth_mm == 50
    assert found.box_odds == pytest.approx(np.exp(BOX_SLOPE * ((3 * 0.04 - 3 * 0.02) / 6 + BOX_LOSS)))
    found = combine_fits([replace_gain(vote, -0.1 if vote.hull.depth_mm is None else 0.04) for vote in votes], SEEN)
    assert found.values["capacity_ml"] == 900
    assert found.box_odds < 1


def replace_gain(vote, gain):
    return replace(vote, hull=replace(vote.hull, box_gain=gain))


def test_the_fit_with_the_least_predicted_error_is_shown():
    fits = [fit(0, overlap=0.95, error_pct=12.0), fit(1, overlap=0.8, error_pct=4.0), fit(2, overlap=0.9)]
    assert combine_fits(fits, SEEN).fit.frame == 1


def test_a_fit_that_lies_far_from_the_others_is_not_shown_however_well_it_explains_its_masks():
    others = [fit(n, overlap=0.8, error_pct=5.0 + n) for n in range(1, 5)]
    assert combine_fits([fit(0, overlap=0.95, error_pct=3.0, capacity_ml=700.0), *others], SEEN).fit.frame == 1
    expected = np.hypot(3.0, 100 * APART_WEIGHT * np.log(1.25) / 4)  # three of the four quantities agree
    values = {"capacity_ml": 400.0, "width_top_mm": 80.0, "width_bottom_mm": 80.0, "height_mm": 100.0}
    assert expected_error_pct(fit(0, overlap=0.9, error_pct=3.0), values) == pytest.approx(expected)


def test_one_frame_has_the_interval_that_its_predicted_error_gives():
    found = combine_fits([fit(3, overlap=0.9, error_pct=10.0)], SEEN)
    low, high = found.intervals["height_mm"]
    assert (low + high) / 2 == pytest.approx(100)
    assert (high - low) / 2 == pytest.approx(100 * 0.10 * ROUND_SCALES[3])
    wide = frame_intervals(fit(3, overlap=0.9, error_pct=20.0))["height_mm"]
    assert wide[1] - wide[0] == pytest.approx(2 * (high - low))
    boxed = frame_intervals(fit(3, overlap=0.9, error_pct=10.0, depth_mm=40.0))["capacity_ml"]
    assert (boxed[1] - boxed[0]) / 2 == pytest.approx(500 * 0.10 * BOX_SCALES[0])


def test_one_frame_has_no_interval_and_none_no_answer():
    assert combine_fits([fit(3, overlap=None)], SEEN).intervals == {}
    failed = Fit(PAIR, 0, Hull.failed("no"), Dimensions(reason="no"))
    assert combine_fits([failed], SEEN) is None
    assert combine_fits([], SEEN) is None
    assert combine_fits([failed, fit(1, overlap=0.5)], SEEN).fit.frame == 1


@pytest.fixture(scope="module")
def tiny(tiny_dataset_root):
    recording = open_dataset(tiny_dataset_root)["000000"]
    return recording, file_detections(recording)[0]


def test_an_estimate_over_several_frames_carries_intervals_into_its_row(tiny):
    recording, detections = tiny
    found = estimate(recording, detections=detections, shape=replace(ShapeParameters.tuned(), frames=3))
    assert found.status == "fitted"
    assert found.height_mm == pytest.approx(119, rel=0.04)
    assert found.best_frame.frame == found.fit.frame
    assert found.best_frame.is_by_fit
    row = found.row()
    for name in GEOMETRY:
        assert row[f"{name}_low"] < row[name] < row[f"{name}_high"]
    assert "height_mm_low" not in estimate(recording, detections=detections).row()


def test_frames_are_the_best_of_equal_stretches(tiny):
    _, detections = tiny
    best, frames = choose_frames(detections, pair=PAIR, shape=ShapeParameters(frames=2))
    totals = {score.frame: score.total for score in best.scores if score.total is not None}
    scored = sorted(totals)
    half = (len(scored) + 1) // 2
    assert frames == [max(part, key=totals.get) for part in (scored[:half], scored[half:])]
    assert best.frame in frames
    alone, frames = choose_frames(detections, pair=PAIR, shape=ShapeParameters.paper())
    assert frames == [alone.frame] == [select_best_frame(detections).frame]
    assert choose_frames({}, pair=PAIR, shape=ShapeParameters.paper())[1] == []


def test_the_third_view_joins_where_it_shows_the_container(tiny):
    recording, detections = tiny
    choice = {"pair": ("view3", "view2"), "frame": 2, "centre_rule": "none"}
    two = replace(ShapeParameters.tuned(), all_views=False)
    pair, three = (fit_frame(recording, detections, **choice, shape=shape) for shape in (two, ShapeParameters.tuned()))
    without = {name: views for name, views in detections.items() if name != "view1"}
    alone = fit_frame(recording, without, **choice, shape=ShapeParameters.tuned())
    assert three.ok
    assert list(three.view_weights) == ["view3", "view2", "view1"]
    assert list(pair.view_weights) == ["view3", "view2"]
    assert three.dimensions.capacity_ml != pair.dimensions.capacity_ml
    assert alone.dimensions.capacity_ml == pair.dimensions.capacity_ml


def test_several_frames_are_chosen_whatever_the_centre_rule_left(tiny):
    recording, detections = tiny
    best = select_best_frame(detections)
    found, _ = choose_frames(detections, pair=PAIR, shape=ShapeParameters.tuned())
    assert best.centre_rule != found.centre_rule == "none"
    assert {score.frame for score in found.scores} == set(detections["view3"]) & set(detections["view1"])
    assert estimate(recording, detections=detections, shape=ShapeParameters.tuned()).centre_rule == "none"
    assert estimate(recording, detections=detections).centre_rule == best.centre_rule
