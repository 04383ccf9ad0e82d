"""The mass and the filling in an estimate, with predictors whose answers are known."""

from dataclasses import replace

import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.detection import ViewDetections, filter_detections
from corsmal.estimation import container_mask, estimate, file_detections, frontal_frame
from corsmal.evaluation import ESTIMATE_COLUMNS
from corsmal.filling import FillingPrediction
from corsmal.filling.features import Features
from corsmal.mass import MassPrediction, restore_mask
from corsmal.parameters import SelectionParameters, ShapeParameters
from corsmal.selection import total_penalty
from tests.fakes import FakeFilling, FakeMass


@pytest.fixture(scope="module")
def recording(tiny_dataset_root):
    return open_dataset(tiny_dataset_root)["000000"]


def test_mass_is_told_from_the_robots_view_in_the_best_frame_and_the_measures(recording):
    asked = FakeMass(33.0)
    result = estimate(recording, mass=asked)
    assert result.container_mass_g == 33.0
    found, _ = file_detections(recording)
    mask = container_mask(
        found["view3"][result.best_frame.frame], centre_rule=result.centre_rule, parameters=SelectionParameters()
    )
    np.testing.assert_array_equal(asked.mask, mask)
    measures = {name: getattr(result, name) for name in ("width_top_mm", "width_bottom_mm", "height_mm")}
    assert {name: asked.inputs[name] for name in measures} == measures
    camera = recording.views["view3"].camera()
    depth_m = (camera.rotation @ result.fit.hull.centroid_m + camera.translation)[2]
    assert asked.inputs["mm_per_px"] == pytest.approx(1000 * depth_m / camera.intrinsic[0, 0], rel=0.01)


def test_mass_network_is_given_the_reported_medians_of_several_frames(recording):
    asked = FakeMass(33.0)
    result = estimate(recording, mass=asked, shape=replace(ShapeParameters.tuned(), frames=4))
    names = ("width_top_mm", "width_bottom_mm", "height_mm")
    reported = {name: getattr(result, name) for name in names}
    assert {name: asked.inputs[name] for name in names} == reported
    assert {name: getattr(result.fit.dimensions, name) for name in names} != reported


def test_filling_is_told_from_the_sound_and_weighs_its_share_of_the_capacity(recording):
    result = estimate(recording, filling=FakeFilling(2, 1), mass=FakeMass(10.0))
    assert (result.filling.filling_type, result.filling.filling_level) == (2, 1)
    assert result.filling_mass_g == pytest.approx(0.5 * 0.82 * result.capacity_ml)
    assert result.object_mass_g == pytest.approx(10 + result.filling_mass_g)
    assert result.notes == ()


def test_features_can_come_from_elsewhere(recording):
    rows = np.full((1, 7, 128), 3, np.float32)
    asked = FakeFilling(1, 2)
    estimate(recording, filling=asked, features=lambda _: Features(rows, 0.96))
    assert asked.heard.shape == (1, 7, 128)
    assert asked.steps_s == 0.96


def test_recording_without_sound_keeps_its_measures_and_says_what_is_missing(recording):
    result = estimate(replace(recording, audio_path=None), filling=FakeFilling(1, 1), mass=FakeMass(10.0))
    assert result.status == "fitted"
    assert not result.filling.ok
    assert (result.filling_mass_g, result.object_mass_g) == (None, None)
    assert result.container_mass_g == 10
    [note] = result.notes
    assert note.startswith("filling: recording 000000 has no sound")


def test_failed_mass_is_no_number_and_a_note(recording):
    result = estimate(recording, mass=FakeMass(None))
    assert (result.container_mass_g, result.notes) == (None, ("container mass: nobody knows",))


MEANS = {
    "capacity_ml": 600.0,
    "width_top_mm": 90.0,
    "width_bottom_mm": 70.0,
    "height_mm": 130.0,
    "container_mass_g": 40.0,
}


def test_the_mean_mass_stands_in_where_the_robots_view_shows_nothing(recording):
    asked = FakeMass(33.0)
    result = estimate(replace(recording, views={}), mass=asked, filling=FakeFilling(3, 2), means=MEANS)
    assert (result.status, result.container_mass_g, asked.mask) == ("fallback: training mean", 40, None)
    assert result.object_mass_g == pytest.approx(40 + 0.9 * 600)
    assert result.flags == ("mass-assumed",)
    assert result.notes[-1] == (
        "container mass: view3 shows no container in any inspected frame; the training mean stands in"
    )


def without_a_fit(detections):
    """Nothing can be fitted with the robot's view only."""
    return {"view3": detections["view3"]}


def mask_of(detections, taken):
    frame, rule = taken
    return container_mask(detections["view3"][frame], centre_rule=rule, parameters=SelectionParameters())


