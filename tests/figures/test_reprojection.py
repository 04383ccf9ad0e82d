import base64

import cv2
import numpy as np
import pytest

from corsmal.figures import reprojection_figure
from corsmal.parameters import ShapeParameters
from corsmal.shape import Hull, fit_hull
from tests.tiny import silhouette, tiny_cameras

PARAMETERS = ShapeParameters(circumferences=25)
POINTS = PARAMETERS.points
BASE_M = (0.01, -0.02, 0.03)
CUP = (np.array([0.0, 119.0]), np.array([30.5, 49.0]))


@pytest.fixture(scope="module")
def fitted():
    """The camera, the mask and a grey picture of view1, and the hull of views 3 and 1."""
    cameras = [tiny_cameras()[view] for view in ("view3", "view1")]
    masks = [silhouette(camera, CUP, BASE_M) for camera in cameras]
    hull = fit_hull(cameras, masks, PARAMETERS)
    return cameras[1], masks[1], np.full((*masks[1].shape, 3), 128, dtype=np.uint8), hull


def slow_points(camera, mask, hull):
    """Every point's pixel, radius and height, on the mask and off it, one after the other."""
    groups = {True: [], False: []}
    for height, radius, converged in zip(hull.heights_mm, hull.radii_mm, hull.converged, strict=True):
        for number in range(POINTS if converged else 0):
            angle = 2 * np.pi * number / POINTS
            x = hull.centroid_m[0] + radius / 1000 * np.cos(angle)
            y = hull.centroid_m[1] + radius / 1000 * np.sin(angle)
            u, v, w = camera.projection @ [x, y, height / 1000, 1]
            column, row = round(u / w), round(v / w)
            inside = 0 <= column < mask.shape[1] and 0 <= row < mask.shape[0] and bool(mask[row, column])
            groups[inside].append((u / w, v / w, radius, height))
    return {inside: np.array(rows).reshape(-1, 4) for inside, rows in groups.items()}


def test_points_on_and_off_the_mask_are_those_of_a_slow_loop(fitted):
    camera, mask, image, hull = fitted
    on_it, off_it = reprojection_figure(image, mask, camera, hull, parameters=PARAMETERS).data
    expected = slow_points(camera, mask, hull)
    assert len(expected[True]) > 0
    assert len(expected[False]) > 0
    assert len(expected[True]) + len(expected[False]) == POINTS * hull.converged.sum()
    for trace, rows in ((on_it, expected[True]), (off_it, expected[False])):
        np.testing.assert_allclose(np.column_stack([trace.x, trace.y]), rows[:, :2], atol=1e-3)
        np.testing.assert_allclose(trace.customdata, rows[:, 2:], rtol=1e-6)
    assert on_it.name == f"on the mask: {len(expected[True]):,}"
    assert off_it.name == f"off the mask: {len(expected[False]):,}"


def test_the_picture_is_the_crop_around_the_mask_at_its_place(fitted):
    camera, mask, image, hull = fitted
    layout = reprojection_figure(image, mask, camera, hull, parameters=PARAMETERS).layout
    [picture] = layout.images
    left, top = picture.x + 0.5, picture.y + 0.5
    rows, columns = np.nonzero(mask)
    assert left <= columns.min()
    assert left + picture.sizex > columns.max()
    assert top <= rows.min()
    assert top + picture.sizey > rows.max()
    content = base64.b64decode(picture.source.removeprefix("data:image/jpeg;base64,"))
    decoded = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR_RGB)
    assert decoded.shape == (picture.sizey, picture.sizex, 3)
    # the mask is tinted, the rest is as it was: where the crop lies in the picture is right
    cut = mask[int(top) : int(top + picture.sizey), int(left) : int(left + picture.sizex)]
    is_tinted = decoded[..., 1].astype(int) - decoded[..., 0] > 15
    assert (is_tinted == cut).mean() > 0.98
    assert layout.xaxis.range == (left - 0.5, left + picture.sizex - 0.5)
    assert layout.yaxis.range == (top + picture.sizey - 0.5, top - 0.5)
    assert layout.yaxis.scaleanchor == "x"


def test_the_picture_that_was_given_is_not_painted_on(fitted):
    camera, mask, image, hull = fitted
    reprojection_figure(image, mask, camera, hull, parameters=PARAMETERS)
    assert (image == 128).all()


def test_a_mask_at_the_border_is_cropped_to_the_image(fitted):
    camera, _, image, hull = fitted
    mask = np.zeros(image.shape[:2], dtype=bool)
    mask[-5:, :7] = True
    [picture] = reprojection_figure(image, mask, camera, hull, parameters=PARAMETERS).layout.images
    assert (picture.x, picture.y + picture.sizey) == (-0.5, image.shape[0] - 0.5)


def test_an_empty_mask_shows_the_whole_picture_and_no_point_inside(fitted):
    camera, mask, image, hull = fitted
    figure = reprojection_figure(image, np.zeros_like(mask), camera, hull, parameters=PARAMETERS)
    assert figure.data[0].name == "on the mask: 0"
    assert (figure.layout.images[0].sizex, figure.layout.images[0].sizey) == (640, 360)


def test_a_failed_hull_has_no_points(fitted):
    camera, mask, image, _ = fitted
    figure = reprojection_figure(image, mask, camera, Hull.failed("no"), parameters=PARAMETERS)
    assert [len(trace.x) for trace in figure.data] == [0, 0]


def test_points_behind_the_camera_are_off_the_mask(fitted):
    camera, mask, image, _ = fitted
    behind = Hull(np.array([camera.centre_m[2] * 1000]), np.array([2.5]), np.array([True]), 2 * camera.centre_m)
    on_it, off_it = reprojection_figure(image, mask, camera, behind, parameters=PARAMETERS).data
    assert (len(on_it.x), len(off_it.x)) == (0, POINTS)
    assert np.isnan(off_it.x).all()
