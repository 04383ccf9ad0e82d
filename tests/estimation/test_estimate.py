from dataclasses import replace
from math import isfinite

import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.detection import Detections, ViewDetections
from corsmal.estimation import (
    container_mask,
    estimate,
    file_detections,
    fit_frame,
    read_view_detections,
)
from corsmal.parameters import PAIRS, SelectionParameters, ShapeParameters
from corsmal.quantities import GEOMETRY
from tests.tiny import CONTAINERS, CUP, FRAMES, base_in_frame, capacity_ml, silhouette, write_json

MEANS = {"capacity_ml": 640.0, "width_top_mm": 92.0, "width_bottom_mm": 76.0, "height_mm": 130.0}


@pytest.fixture(scope="module")
def dataset(tiny_dataset_root):
    return open_dataset(tiny_dataset_root)


@pytest.fixture(scope="module")
def recording(dataset):
    return dataset["000000"]


@pytest.fixture(scope="module")
def detections(recording):
    found, notes = file_detections(recording)
    assert notes == ()
    return found


def one_pixel_masks(view):
    """The same detections whose masks are the middle pixel of their box: no contour of them has an area."""
    frames = {}
    for frame, found in view.items():
        masks = np.zeros((len(found), *view.size), dtype=bool)
        for mask, (left, top, right, bottom) in zip(masks, found.boxes, strict=True):
            mask[int(top + bottom) // 2, int(left + right) // 2] = True
        frames[frame] = Detections(found.boxes, found.scores, found.labels, masks)
    return ViewDetections(frames, size=view.size, source="a test")


def values_of(result):
    return [getattr(result, name) for name in GEOMETRY]


def with_broken_calibration(recording, view, path):
    path.write_bytes(b"\x80\x04 this is no calibration")
    return replace(recording, views={**recording.views, view: replace(recording.views[view], calibration_path=path)})


def test_a_clean_recording_is_fitted_near_the_truth(recording):
    result = estimate(recording)
    assert (result.recording_id, result.status, result.notes) == ("000000", "fitted", ())
    assert result.fit.pair == PAIRS[0]
    assert result.fit.frame == result.best_frame.frame
    assert not result.best_frame.is_by_fit
    assert result.centre_rule == result.best_frame.centre_rule
    truth = CONTAINERS[0]
    assert 0.9 < result.capacity_ml / capacity_ml(truth.profile) < 1.3
    assert abs(result.width_top_mm - truth.width_top_mm) < 0.2 * truth.width_top_mm
    assert values_of(result) == values_of(result.fit.dimensions)


def test_the_ladder_reaches_the_estimate(dataset):
    result = estimate(dataset["000001"])
    assert result.status == "fitted"
    assert result.centre_rule == "horizontal third"


def test_the_second_pair_is_used_where_the_first_has_no_detections(recording, detections):
    result = estimate(recording, detections={name: detections[name] for name in ("view2", "view3")})
    assert result.status == "fitted, second pair"
    assert result.fit.pair == result.best_frame.pair == PAIRS[1]
    assert result.notes == ("view3 + view1: no detections for view1",)


def test_the_second_pair_is_used_where_the_first_cannot_be_fitted(recording, detections):
    result = estimate(recording, detections={**detections, "view1": one_pixel_masks(detections["view1"])})
    assert result.status == "fitted, second pair"
    [note] = result.notes
    assert note.startswith("view3 + view1, frame ")
    assert note.endswith("mask 2 of 2 has no area")


def test_a_broken_calibration_is_a_note(recording, tmp_path):
    broken = with_broken_calibration(recording, "view1", tmp_path / "view1.pickle")
    result = estimate(broken)
    assert result.status == "fitted, second pair"
    [note] = result.notes
    assert str(tmp_path / "view1.pickle") in note


def test_an_absent_calibration_is_a_note(recording):
    views = {**recording.views, "view3": replace(recording.views["view3"], calibration_path=None)}
    result = estimate(replace(recording, views=views), means=MEANS)
    assert result.status == "fallback: training mean"
    assert len(result.notes) == 2
    assert all("calibration of view3 is missing" in note for note in result.notes)


def test_a_broken_detections_file_is_a_note(recording, tmp_path):
    path = tmp_path / "000000.json"
    path.write_text("[{")
    views = {**recording.views, "view1": replace(recording.views["view1"], detections_path=path)}
    result = estimate(replace(recording, views=views))
    assert result.status == "fitted, second pair"
    broken, missing = result.notes
    assert str(path) in broken
    assert missing == "view3 + view1: no detections for view1"


def test_the_means_stand_in_where_both_pairs_fail_and_it_is_said(recording, detections):
    result = estimate(recording, detections={**detections, "view3": one_pixel_masks(detections["view3"])}, means=MEANS)
    assert result.status == "fallback: training mean"
    assert dict(zip(GEOMETRY, values_of(result), strict=True)) == MEANS
    assert (result.fit, result.best_frame, result.centre_rule) == (None, None, None)
    assert [note.split(",")[0] for note in result.notes] == ["view3 + view1", "view3 + view2"]
    assert all("has no area" in note for note in result.notes)


@pytest.mark.parametrize("means", [None, {}])
def test_without_means_a_failure_holds_no_numbers(recording, means):
    result = estimate(recording, detections={}, means=means)
    assert (result.status, values_of(result)) == ("failed", [None] * 4)
    assert len(result.notes) == 2


def test_a_recording_of_nothing_fails_with_a_reason(recording):
    result = estimate(replace(recording, views={}))
    assert (result.status, len(result.notes)) == ("failed", 2)


@pytest.mark.parametrize("name", ["000000", "000001", "000002"])
@pytest.mark.parametrize("shape", [ShapeParameters(), ShapeParameters.lode(), ShapeParameters(max_difference_mm=0)])
def test_estimates_never_hold_nan(dataset, name, shape):
    result = estimate(dataset[name], shape=shape)
    assert all(value is None or isfinite(value) for value in values_of(result))
    assert (result.status == "failed") == (values_of(result) == [None] * 4)


def test_parameters_of_the_filter_are_heeded(recording):
    result = estimate(recording, selection=SelectionParameters(score_min=0.99))
    assert result.status == "failed"
    assert "none of 12 inspected frames shows a container" in result.notes[0]


def fit(recording, detections, **changes):
    return fit_frame(
        recording, detections, **{"pair": PAIRS[0], "frame": 0, "centre_rule": "horizontal third", **changes}
    )


def test_fitting_one_frame(recording, detections):
    made = fit(recording, detections, frame=2)
    assert made.ok
    true_z = 1000 * (base_in_frame(CONTAINERS[0], 2)[2] + np.array([0, 0.119]))
    converged = made.hull.heights_mm[made.hull.converged]
    assert converged.min() < true_z.mean() < converged.max()


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"frame": FRAMES}, f"frame {FRAMES} of view3 was not inspected"),
        ({"pair": ("view3", "view4")}, "view4 has no video"),
    ],
)
def test_what_is_not_there_is_a_failed_fit_with_the_reason(recording, detections, change, reason):
    made = fit(recording, detections, **change)
    assert not made.ok
    assert made.dimensions.reason == made.hull.reason == reason