def test_the_mass_is_told_from_mean_dimensions_where_nothing_was_fitted_and_flagged(recording):
    detections, _ = file_detections(recording)
    asked = FakeMass(33.0)
    result = estimate(recording, detections=without_a_fit(detections), mass=asked, means=MEANS)
    assert (result.status, result.container_mass_g) == ("fallback: training mean", 33)
    assert asked.inputs == {"width_top_mm": 90, "width_bottom_mm": 70, "height_mm": 130, "mm_per_px": None}
    np.testing.assert_array_equal(asked.mask, mask_of(detections, frontal_frame(detections, SelectionParameters())))
    assert result.flags == ("dimensions-assumed",)
    assert result.notes[-1] == (
        "container mass: predicted from the mean dimensions of the training set, as nothing was fitted"
    )
    assert estimate(recording, detections=without_a_fit(detections), mass=FakeMass(33.0)).container_mass_g is None


def test_a_network_that_cannot_use_mean_dimensions_leaves_the_mean_mass(recording):
    detections, _ = file_detections(recording)
    result = estimate(recording, detections=without_a_fit(detections), mass=FakeMass(None), means=MEANS)
    assert (result.container_mass_g, result.flags) == (40, ("mass-assumed",))
    assert result.notes[-1] == "container mass: nobody knows; the training mean stands in"


def test_the_robots_view_by_itself_gives_the_mask_where_the_fitted_frame_shows_none(recording):
    detections, _ = file_detections(recording)
    shape = replace(ShapeParameters.paper(), pairs=(("view1", "view2"),))
    whole = estimate(recording, detections=detections, shape=shape)
    assert whole.status == "fitted"
    view = detections["view3"]
    without = {at: view[at] for at in view if at != whole.best_frame.frame}
    others = {**detections, "view3": ViewDetections(without, size=view.size, source="a test")}
    frame, rule = frontal_frame(others, SelectionParameters())
    scores = {}
    for number, found in without.items():
        kept = found[filter_detections(found, centre_rule=rule).kept]
        if len(kept):
            scores[number] = int(kept.mask_areas[0]) - total_penalty(kept)
    assert frame == max(scores, key=scores.__getitem__)
    asked = FakeMass(33.0)
    result = estimate(recording, detections=others, shape=shape, mass=asked)
    assert (result.mass_frame, result.container_mass_g, result.flags) == (frame, 33, ())
    assert result.best_frame.frame != frame
    np.testing.assert_array_equal(asked.mask, mask_of(others, (frame, rule)))
    assert asked.inputs["height_mm"] == result.height_mm


def test_what_stands_in_for_the_networks_answer_is_flagged(recording):
    class Least(FakeMass):
        def predict(self, mask, **inputs):
            return replace(super().predict(mask, **inputs), notes=("the network's output is 0 g",))

    result = estimate(recording, mass=Least(2.0))
    assert (result.container_mass_g, result.flags) == (2, ("mass-assumed",))
    assert result.notes == ("container mass: the network's output is 0 g",)


def test_nothing_weighs_nothing_whatever_the_capacity(recording):
    result = estimate(replace(recording, views={}), filling=FakeFilling(0, 0))
    assert (result.status, result.filling_mass_g, result.object_mass_g) == ("failed", 0, None)


def test_row_has_the_columns_of_an_estimates_table(recording):
    row = estimate(recording, filling=FakeFilling(1, 1), mass=FakeMass(5.5)).row()
    assert list(row) == [name for name in ESTIMATE_COLUMNS if name in row]
    assert (row["recording_id"], row["status"], row["pair"], row["notes"]) == ("000000", "fitted", "view3 + view1", "")
    assert (row["filling_type"], row["filling_level"], row["container_mass_g"]) == (1, 1, 5.5)
    assert sum(row[f"type_p{index}"] for index in range(4)) == pytest.approx(1)
    bare = estimate(replace(recording, views={})).row()
    assert set(bare) == set(row)
    assert {bare[name] for name in ("capacity_ml", "filling_type", "level_p2", "best_frame", "object_mass_g")} == {None}


def test_fakes_answer_with_the_records_of_the_real_predictors(recording):
    assert isinstance(FakeFilling(0, 0).predict(np.zeros((1, 2, 128))), FillingPrediction)
    mask = np.zeros((20, 20), bool)
    mask[5:15, 5:12] = True
    found = FakeMass(1.0).predict(mask, width_top_mm=1, width_bottom_mm=1, height_mm=1)
    assert isinstance(found, MassPrediction)
    np.testing.assert_array_equal(found.restored.mask, restore_mask(mask).mask)
    assert recording.audio_path is not None
