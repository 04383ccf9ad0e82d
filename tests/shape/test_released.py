"""The preset ``released``: the rules of the authors' program, against a slow version and by hand."""

import json
from dataclasses import replace
from itertools import pairwise

import cv2
import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.estimation import file_detections, fit_frame
from corsmal.geometry import Camera, triangulate
from corsmal.parameters import ShapeParameters
from corsmal.shape import Hull, fit_hull, measure_hull, on_mask
from corsmal.shape.sections import unit_circle
from corsmal.shape.steps import kept_steps, metres_of, step_ends
from tests.shape.test_circumferences import BASE_M, CUP, is_on
from tests.tiny import silhouette, tiny_cameras

RELEASED = ShapeParameters.released()
WIDTHS = ("width_bottom_mm", "width_top_mm")


def slow_measures(cameras: list[Camera], masks, parameters: ShapeParameters):
    """The program as one would write it down: OpenCV triangulates and projects, lists are gone through one by one."""
    centroids = []
    for mask in masks:
        contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_TREE, cv2.CHAIN_APPROX_SIMPLE)
        moments = cv2.moments(max(contours, key=cv2.contourArea))
        centroids.append(np.array([[moments["m10"]], [moments["m01"]]]) / moments["m00"])
    found = cv2.triangulatePoints(*(camera.projection for camera in cameras), *centroids).ravel()
    centroid = found[:3] / found[3]
    heights = np.linspace(-0.1, 0.4, parameters.circumferences)
    radii = np.linspace(0.075, 0.0025, parameters.radii)
    angles = np.radians(np.linspace(0, 359, parameters.points))
    circle = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
    fitted = []
    for height in heights:
        for radius in radii:
            points = circle * radius + (*centroid[:2], height)
            if any(is_inside(camera, mask, points) for camera, mask in zip(cameras, masks, strict=True)):
                fitted.append((height, radius))
                break
    bottom, top = slow_widths([radius for _, radius in fitted], d_max=parameters.max_difference_mm / 1000)
    capacity = sum(np.pi * (h2 - h1) / 3 * (r1**2 + r1 * r2 + r2**2) for (h1, r1), (h2, r2) in pairwise(fitted))
    return 1e6 * capacity, top, bottom, 1000 * (fitted[-1][0] - fitted[0][0])


def is_inside(camera: Camera, mask, points) -> bool:
    rotation = cv2.Rodrigues(camera.rotation)[0]
    pixels = cv2.projectPoints(points, rotation, camera.translation, camera.intrinsic, None)[0][:, 0]
    whole = pixels.astype(int).tolist()  # cuts off towards zero
    return all(mask[min(y, mask.shape[0] - 1), min(x, mask.shape[1] - 1)] for x, y in whole)


def slow_widths(radii, *, d_max):
    """Bottom and top width in mm, None where there is none, of radii in metres."""
    kept, last = [], -1.0
    for radius, following in pairwise(radii):
        if abs(following - radius) < d_max and abs(following - last) >= d_max:
            kept.append(radius)
            last = following
    pairs = [(abs(upper - lower), upper) for lower, upper in pairwise(kept)]
    ends = []
    for direction in (pairs, pairs[::-1]):
        ends.append(None)
        for before, (step, upper) in pairwise(direction):
            if step < before[0]:
                ends[-1] = 2000 * upper
                break
    return ends


def random_masks(rng, *, size=(320, 180), views=("view1", "view2")):
    """A cup's silhouettes, torn and with blots, as no detector would find them."""
    cameras = [tiny_cameras(size)[view] for view in views]
    masks = []
    for camera in cameras:
        mask = silhouette(camera, CUP, BASE_M)
        noise = cv2.blur(rng.random(mask.shape), (7, 7))
        masks.append((mask & (noise > 0.4)) | (cv2.dilate(mask.astype(np.uint8), np.ones((9, 9))) & (noise > 0.55)) > 0)
    return cameras, masks


def test_the_preset_has_the_programs_numbers():
    assert (RELEASED.circumferences, RELEASED.points, RELEASED.radii, RELEASED.fit_rule) == (500, 19, 145, "any")
    assert RELEASED.height_range == ShapeParameters.lode().height_range
    assert RELEASED.pairs == (("view1", "view2"), ("view1", "view3"))


@pytest.mark.parametrize("seed", range(4))
def test_measures_are_those_of_the_slow_version_on_random_masks(seed):
    cameras, masks = random_masks(np.random.default_rng(seed))
    parameters = replace(RELEASED, circumferences=60, radii=49)
    found = measure_hull(fit_hull(cameras, masks, parameters), parameters)
    slow = slow_measures(cameras, masks, parameters)
    values = (found.capacity_ml, found.width_top_mm, found.width_bottom_mm, found.height_mm)
    assert found.capacity_ml > 50
    assert values == tuple(None if value is None else pytest.approx(value, rel=1e-9) for value in slow)


