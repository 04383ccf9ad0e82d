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
from corsmal.estimation.several import CAPACITY_SCALE, LENGTH_SCALE, combine_fits
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


def fit(frame, *, overlap, capacity_ml=500.0, depth_mm=None):
    hull = Hull(
        np.array([0.0, 100.0]),
        np.array([40.0, 40.0]),
        np.ones(2, dtype=bool),
        np.array([0.0, 0.0, 0.05]),
        depth_mm=depth_mm,
        overlap=overlap,
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


def test_most_of_the_best_decide_whether_it_is_a_box():
    fits = [fit(0, overlap=0.95, capacity_ml=900.0), *(fit(n, overlap=0.8, depth_mm=50.0) for n in (1, 2, 3))]
    found = combine_fits(fits, SEEN)
    assert found.fit.frame == 1
    assert found.values["capacity_ml"] == 500


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
