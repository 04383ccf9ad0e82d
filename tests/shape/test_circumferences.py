import cv2
import numpy as np
import pytest

from corsmal.errors import ArgumentError
from corsmal.geometry import Camera
from corsmal.parameters import HeightRange, ShapeParameters
from corsmal.shape import Hull, circumference_points, fit_hull, measure_hull
from corsmal.shape.circumferences import on_mask
from corsmal.shape.cropped import contour_centroid
from tests.tiny import silhouette, tiny_cameras

PIXEL_STEP_AND_AXIS_MM = 2.5
"""Half a pixel, one step of the radii, and how far a silhouette's centroid lies beside the axis."""

BASE_M = (0.01, -0.02, 0.03)
CUP = (np.array([0.0, 119.0]), np.array([30.5, 49.0]))
CYLINDER = (np.array([0.0, 100.0]), np.array([35.0, 35.0]))
CONE = (np.array([0.0, 120.0]), np.array([1e-6, 45.0]))
SPHERE = (50 - 50 * np.cos(np.linspace(0, np.pi, 41)), 50 * np.sin(np.linspace(0, np.pi, 41)))


def two_views(profile, *, size=(640, 360), base_m=BASE_M, views=("view3", "view1")):
    cameras = [tiny_cameras(size)[view] for view in views]
    return cameras, [silhouette(camera, profile, base_m) for camera in cameras]


def slow_radii(cameras: list[Camera], masks, hull: Hull, parameters: ShapeParameters):
    """The fit as one would write it first: OpenCV projects every circumference of every radius."""
    angles = 2 * np.pi * np.arange(parameters.points) / parameters.points
    radii_mm = np.linspace(parameters.radius_max_mm, parameters.radius_min_mm, parameters.radii)
    fitted, converged = [], []
    for height in hull.heights_mm / 1000:
        for radius_mm in radii_mm:
            points = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))]) * radius_mm / 1000
            points += (*hull.centroid_m[:2], height)
            fits = []
            for camera, mask in zip(cameras, masks, strict=True):
                rotation = cv2.Rodrigues(camera.rotation)[0]
                pixels, _ = cv2.projectPoints(points, rotation, camera.translation, camera.intrinsic, None)
                fits.append(all(is_on(mask, *pixel) for pixel in np.rint(pixels[:, 0]).astype(int)))
            if (all if parameters.fit_rule == "all" else any)(fits):
                break
        fitted.append(radius_mm)
        converged.append((all if parameters.fit_rule == "all" else any)(fits))
    return np.array(fitted), np.array(converged)


def is_on(mask, x, y):
    return 0 <= x < mask.shape[1] and 0 <= y < mask.shape[0] and mask[y, x]


@pytest.mark.parametrize("fit_rule", ["any", "all"])
@pytest.mark.parametrize("profile", [CUP, CYLINDER, CONE, SPHERE], ids=["cup", "cylinder", "cone", "sphere"])
def test_radii_are_those_of_the_slow_version(profile, fit_rule):
    cameras, masks = two_views(profile)
    parameters = ShapeParameters(circumferences=25, radii=40, fit_rule=fit_rule)
    hull = fit_hull(cameras, masks, parameters)
    radii, converged = slow_radii(cameras, masks, hull, parameters)
    assert hull.converged.tolist() == converged.tolist()
    assert hull.converged.any()
    np.testing.assert_array_equal(hull.radii_mm, radii)


@pytest.mark.parametrize("fit_rule", ["any", "all"])
def test_radii_are_those_of_the_slow_version_on_a_torn_mask(fit_rule):
    rng = np.random.default_rng(5)
    cameras, masks = two_views(CUP)
    masks = [mask & (cv2.blur(rng.random(mask.shape), (9, 9)) > 0.42) for mask in masks]
    parameters = ShapeParameters(circumferences=20, radii=60, points=7, fit_rule=fit_rule)
    hull = fit_hull(cameras, masks, parameters)
    radii, converged = slow_radii(cameras, masks, hull, parameters)
    assert 0 < converged.sum() < len(converged)
    np.testing.assert_array_equal(hull.radii_mm, radii)