@pytest.mark.parametrize("seed", range(50))
def test_widths_are_those_of_the_slow_version_on_random_profiles(seed):
    rng = np.random.default_rng(seed)
    tried_mm, tried_m = np.linspace(75, 2.5, 145), np.linspace(0.075, 0.0025, 145)
    places = np.clip(70 + np.cumsum(rng.integers(-2, 3, 80)), 0, 144)
    hull = Hull(np.arange(80.0), tried_mm[places], np.ones(80, dtype=bool), np.zeros(3))
    found = measure_hull(hull, RELEASED)
    slow = slow_widths(tried_m[places].tolist(), d_max=0.001)
    assert [getattr(found, name) for name in WIDTHS] == [
        None if width is None else pytest.approx(width, rel=1e-12) for width in slow
    ]


def shifted_px(x):
    return np.array([[1.0, 0, x], [0, 1, 0], [0, 0, 1]])


def hull_of(radii_mm):
    radii = np.array(radii_mm, dtype=float)
    return Hull(np.arange(len(radii)) * 10.0, radii, np.ones(len(radii), dtype=bool), np.zeros(3))


def test_kept_radii_by_hand():
    radii_m = np.array([30, 30.4, 34, 34.5, 35.4, 35.6, 36.0]) / 1000
    # 30: the next, 30.4, is near and nothing was kept; 30.4: 34 is far; 34: 34.5 is near and far from 30.4;
    # 34.5: 35.4 is near, but only 0.9 from 34.5; 35.4: 35.6 is 1.1 from it; 35.6: 36.0 is only 0.4 from it
    assert kept_steps(radii_m, max_difference_m=0.001).tolist() == [0, 2, 4]


def test_ends_by_hand():
    kept_m = np.array([20.0, 26, 30, 31, 33, 36, 42]) / 1000  # steps 6 4 1 2 3 6
    # up: 4 < 6 first, at 26 to 30; down: 3 < 6 first, at 33 to 36
    assert step_ends(kept_m) == (2, 5)
    assert step_ends(np.array([20.0, 26, 30]) / 1000) == (2, None)
    assert step_ends(np.array([20.0, 22, 26]) / 1000) == (None, 1)
    assert step_ends(np.array([20.0, 22]) / 1000) == (None, None)
    assert step_ends(np.array([])) == (None, None)


def test_a_width_fails_by_itself_and_says_why():
    # 30, 32 and 36 are kept, steps 2 and 4: no step going up is smaller than the one before
    found = measure_hull(hull_of([30, 30.1, 32, 32.1, 36, 36.1]), RELEASED)
    assert found.ok
    assert (found.width_bottom_mm, found.width_top_mm) == (None, pytest.approx(64))
    assert (found.height_mm, found.bottom, found.top) == (50, None, 2)
    assert "no step" in found.unmeasured["width_bottom_mm"]
    few = measure_hull(hull_of([30, 30.1, 60, 20]), RELEASED)
    assert (few.width_bottom_mm, few.width_top_mm, few.height_mm) == (None, None, 30)
    assert few.unmeasured == dict.fromkeys(WIDTHS, "1 radii are kept")


def test_height_and_widths_have_their_own_rules():
    hull = hull_of([28, 30, 30.5, 31, 31.2, 31.9, 33])
    plain = measure_hull(hull, ShapeParameters(max_difference_mm=2))
    extent = measure_hull(hull, ShapeParameters(max_difference_mm=2, height_rule="extent"))
    steps = measure_hull(hull, ShapeParameters(max_difference_mm=2, width_rule="steps"))
    assert (plain.height_mm, extent.height_mm, steps.height_mm) == (30, 60, 30)
    assert plain.width_top_mm == extent.width_top_mm != steps.width_top_mm


def test_too_few_circumferences_are_no_fit():
    found = measure_hull(hull_of([30]), RELEASED)
    assert not found.ok
    assert measure_hull(hull_of([30, 30]), RELEASED).capacity_ml == pytest.approx(np.pi * 9)


def test_metres_are_those_that_the_program_tries():
    tried_mm, tried_m = np.linspace(75, 2.5, 145), np.linspace(0.075, 0.0025, 145)
    assert metres_of(tried_mm[::-1], RELEASED).tolist() == tried_m[::-1].tolist()
    assert metres_of(np.array([30.1]), RELEASED).tolist() == [30.1 / 1000]