def test_a_view_without_detections_is_a_failed_fit(recording, detections):
    made = fit(recording, {"view3": detections["view3"]})
    assert made.dimensions.reason == "view1 has no detections"


def test_a_frame_without_a_container_is_a_failed_fit(recording, detections):
    nothing = Detections([], [], [], np.zeros((0, 360, 640), dtype=bool))
    made = fit(recording, {**detections, "view1": {0: nothing}})
    assert made.dimensions.reason == "view1 has no container in frame 0"


def test_masks_of_another_size_are_a_failed_fit(recording, detections):
    small = Detections([[10, 10, 20, 20]], [0.9], [CUP], np.ones((1, 30, 30), dtype=bool))
    made = fit(recording, {**detections, "view1": {0: small}})
    assert "(360, 640)" in made.dimensions.reason
    assert "(30, 30)" in made.dimensions.reason


def test_the_containers_mask_is_that_of_the_first_kept_detection(recording, detections):
    view = recording.views["view3"]
    truth = silhouette(view.camera(), CONTAINERS[0].profile, base_in_frame(CONTAINERS[0], 3))
    found = detections["view3"][3]
    assert len(found) == 3
    chosen = container_mask(found, centre_rule="none", parameters=SelectionParameters())
    np.testing.assert_array_equal(chosen, truth)
    nothing = container_mask(found, centre_rule="none", parameters=SelectionParameters(score_min=1))
    assert (nothing.shape, nothing.any()) == (truth.shape, False)


def test_detections_of_a_file_cover_every_frame_of_the_video(recording, tmp_path):
    view = recording.views["view3"]
    assert read_view_detections(replace(view, detections_path=None)) is None
    empty = replace(view, detections_path=write_json(tmp_path / "empty.json", []))
    assert read_view_detections(empty).frames == tuple(range(FRAMES))
