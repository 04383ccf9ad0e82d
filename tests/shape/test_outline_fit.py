"""The preset ``tuned`` on solids of which everything is known, and on masks that show too little or too much."""

import itertools

import cv2
import numpy as np
import pytest

from corsmal.geometry import Camera
from corsmal.parameters import ShapeParameters
from corsmal.shape import Hull, fit_hull, measure_hull, silhouettes
from tests.tiny import capacity_ml, silhouette, tiny_cameras

TUNED = ShapeParameters.tuned()
OUTER = ShapeParameters(**{**vars(TUNED), "wall_mm": 0.0})
SIZE = (1280, 720)
VIEWS = ("view3", "view1", "view2")
BASE_M = (0.01, -0.02, 0.03)
CUP = (np.array([0.0, 119.0]), np.array([30.5, 49.0]))
SMALL_CUP = (np.array([0.0, 72.0]), np.array([21.0, 34.5]))
WINE_GLASS = (np.array([0.0, 3, 6, 60, 80, 105, 136]), np.array([33.5, 33.5, 5, 4, 34, 46, 40.5]))
BOX_MM = (135.0, 56.0, 164.0)
PIXEL_MM = 1.5
"""What a pixel spans in the farther views."""


def cameras_of(views=VIEWS):
    return [tiny_cameras(SIZE)[view] for view in views]


def masks_of(profile, cameras):
    return [silhouette(camera, profile, BASE_M) for camera in cameras]


def leaning(profile, *, tilt_deg, about_deg):
    """(rings, 90, 3) points of a solid of revolution that leans, metres, and its axis."""
    tilt, about = np.radians([tilt_deg, about_deg])
    axis = np.array([np.sin(tilt) * np.cos(about), np.sin(tilt) * np.sin(about), np.cos(tilt)])
    first = np.cross([0.0, 1.0, 0.0], axis)
    first /= np.linalg.norm(first)
    angles = np.linspace(0, 2 * np.pi, 90, endpoint=False)
    circle = np.outer(np.cos(angles), first) + np.outer(np.sin(angles), np.cross(axis, first))
    heights, radii = (np.asarray(values) / 1000 for values in profile)
    return np.array(BASE_M) + heights[:, None, None] * axis + radii[:, None, None] * circle, axis


def box_corners(sizes_mm, *, yaw_deg):
    width, depth, height = np.array(sizes_mm) / 1000
    turn = np.radians(yaw_deg)
    corners = np.array(list(itertools.product((-width / 2, width / 2), (-depth / 2, depth / 2), (0, height))))
    x = np.cos(turn) * corners[:, 0] - np.sin(turn) * corners[:, 1]
    y = np.sin(turn) * corners[:, 0] + np.cos(turn) * corners[:, 1]
    return np.array(BASE_M) + np.column_stack([x, y, corners[:, 2]])


def painted(camera, pieces):
    """The pixels of convex pieces, each given by its points."""
    mask = np.zeros(camera.size[::-1], np.uint8)
    for points in pieces:
        hull = cv2.convexHull(camera.project(points).astype(np.float32))
        cv2.fillConvexPoly(mask, np.rint(hull * 16).astype(np.int32), 1, shift=4)
    return mask.astype(bool)


def measured(hull, parameters=OUTER):
    dimensions = measure_hull(hull, parameters)
    assert dimensions.ok, dimensions.reason
    return np.array([dimensions.width_top_mm, dimensions.width_bottom_mm, dimensions.height_mm])


@pytest.mark.parametrize("views", [VIEWS, VIEWS[:2], ("view3", "view2")], ids=["three", "left", "right"])
@pytest.mark.parametrize("profile", [CUP, SMALL_CUP, WINE_GLASS], ids=["cup", "small cup", "wine glass"])
def test_sizes_are_those_of_the_solid_within_two_pixels(profile, views):
    cameras = cameras_of(views)
    hull = fit_hull(cameras, masks_of(profile, cameras), OUTER)
    truth = np.array([2 * profile[1][-1], 2 * profile[1][0], profile[0][-1]])
    np.testing.assert_allclose(measured(hull), truth, atol=2 * PIXEL_MM)
    assert measure_hull(hull, OUTER).capacity_ml == pytest.approx(capacity_ml(profile), rel=0.1)
    assert hull.depth_mm is None
    assert hull.overlap > 0.9


