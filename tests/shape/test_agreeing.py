"""Three views of which one may contradict the others."""

import cv2
import numpy as np
import pytest

from corsmal.parameters import ShapeParameters
from corsmal.shape import fit_agreeing, fit_hull, measure_hull
from tests.tiny import silhouette, tiny_cameras

SIZE = (1280, 720)
VIEWS = ("view3", "view1", "view2")
CUP = (np.array([0.0, 119.0]), np.array([30.5, 49.0]))
BASE_M = (0.01, -0.02, 0.03)
TUNED = ShapeParameters.tuned()


@pytest.fixture
def cameras():
    return [tiny_cameras(SIZE)[view] for view in VIEWS]


@pytest.fixture
def masks(cameras):
    return [silhouette(camera, CUP, BASE_M) for camera in cameras]


def sizes(hull):
    found = measure_hull(hull, TUNED)
    return [found.width_top_mm, found.width_bottom_mm, found.height_mm]


@pytest.mark.parametrize("wrong", [0, 1, 2])
def test_a_mask_of_the_cup_and_something_beside_it_is_left_out(cameras, masks, wrong):
    x, y, width, height = cv2.boundingRect(masks[wrong].view(np.uint8))
    masks[wrong][y : y + height, x : x + 3 * width] = True
    hull = fit_agreeing(cameras, masks, TUNED)
    assert [weight > 0 for weight in hull.view_weights] == [index != wrong for index in range(3)]
    np.testing.assert_allclose(sizes(hull), [98, 61, 119], atol=4)
    kept = [index for index in range(3) if index != wrong]
    alone = fit_hull([cameras[index] for index in kept], [masks[index] for index in kept], TUNED)
    np.testing.assert_array_equal(hull.radii_mm, alone.radii_mm)


def test_views_that_agree_all_count(cameras, masks):
    hull = fit_agreeing(cameras, masks, TUNED)
    assert hull.view_weights.max() == 1
    assert hull.view_weights.min() > 0
    np.testing.assert_array_equal(hull.radii_mm, fit_hull(cameras, masks, TUNED).radii_mm)


def test_a_view_in_which_a_hand_hides_a_side_is_kept(cameras, masks):
    x, y, width, height = cv2.boundingRect(masks[1].view(np.uint8))
    masks[1][y + height // 3 :, x : x + width // 2] = False
    assert (fit_agreeing(cameras, masks, TUNED).view_weights > 0).all()


def test_a_third_view_of_another_place_leaves_the_pair(cameras, masks):
    masks[2] = silhouette(cameras[2], CUP, (0.3, 0.2, 0.3))
    hull = fit_agreeing(cameras, masks, TUNED)
    assert hull.view_weights[2] == 0
    np.testing.assert_array_equal(hull.radii_mm, fit_hull(cameras[:2], masks[:2], TUNED).radii_mm)


def test_two_views_are_fitted_as_they_are_and_circles_without_weights(cameras, masks):
    pair = fit_agreeing(cameras[:2], masks[:2], TUNED)
    np.testing.assert_array_equal(pair.radii_mm, fit_hull(cameras[:2], masks[:2], TUNED).radii_mm)
    circles = fit_agreeing(cameras, masks, ShapeParameters.paper())
    assert circles.view_weights.shape == (0,)
    np.testing.assert_array_equal(circles.radii_mm, fit_hull(cameras, masks).radii_mm)
