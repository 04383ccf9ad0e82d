"""Estimates with the shape and the selection of the authors' released program."""

from dataclasses import replace

import pytest

from corsmal.dataset import open_dataset
from corsmal.estimation import Fit, counted_frames, estimate, file_detections, mass_inputs
from corsmal.estimation.fit import RecordingMasks, fit_frame
from corsmal.parameters import SelectionParameters, ShapeParameters
from corsmal.quantities import GEOMETRY
from tests.fakes import FakeMass

SHAPE, SELECTION = ShapeParameters.released(), SelectionParameters.released()
MEANS = {
    "capacity_ml": 640.0,
    "width_top_mm": 92.0,
    "width_bottom_mm": 76.0,
    "height_mm": 130.0,
    "container_mass_g": 40.0,
}


@pytest.fixture(scope="module")
def recording(tiny_dataset_root):
    return open_dataset(tiny_dataset_root)["000000"]


@pytest.fixture(scope="module")
def detections(recording):
    return file_detections(recording)[0]


def with_width(recording, detections, **widths):
    """A source of fits, of which a width is replaced."""

    def fits(*, pair, frame, centre_rule):
        choice = {"pair": pair, "frame": frame, "centre_rule": centre_rule}
        fit = fit_frame(recording, detections, **choice, shape=SHAPE, selection=SELECTION)
        missing = {name: "a test" for name, width in widths.items() if width is None}
        return Fit(pair, frame, fit.hull, replace(fit.dimensions, **widths, unmeasured=missing))

    return fits


def test_both_are_used_on_the_programs_own_pair(recording, detections):
    result = estimate(recording, detections=detections, shape=SHAPE, selection=SELECTION, means=MEANS)
    assert (result.status, result.fit.pair, result.centre_rule) == ("fitted", ("view1", "view2"), "middle half")
    counted = counted_frames(recording, SELECTION)
    assert result.fit.frame in counted
    assert {score.frame for score in result.best_frame.scores} == set(counted)
    alone = fit_frame(
        recording, detections, pair=("view1", "view2"), frame=result.fit.frame, centre_rule="middle half", shape=SHAPE,
        selection=SELECTION,
    )  # fmt: skip
    assert result.capacity_ml == alone.dimensions.capacity_ml


@pytest.mark.parametrize(("means", "width"), [(MEANS, 92.0), ({}, None)])
def test_a_width_that_fails_is_a_training_mean_by_itself(recording, detections, means, width):
    fits = with_width(recording, detections, width_top_mm=None, width_bottom_mm=70.0)
    result = estimate(recording, detections=detections, shape=SHAPE, selection=SELECTION, means=means, fits=fits)
    assert result.status == "fitted"
    assert (result.width_top_mm, result.width_bottom_mm) == (width, 70.0)
    assert result.height_mm != MEANS["height_mm"]
    assert result.flags == ("width-missing",)
    assert "top width: a test" in result.notes[-1]
    assert result.row()["width_top_mm"] == width


def test_the_next_pair_is_tried_and_then_the_means_stand_in(recording, detections):
    some = {name: detections[name] for name in ("view1", "view3")}
    result = estimate(recording, detections=some, shape=SHAPE, selection=SELECTION, means=MEANS)
    assert (result.status, result.fit.pair) == ("fitted, second pair", ("view1", "view3"))
    none = estimate(recording, detections={"view3": detections["view3"]}, shape=SHAPE, selection=SELECTION, means=MEANS)
    assert none.status == "fallback: training mean"
    assert [getattr(none, name) for name in GEOMETRY] == [MEANS[name] for name in GEOMETRY]


def test_a_third_pair_can_be_named(recording, detections):
    shape = replace(SHAPE, pairs=(("view1", "view2"), ("view1", "view3"), ("view2", "view3")))
    some = {name: detections[name] for name in ("view2", "view3")}
    result = estimate(recording, detections=some, shape=shape, selection=SELECTION)
    assert result.status == "fitted, third pair"


def test_frame_0_is_fitted_and_flagged_where_no_frame_counts(recording, detections):
    strict = replace(SELECTION, object_score_min=1.0)
    result = estimate(recording, detections=detections, shape=SHAPE, selection=strict)
    assert result.best_frame.frame == 0
    assert "frame-fallback" in result.flags


def test_the_mass_is_told_from_the_frontal_views_own_best_frame(recording, detections):
    network = FakeMass(12.0)
    frontal = {frame: detections["view3"][frame] for frame in (0, 5)}
    views = {**detections, "view3": frontal}
    result = estimate(recording, detections=views, shape=SHAPE, selection=SELECTION, mass=network)
    assert result.mass_frame in (0, 5)
    masks = RecordingMasks(recording, views, SELECTION)
    expected = masks.mask("view3", result.mass_frame, "middle half")
    assert (network.mask == expected).all()
    assert (mass_inputs(result, masks)["mask"] == expected).all()


def test_without_a_container_in_the_frontal_view_the_mean_mass_stands_in(recording, detections):
    some = {name: detections[name] for name in ("view1", "view2")}
    network = FakeMass(12.0)
    result = estimate(recording, detections=some, shape=SHAPE, selection=SELECTION, means=MEANS, mass=network)
    assert result.status == "fitted"
    assert (result.container_mass_g, network.mask) == (40.0, None)
    assert "view3 has no detections; the training mean stands in" in result.notes[-1]