def test_the_papers_hull_is_farther_from_the_cup():
    cameras = cameras_of(VIEWS[:2])
    masks = masks_of(CUP, cameras)
    truth = np.array([98.0, 61.0, 119.0])
    paper = measured(fit_hull(cameras, masks), ShapeParameters.paper())
    assert np.abs(measured(fit_hull(cameras, masks, OUTER)) - truth).mean() < np.abs(paper - truth).mean() / 4


@pytest.mark.parametrize("smaller", VIEWS)
@pytest.mark.parametrize("profile", [CUP, SMALL_CUP], ids=["cup", "small cup"])
def test_a_view_whose_mask_is_too_small_is_outvoted(profile, smaller):
    cameras = cameras_of()
    masks = masks_of(profile, cameras)
    index = VIEWS.index(smaller)
    masks[index] = cv2.erode(masks[index].view(np.uint8), np.ones((9, 9), np.uint8)).astype(bool)
    heights, radii = profile
    truth = [2 * radii[-1], 2 * radii[0], heights[-1]]
    np.testing.assert_allclose(measured(fit_hull(cameras, masks, OUTER)), truth, atol=1.25 * PIXEL_MM)


@pytest.mark.parametrize("share", [0.25, 0.35, 0.45])
@pytest.mark.parametrize("views", [VIEWS, VIEWS[:2]], ids=["three", "two"])
def test_a_hand_that_hides_one_side_of_all_views_and_leaves_tongues_bends_nothing(views, share):
    cameras = cameras_of(views)
    masks = masks_of(CUP, cameras)
    for mask in masks:
        x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
        mask[y + int(0.45 * height) : y + int(0.92 * height), x : x + int(share * width)] = False
        for finger in range(3):
            row = y + int((0.5 + 0.13 * finger) * height)
            mask[row : row + int(0.04 * height), x - int(0.1 * width) : x + int(share * width)] = True
    np.testing.assert_allclose(measured(fit_hull(cameras, masks, OUTER)), [98, 61, 119], atol=PIXEL_MM)


@pytest.mark.parametrize(("tilt_deg", "about_deg"), [(6, 0), (6, 90), (10, 200)])
def test_a_leaning_cup_is_measured_along_its_axis(tilt_deg, about_deg):
    cameras = cameras_of()
    rings, axis = leaning(CUP, tilt_deg=tilt_deg, about_deg=about_deg)
    masks = [painted(camera, [rings.reshape(-1, 3)]) for camera in cameras]
    hull = fit_hull(cameras, masks, OUTER)
    assert np.degrees(np.arccos(hull.direction @ axis)) < 3
    np.testing.assert_allclose(measured(hull), [98, 61, 119], atol=2.5 * PIXEL_MM)
    upright = fit_hull(cameras, masks, ShapeParameters(**{**vars(OUTER), "tilt_deg": 0.0}))
    assert upright.direction.tolist() == [0, 0, 1]


@pytest.mark.parametrize("yaw_deg", [-25, 0, 12, 40])
def test_a_box_is_told_from_a_solid_of_revolution_and_measured(yaw_deg):
    cameras = cameras_of()
    masks = [painted(camera, [box_corners(BOX_MM, yaw_deg=yaw_deg)]) for camera in cameras]
    hull = fit_hull(cameras, masks, TUNED)
    assert hull.depth_mm == pytest.approx(56, abs=2 * PIXEL_MM)
    np.testing.assert_allclose(measured(hull), [135, 135, 164], atol=2 * PIXEL_MM)
    assert np.degrees(hull.yaw) == pytest.approx(yaw_deg, abs=4)
    assert measure_hull(hull, TUNED).capacity_ml == pytest.approx(np.prod(BOX_MM) / 1000, rel=0.08)
    assert fit_hull(cameras, masks, ShapeParameters(**{**vars(TUNED), "boxes": False})).depth_mm is None