def test_angles_include_both_ends():
    circle = unit_circle(19, angle_rule="0-359")
    assert circle[0].tolist() == [1, 0]
    assert np.degrees(np.arctan2(circle[-1, 1], circle[-1, 0])) == pytest.approx(-1)
    assert np.degrees(np.arctan2(circle[1, 1], circle[1, 0])) == pytest.approx(359 / 18)


@pytest.mark.parametrize(
    ("pixel", "rounded", "truncated"),
    [
        ((1.6, 1.0), (2, 1), (1, 1)),
        ((-0.4, 0), (0, 0), (0, 0)),
        ((-0.9, 0), None, (0, 0)),
        ((-1.0, 0), None, (4, 0)),
        ((4.7, 2), None, (4, 2)),
        ((90, 2), None, (4, 2)),
        ((1, 50), None, (1, 3)),
        ((-6, 0), None, None),
        ((np.nan, 0), None, None),
    ],
)
def test_pixels_by_hand(pixel, rounded, truncated):
    """On an image 5 pixels wide and 4 high: where a mask of one pixel has to be for the place to fall on it."""
    for rule, expected in (("rounded", rounded), ("truncated", truncated)):
        hits = []
        for y in range(4):
            for x in range(5):
                mask = np.zeros((4, 5), dtype=bool)
                mask[y, x] = True
                if on_mask(mask, np.array([pixel]), pixel_rule=rule)[0]:
                    hits.append((x, y))
        assert hits == ([] if expected is None else [expected])


def test_a_mask_that_is_cut_off_at_the_right_border_still_holds_circumferences():
    size = (320, 180)
    camera = tiny_cameras(size)["view1"]
    middle = np.flatnonzero(silhouette(camera, CUP, BASE_M).any(axis=0)).mean()
    moved = replace(camera, intrinsic=shifted_px(size[0] - 1 - middle) @ camera.intrinsic)
    cameras = [moved, tiny_cameras(size)["view2"]]
    masks = [silhouette(each, CUP, BASE_M) for each in cameras]
    assert masks[0][:, -1].any()
    parameters = replace(RELEASED, circumferences=60, radii=49)
    hull = fit_hull(cameras, masks, parameters)
    plain = fit_hull(cameras, masks, replace(parameters, pixel_rule="rounded"))
    assert hull.converged.any()
    assert not np.array_equal(hull.radii_mm, plain.radii_mm)
    slow = slow_measures(cameras, masks, parameters)
    assert measure_hull(hull, parameters).capacity_ml == pytest.approx(slow[0], rel=1e-9)


def test_a_camera_that_looks_far_past_the_container_is_no_fit():
    camera = tiny_cameras((320, 180))["view1"]
    far = replace(camera, intrinsic=shifted_px(-700) @ camera.intrinsic)
    masks = [np.ones((180, 320), dtype=bool) for _ in range(2)]
    hull = fit_hull([far, tiny_cameras((320, 180))["view2"]], masks, RELEASED)
    assert not hull.ok
    assert is_on(masks[0], 0, 0)


def test_plain_rows_triangulate_as_opencv_does():
    cameras = [tiny_cameras((640, 360))[view] for view in ("view1", "view3")]
    pixels = [camera.project([[0.02, 0.03, 0.1]])[0] + shift for camera, shift in zip(cameras, (3, -4), strict=True)]
    expected = cv2.triangulatePoints(
        cameras[0].projection, cameras[1].projection, pixels[0][:, None], pixels[1][:, None]
    ).ravel()
    plain = triangulate(cameras, pixels, has_unit_rows=False)
    np.testing.assert_allclose(plain, expected[:3] / expected[3], rtol=1e-9)
    assert np.abs(plain - triangulate(cameras, pixels)).max() > 1e-6


def test_the_programs_own_measures_of_a_real_recording(shared_root, real_dataset_root):
    vectors = shared_root / "reference" / "released" / "shape_expected.json"
    recording = open_dataset(real_dataset_root)["000618"]
    detections, _ = file_detections(recording)
    for expected in json.loads(vectors.read_text(encoding="utf-8")):
        choice = {"pair": tuple(expected["pair"]), "frame": expected["frame"], "centre_rule": "none"}
        fit = fit_frame(recording, detections, **choice, shape=RELEASED)
        for name in ("capacity_ml", *WIDTHS, "height_mm"):
            assert getattr(fit.dimensions, name) == pytest.approx(expected[name], rel=1e-6), (choice, name)
        np.testing.assert_allclose(fit.hull.centroid_m, expected["centroid_m"], atol=1e-6)