@pytest.mark.parametrize(
    ("profile", "volume_ml"),
    [
        (CYLINDER, np.pi * 35**2 * 100 / 1000),
        (CONE, np.pi * 45**2 * 120 / 3 / 1000),
        (SPHERE, 4 / 3 * np.pi * 50**3 / 1000),
    ],
    ids=["cylinder", "cone", "sphere"],
)
def test_hull_of_true_silhouettes_holds_the_solid_and_little_more(profile, volume_ml):
    cameras, masks = two_views(profile, size=(1280, 720))
    parameters = ShapeParameters(fit_rule="all")
    hull = fit_hull(cameras, masks, parameters)
    true_mm = np.interp(hull.heights_mm - BASE_M[2] * 1000, *profile, left=0, right=0)
    inside = true_mm > parameters.radius_min_mm + 2
    assert (hull.radii_mm[inside] >= true_mm[inside] - PIXEL_STEP_AND_AXIS_MM).all()
    capacity = measure_hull(hull, ShapeParameters(width_rule="widest")).capacity_ml
    assert 0.95 * volume_ml < capacity < 1.3 * volume_ml


def test_centroid_lies_on_the_axis_of_the_solid():
    cameras, masks = two_views(CUP, size=(1280, 720))
    centroid = fit_hull(cameras, masks).centroid_m
    np.testing.assert_allclose(centroid[:2], BASE_M[:2], atol=0.002)
    assert BASE_M[2] < centroid[2] < BASE_M[2] + 0.119


def test_any_view_never_gives_a_smaller_radius_than_all_views():
    cameras, masks = two_views(CUP)
    masks[0][: masks[0].nonzero()[0].mean().astype(int)] = False
    heights = HeightRange("world", 0, 200)
    any_view = fit_hull(cameras, masks, ShapeParameters(height_range=heights))
    all_views = fit_hull(cameras, masks, ShapeParameters(height_range=heights, fit_rule="all"))
    assert (any_view.radii_mm >= all_views.radii_mm).all()
    assert (any_view.radii_mm > all_views.radii_mm).any()


@pytest.mark.parametrize("reference", ["masks", "world", "centroid"])
def test_heights_span_the_asked_range(reference):
    cameras, masks = two_views(CUP, size=(1280, 720))
    hull = fit_hull(cameras, masks, ShapeParameters(height_range=HeightRange(reference, -20, 30), circumferences=11))
    centroid_mm = hull.centroid_m[2] * 1000
    expected = {
        "world": (-20, 30),
        "centroid": (centroid_mm - 20, centroid_mm + 30),
        "masks": (hull.heights_mm[0], hull.heights_mm[-1]),
    }[reference]
    np.testing.assert_allclose(hull.heights_mm, np.linspace(*expected, 11))
    if reference == "masks":
        # the axis is seen from a little below the base's far edge to a little above the rim's near edge
        base_mm = BASE_M[2] * 1000
        assert base_mm - 20 - 40 < hull.heights_mm[0] < base_mm - 20 + 3
        assert base_mm + 119 + 30 - 3 < hull.heights_mm[-1] < base_mm + 119 + 30 + 40


def test_three_views_at_once():
    cameras, masks = two_views(CUP, views=("view1", "view2", "view3"))
    assert fit_hull(cameras, masks, ShapeParameters(fit_rule="all")).converged.any()


def test_a_second_blob_does_not_move_the_axis():
    cameras, masks = two_views(CUP, size=(1280, 720))
    clean = fit_hull(cameras, masks)
    masks[0][5:12, 5:40] = True
    np.testing.assert_allclose(fit_hull(cameras, masks).centroid_m, clean.centroid_m, atol=1e-9)


def test_a_mask_cut_by_the_border_is_fitted_to_what_is_seen():
    cameras, masks = two_views(CUP, base_m=(0.35, 0.3, 0.0))
    assert any(mask[:, 0].any() or mask[:, -1].any() for mask in masks)
    assert fit_hull(cameras, masks).ok


def broken_masks():
    empty = np.zeros((360, 640), dtype=bool)
    pixel, line = empty.copy(), empty.copy()
    pixel[180, 320] = True
    line[180, 300:340] = True
    return {"is empty": empty, "has no area": pixel, "no area": line}