def test_a_hand_on_one_side_takes_little_from_the_cup():
    cameras = cameras_of()
    masks = masks_of(CUP, cameras)
    for mask in masks:
        x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
        mask[y + height // 3 : y + 3 * height // 4, x : x + width // 2] = False
    np.testing.assert_allclose(measured(fit_hull(cameras, masks, OUTER)), [98, 61, 119], atol=3 * PIXEL_MM)


def test_the_silhouettes_of_a_fit_are_the_masks():
    cameras = cameras_of()
    masks = masks_of(CUP, cameras)
    for seen, mask in zip(silhouettes(fit_hull(cameras, masks, OUTER), cameras), masks, strict=True):
        assert (seen & mask).sum() / (seen | mask).sum() > 0.95


def test_a_hull_painted_by_hand_is_the_projected_solid():
    heights = np.linspace(0, 119, 30)
    hull = Hull(heights + 30, np.interp(heights, *CUP), np.ones(30, dtype=bool), np.array(BASE_M))
    for seen, mask in zip(silhouettes(hull, cameras_of()), masks_of(CUP, cameras_of()), strict=True):
        assert (seen ^ mask).sum() < 0.04 * mask.sum()


def test_a_container_cut_by_the_border_is_measured_where_the_other_view_shows_it():
    cameras = cameras_of(VIEWS[:2])
    near, far = cameras
    lower = np.array([[0, 0, 0], [0, 0, 335], [0, 0, 0]])
    shifted = type(near)(near.intrinsic + lower, near.rotation, near.translation, SIZE)
    masks = masks_of(CUP, [shifted, far])
    assert masks[0][-1].any()
    hull = fit_hull([shifted, far], masks, OUTER)
    np.testing.assert_allclose(measured(hull)[[0, 2]], [98, 119], rtol=0.1)


def test_masks_of_different_objects_are_explained_by_no_solid():
    cameras = cameras_of(VIEWS[:2])
    elsewhere = (BASE_M[0] + 0.25, BASE_M[1], BASE_M[2] + 0.3)
    masks = [silhouette(cameras[0], CUP, BASE_M), silhouette(cameras[1], WINE_GLASS, elsewhere)]
    hull = fit_hull(cameras, masks, TUNED)
    assert not hull.ok
    assert "different objects" in hull.reason
    assert measure_hull(hull, TUNED).reason == hull.reason


@pytest.mark.parametrize("rows", [slice(0, 6), slice(-6, None)], ids=["rim", "base"])
def test_a_mask_of_a_rim_or_a_base_alone_fails_and_says_so(rows):
    cameras = cameras_of(VIEWS[:2])
    masks = masks_of(CUP, cameras)
    for mask in masks:
        x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
        kept = mask[y : y + height, x : x + width][rows].copy()
        mask[:] = False
        mask[y : y + height, x : x + width][rows] = kept
    hull = fit_hull(cameras, masks, TUNED)
    assert not hull.ok
    assert hull.reason


def test_specks_beside_the_container_change_nothing():
    cameras = cameras_of(VIEWS[:2])
    masks = masks_of(CUP, cameras)
    clean = measured(fit_hull(cameras, masks, OUTER))
    for mask in masks:
        mask[10:20, 10:20] = True
    np.testing.assert_allclose(measured(fit_hull(cameras, masks, OUTER)), clean, atol=0.5)


def test_a_hand_over_more_than_half_leaves_a_cup_or_a_reason():
    cameras = cameras_of()
    masks = masks_of(CUP, cameras)
    for mask in masks:
        x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
        mask[y + height // 4 : y + 4 * height // 5, x : x + 4 * width // 5] = False
    hull = fit_hull(cameras, masks, OUTER)
    assert hull.overlap < 0.7
    np.testing.assert_allclose(measured(hull), [98, 61, 119], rtol=0.15)


def test_a_camera_straight_above_shows_no_outline():
    down = np.diag([1.0, -1.0, -1.0])
    above = Camera([[900, 0, 640], [0, 900, 360], [0, 0, 1]], down, -down @ [*BASE_M[:2], 1.0], SIZE)
    cameras = [tiny_cameras(SIZE)["view3"], above]
    hull = fit_hull(cameras, masks_of(CUP, cameras), TUNED)
    assert hull.reason == "a camera looks along the container's axis"


def test_any_blot_gives_a_hull_or_a_reason():
    rng = np.random.default_rng(5)
    cameras = cameras_of()
    for _ in range(20):
        masks = [np.zeros(SIZE[::-1], dtype=bool) for _ in cameras]
        for mask in masks:
            for _ in range(rng.integers(1, 4)):
                x, y, width, height = rng.integers(0, 1200), rng.integers(0, 700), *rng.integers(1, 400, 2)
                mask[y : y + height, x : x + width] = True
        hull = fit_hull(cameras, masks, TUNED)
        assert hull.ok != bool(hull.reason)
        assert np.isfinite(hull.radii_mm).all()
