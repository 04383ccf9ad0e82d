import json
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest

from corsmal.figures import hull_figure
from corsmal.figures.hull import FRUSTUM_DEPTH_MM, MARGIN_MM
from corsmal.geometry import Camera
from corsmal.shape import Dimensions, Hull
from tests.figures.made import CENTROID_M, CONVERGED, HEIGHTS_MM, RADII_MM, made_dimensions, made_hull, traces
from tests.tiny import tiny_cameras

CAMERAS = tiny_cameras()


def points_of(trace):
    return np.column_stack([trace.x, trace.y, trace.z]).astype(float)


def pieces_of(trace):
    """A line's pieces between its gaps, (n, 3) each."""
    points = points_of(trace)
    is_gap = np.isnan(points[:, 0])
    pieces = [piece[~np.isnan(piece[:, 0])] for piece in np.split(points, np.flatnonzero(is_gap))]
    return [piece for piece in pieces if len(piece)]


def from_axis(points_mm):
    return np.hypot(*(points_mm[:, :2] - CENTROID_M[:2] * 1000).T)


def test_circumferences_are_closed_rings_at_their_radius_and_height():
    found = traces(hull_figure(made_hull(), made_dimensions(), cameras=CAMERAS))
    groups = {"circumferences": [3, 6], "rejected by d_max": [1, 5], "lower and upper end": [2, 4]}
    for name, indices in groups.items():
        rings = pieces_of(found[name])
        assert len(rings) == len(indices), name
        for ring, index in zip(rings, indices, strict=True):
            np.testing.assert_array_equal(ring[0], ring[-1])
            np.testing.assert_allclose(from_axis(ring), RADII_MM[index], atol=1e-3)
            np.testing.assert_allclose(ring[:, 2], HEIGHTS_MM[index], atol=1e-3)
    assert found["lower and upper end"].line.width > found["circumferences"].line.width


def test_surface_is_closed_and_goes_through_the_converged_circumferences():
    surface = traces(hull_figure(made_hull(), made_dimensions(), cameras={}))["hull"]
    vertices, radii = points_of(surface), dict(zip(HEIGHTS_MM[CONVERGED], RADII_MM[CONVERGED], strict=True))
    distances = from_axis(vertices)
    on_a_wall = distances > 1
    assert (~on_a_wall).sum() == 2
    np.testing.assert_allclose(distances[on_a_wall], [radii[z] for z in vertices[on_a_wall, 2]], atol=1e-3)
    assert set(vertices[:, 2]) == set(radii)
    triangles = zip(surface.i, surface.j, surface.k, strict=True)
    edges = Counter(tuple(sorted(edge)) for a, b, c in triangles for edge in ((a, b), (b, c), (c, a)))
    assert set(edges.values()) == {2}


@pytest.mark.parametrize("view", CAMERAS)
def test_a_cameras_frustum_is_to_scale(view):
    camera = CAMERAS[view]
    [frustum, ray] = pieces_of(traces(hull_figure(made_hull(), made_dimensions(), cameras=CAMERAS))[view])
    np.testing.assert_allclose(frustum[0], camera.centre_m * 1000, atol=1e-3)
    is_centre = np.abs(frustum - frustum[0]).max(axis=1) < 1e-3
    corners = np.unique(frustum[~is_centre], axis=0)
    width, height = camera.size
    expected = [(-0.5, -0.5), (-0.5, height - 0.5), (width - 0.5, -0.5), (width - 0.5, height - 0.5)]
    pixels = camera.project(corners / 1000)
    assert sorted(map(tuple, np.round(pixels, 1).tolist())) == expected
    depths = (corners / 1000 @ camera.rotation.T + camera.translation)[:, 2]
    np.testing.assert_allclose(depths * 1000, FRUSTUM_DEPTH_MM, atol=1e-2)
    edges = {frozenset((tuple(a), tuple(b))) for a, b in pairwise(frustum)}
    assert len(edges) == 8
    np.testing.assert_allclose(ray, [camera.centre_m * 1000, CENTROID_M * 1000], atol=1e-3)


def test_a_failed_hull_leaves_the_cameras_alone():
    failed = Hull.failed("mask 1 of 2 is empty")
    figure = hull_figure(failed, Dimensions(reason=failed.reason), cameras=CAMERAS)
    assert [trace.name for trace in figure.data] == list(CAMERAS)
    for trace in figure.data:
        assert len(pieces_of(trace)) == 1
    assert figure.layout.scene.aspectmode == "data"


def test_a_hull_none_of_whose_circumferences_fits_is_drawn_as_nothing():
    hull = Hull(HEIGHTS_MM, RADII_MM, np.zeros(7, dtype=bool), CENTROID_M)
    found = traces(hull_figure(hull, Dimensions(reason="only 0 of 7 circumferences fit"), cameras=CAMERAS))
    assert set(found) == {"hull", *CAMERAS}
    assert len(found["hull"].x) == 0


def test_the_container_is_framed_to_scale():
    scene = hull_figure(made_hull(), made_dimensions(), cameras=CAMERAS).layout.scene
    spans = [axis.range[1] - axis.range[0] for axis in (scene.xaxis, scene.yaxis, scene.zaxis)]
    assert spans == [2 * (60 + MARGIN_MM), 2 * (60 + MARGIN_MM), 50 + MARGIN_MM]
    assert np.mean(scene.xaxis.range) == pytest.approx(20)
    assert np.mean(scene.yaxis.range) == pytest.approx(-30)
    assert np.mean(scene.zaxis.range) == pytest.approx(65)
    shares = (scene.aspectratio.x, scene.aspectratio.y, scene.aspectratio.z)
    assert len({round(span / share, 6) for span, share in zip(spans, shares, strict=True)}) == 1
    everything = hull_figure(made_hull(), made_dimensions(), cameras=CAMERAS, scope="cameras").layout.scene
    assert everything.aspectmode == "data"
    assert everything.xaxis.range is None


def test_one_looks_from_the_side_of_the_first_camera():
    eye = hull_figure(made_hull(), made_dimensions(), cameras=CAMERAS).layout.scene.camera.eye
    away = CAMERAS["view1"].centre_m - CENTROID_M
    assert np.arctan2(eye.y, eye.x) == pytest.approx(np.arctan2(away[1], away[0]))
    assert np.hypot(eye.x, eye.y) == pytest.approx(1.7)


def test_a_camera_straight_above_the_container_is_no_division_by_zero():
    down = np.diag([1.0, -1.0, -1.0])
    above = Camera([[900, 0, 640], [0, 900, 360], [0, 0, 1]], down, -down @ [*CENTROID_M[:2], 1.0], (1280, 720))
    figure = hull_figure(made_hull(), made_dimensions(), cameras={"view3": above})
    assert "NaN" not in json.dumps(figure.layout.to_plotly_json())


def test_another_hull_is_drawn_over_the_fitted_one():
    other = Hull(HEIGHTS_MM, RADII_MM + 5, CONVERGED, CENTROID_M)
    found = traces(hull_figure(made_hull(), made_dimensions(), cameras={}, beside=("tuned", other)))
    radii = from_axis(points_of(found["tuned"]))
    assert radii.max() == pytest.approx(65, abs=1e-3)
    assert found["tuned"].color != found["hull"].color
    failed = ("tuned", Hull.failed("no"))
    assert "tuned" not in traces(hull_figure(made_hull(), made_dimensions(), cameras={}, beside=failed))