@pytest.mark.parametrize("reason", broken_masks())
def test_a_mask_without_a_contour_is_a_failed_fit(reason):
    cameras, masks = two_views(CUP)
    hull = fit_hull(cameras, [masks[0], broken_masks()[reason]])
    assert not hull.ok
    assert reason in hull.reason
    assert "mask 2 of 2" in hull.reason
    assert not measure_hull(hull).ok
    assert measure_hull(hull).capacity_ml is None


def test_nearly_parallel_rays_are_a_failed_fit():
    camera = tiny_cameras()["view3"]
    beside = Camera(camera.intrinsic, camera.rotation, camera.translation + np.array([0.001, 0, 0]), camera.size)
    masks = [silhouette(view, CUP, BASE_M) for view in (camera, beside)]
    assert "parallel" in fit_hull([camera, beside], masks).reason
    assert "parallel" in fit_hull([camera, camera], [masks[0], masks[0]]).reason


@pytest.mark.parametrize(
    ("reason", "middles"),
    [("behind a camera", ((528, 220), (321, 99))), ("meets no mask", ((395, 189), (351, 318)))],
)
def test_masks_of_different_objects_are_a_failed_fit(reason, middles):
    cameras, _ = two_views(CUP)
    masks = []
    for camera, (x, y) in zip(cameras, middles, strict=True):
        mask = np.zeros(camera.size[::-1], dtype=bool)
        mask[y - 4 : y + 5, x - 4 : x + 5] = True
        masks.append(mask)
    hull = fit_hull(cameras, masks)
    assert reason in hull.reason
    assert not measure_hull(hull).ok


@pytest.mark.parametrize(
    ("cameras", "masks", "message"),
    [
        (1, lambda masks: masks[:1], "two or more cameras"),
        (2, lambda masks: masks[:1], "two or more cameras"),
        (2, lambda masks: [masks[0], masks[1].astype(np.uint8)], "uint8"),
        (2, lambda masks: [masks[0], masks[1][:-1]], "(359, 640)"),
    ],
)
def test_wrong_arguments_are_named(cameras, masks, message):
    all_cameras, all_masks = two_views(CUP)
    with pytest.raises(ArgumentError) as raised:
        fit_hull(all_cameras[:cameras], masks(all_masks))
    assert message in str(raised.value)


def test_circumference_points_lie_at_their_radius_and_height():
    cameras, masks = two_views(CUP)
    hull = fit_hull(cameras, masks, ShapeParameters(circumferences=9))
    points = circumference_points(hull, points=5)
    assert points.shape == (9, 5, 3)
    np.testing.assert_allclose(
        np.hypot(*(points[..., :2] - hull.centroid_m[:2]).T).T * 1000, hull.radii_mm[:, None] + np.zeros(5)
    )
    np.testing.assert_allclose(points[..., 2] * 1000, hull.heights_mm[:, None] + np.zeros(5))
    assert circumference_points(Hull.failed("no"), points=5).shape == (0, 5, 3)


def test_contour_centroid_of_a_rectangle_is_its_middle():
    mask = np.zeros((20, 30), dtype=bool)
    mask[4:11, 5:16] = True
    mask[0:2, 0:2] = True
    np.testing.assert_allclose(contour_centroid(mask), (10, 7))


def test_on_mask_rounds_and_refuses_what_is_outside():
    mask = np.zeros((4, 6), dtype=bool)
    mask[2, 5] = True
    pixels = np.array([[5.4, 1.6], [5.6, 2.0], [4.4, 2.0], [np.nan, 2.0], [5.0, -1.0]])
    assert on_mask(mask, pixels).tolist() == [True, False, False, False, False]


def test_masks_may_be_read_only_and_fill_the_picture():
    cameras = [each for name, each in tiny_cameras((64, 36)).items() if name in ("view3", "view1")]
    whole, part = np.ones((36, 64), dtype=bool), np.zeros((36, 64), dtype=bool)
    part[12:20, 28:36] = True
    whole.flags.writeable = part.flags.writeable = False
    hull = fit_hull(cameras, [whole, part], ShapeParameters.paper())
    assert hull.ok or hull.reason
