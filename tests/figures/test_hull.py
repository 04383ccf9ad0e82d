import json
import re
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest

from corsmal.figures import hull_figure
from corsmal.figures.hull import SIDES
from corsmal.figures.hull_scene import FRUSTUM_DEPTH_MM, GRID_MM, MARGIN_MM, TABLE_NEAR_MM
from corsmal.figures.style import PRESET_COLOURS
from corsmal.geometry import Camera
from corsmal.shape import Dimensions, Hull, KnownProfile
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


def test_every_identity_of_a_trace_is_a_class_name_as_plotly_looks_for_it():
    figure = hull_figure(made_hull(), made_dimensions(), cameras=CAMERAS)
    identities = [trace.uid for trace in figure.data]
    assert all(re.fullmatch(r"[\w-]+", identity) for identity in identities)
    assert len(set(identities)) == len(identities)


def test_surface_is_closed_and_goes_through_the_converged_circumferences():
    surface = traces(hull_figure(made_hull(), made_dimensions(), cameras={}))["paper"]
    vertices, radii = points_of(surface), dict(zip(HEIGHTS_MM[CONVERGED], RADII_MM[CONVERGED], strict=True))
    distances = from_axis(vertices)
    on_a_wall = distances > 1
    assert (~on_a_wall).sum() == 2
    np.testing.assert_allclose(distances[on_a_wall], [radii[z] for z in vertices[on_a_wall, 2]], atol=1e-3)
    assert set(vertices[:, 2]) == set(radii)
    _, place = np.unique(np.round(vertices, 3), axis=0, return_inverse=True)  # the caps have corners of their own
    triangles = place[np.column_stack([surface.i, surface.j, surface.k])].tolist()
    edges = Counter(tuple(sorted(edge)) for a, b, c in triangles for edge in ((a, b), (b, c), (c, a)))
    assert set(edges.values()) == {2}


def test_no_corner_of_a_cap_is_one_of_the_wall():
    surface = traces(hull_figure(made_hull(), made_dimensions(), cameras={}))["paper"]
    vertices, triangles = points_of(surface), np.column_stack([surface.i, surface.j, surface.k])
    is_flat = np.ptp(vertices[triangles, 2], axis=1) == 0
    assert is_flat.sum() > 2
    assert not set(triangles[is_flat].ravel()) & set(triangles[~is_flat].ravel())


def test_the_surface_is_opaque_and_lit_from_the_side_that_is_seen():
    figure = hull_figure(made_hull(), made_dimensions(), cameras=CAMERAS)
    surface, eye = traces(figure)["paper"], figure.layout.scene.camera.eye
    assert surface.opacity is None
    light = surface.lightposition
    assert light.x * eye.x + light.y * eye.y > 0
    assert light.z > 0


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


def test_a_failed_hull_leaves_the_table_and_the_cameras():
    failed = Hull.failed("mask 1 of 2 is empty")
    found = traces(hull_figure(failed, Dimensions(reason=failed.reason), cameras=CAMERAS))
    assert set(found) == {"table", f"table, grid of {GRID_MM:.0f} mm", *CAMERAS}
    for view in CAMERAS:
        assert len(pieces_of(found[view])) == 1


def test_a_hull_none_of_whose_circumferences_fits_is_drawn_as_nothing():
    hull = Hull(HEIGHTS_MM, RADII_MM, np.zeros(7, dtype=bool), CENTROID_M)
    found = traces(hull_figure(hull, Dimensions(reason="only 0 of 7 circumferences fit"), cameras=CAMERAS))
    assert set(found) == {"paper", "table", f"table, grid of {GRID_MM:.0f} mm", *CAMERAS}
    assert len(found["paper"].x) == 0


def spans_of(scene):
    return [axis.range[1] - axis.range[0] for axis in (scene.xaxis, scene.yaxis, scene.zaxis)]


@pytest.mark.parametrize("scope", ["container", "cameras"])
def test_the_scene_is_to_scale_without_axes_until_they_are_wanted(scope):
    for has_axes in (False, True):
        figure = hull_figure(made_hull(), made_dimensions(), cameras=CAMERAS, scope=scope, has_axes=has_axes)
        scene = figure.layout.scene
        assert {axis.visible for axis in (scene.xaxis, scene.yaxis, scene.zaxis)} == {has_axes}
        shares = (scene.aspectratio.x, scene.aspectratio.y, scene.aspectratio.z)
        assert len({round(span / share, 6) for span, share in zip(spans_of(scene), shares, strict=True)}) == 1


def test_the_container_is_framed_with_a_margin_and_the_table():
    scene = hull_figure(made_hull(), made_dimensions(), cameras=CAMERAS).layout.scene
    assert spans_of(scene)[:2] == pytest.approx([2 * (60 + MARGIN_MM)] * 2)
    assert np.mean(scene.xaxis.range) == pytest.approx(20)
    assert np.mean(scene.yaxis.range) == pytest.approx(-30)
    assert scene.zaxis.range == pytest.approx((-1, 90 + MARGIN_MM / 2))


@pytest.mark.parametrize("name", ["start", "front", "side", "top"])
def test_the_container_fills_the_frame_of_each_view_and_is_inside_it(name):
    """Projected by hand as Plotly does: 45 degrees from the lower to the upper edge of a square figure."""
    figure = hull_figure(made_hull(), made_dimensions(), cameras=CAMERAS)
    scene = figure.layout.scene
    [menu] = figure.layout.updatemenus
    cameras = {button.label.lower(): button.args[0]["scene.camera"] for button in menu.buttons}
    camera = scene.camera.to_plotly_json() if name == "start" else cameras[name]
    middle = np.array([np.mean(axis.range) for axis in (scene.xaxis, scene.yaxis, scene.zaxis)])
    points = (points_of(traces(figure)["paper"]) - middle) * (scene.aspectratio.x / spans_of(scene)[0])
    eye, centre, up = (np.array([camera[part][axis] for axis in "xyz"]) for part in ("eye", "center", "up"))
    forward = (centre - eye) / np.linalg.norm(centre - eye)
    right = np.cross(forward, up) / np.linalg.norm(np.cross(forward, up))
    depths = (points - eye) @ forward
    across, along = (np.abs((points - eye) @ axis / depths) for axis in (right, np.cross(right, forward)))
    largest = max(across.max(), along.max()) / np.tan(np.deg2rad(22.5))
    assert 0.7 < largest < 1.0


def test_the_views_are_from_the_frontal_camera_its_side_and_above():
    [menu] = hull_figure(made_hull(), made_dimensions(), cameras=CAMERAS).layout.updatemenus
    directions = {}
    for button in menu.buttons:
        camera = button.args[0]["scene.camera"]
        offset = np.array([camera["eye"][axis] - camera["center"][axis] for axis in "xyz"])
        directions[button.label] = offset / np.linalg.norm(offset)
    away = (CAMERAS["view3"].centre_m - CENTROID_M)[:2]
    np.testing.assert_allclose(directions["Front"], [*away / np.linalg.norm(away), 0], atol=1e-9)
    assert directions["Side"] @ directions["Front"] == pytest.approx(0)
    assert directions["Side"][2] == 0
    assert directions["Top"][2] > 0.99


def test_a_table_that_is_far_below_is_left_out_of_the_containers_frame():
    for height_mm, is_shown in ((TABLE_NEAR_MM - 45, True), (TABLE_NEAR_MM - 35, False)):
        raised = Hull(HEIGHTS_MM + height_mm, RADII_MM, CONVERGED, CENTROID_M + np.array([0, 0, height_mm / 1000]))
        assert ("table" in traces(hull_figure(raised, made_dimensions(), cameras=CAMERAS))) == is_shown
        assert "table" in traces(hull_figure(raised, made_dimensions(), cameras=CAMERAS, scope="cameras"))


def test_the_table_is_the_plane_of_height_zero_with_a_grid():
    found = traces(hull_figure(made_hull(), made_dimensions(), cameras=CAMERAS))
    assert set(points_of(found["table"])[:, 2]) == {0}
    grid = pieces_of(found[f"table, grid of {GRID_MM:.0f} mm"])
    places = [piece[0, 0] for piece in grid if piece[0, 0] == piece[1, 0]]
    assert places == [-50, 0, 50, 100]


@pytest.mark.parametrize("scope", ["container", "cameras"])
def test_every_camera_has_its_name_on_its_ray_within_the_frame(scope):
    figure = hull_figure(made_hull(), made_dimensions(), cameras=CAMERAS, scope=scope)
    scene = figure.layout.scene
    low, high = np.array([axis.range for axis in (scene.xaxis, scene.yaxis, scene.zaxis)]).T
    assert len(scene.annotations) == len(CAMERAS)
    for view, name in zip(CAMERAS, scene.annotations, strict=True):
        assert name.text.endswith(view)
        place = np.array([name.x, name.y, name.z])
        ray = CAMERAS[view].centre_m * 1000 - CENTROID_M * 1000
        assert np.linalg.norm(np.cross(place - CENTROID_M * 1000, ray)) / np.linalg.norm(ray) < 1e-6
        assert (low - 1e-6 <= place).all()
        assert (place <= high + 1e-6).all()
        if scope == "cameras":
            np.testing.assert_allclose(place, CAMERAS[view].centre_m * 1000)


def test_a_camera_straight_above_the_container_is_no_division_by_zero():
    down = np.diag([1.0, -1.0, -1.0])
    above = Camera([[900, 0, 640], [0, 900, 360], [0, 0, 1]], down, -down @ [*CENTROID_M[:2], 1.0], (1280, 720))
    figure = hull_figure(made_hull(), made_dimensions(), cameras={"view3": above})
    assert "NaN" not in json.dumps(figure.layout.to_plotly_json())


def test_another_hull_is_drawn_over_the_fitted_one_as_lines_in_its_presets_colour():
    other = Hull(HEIGHTS_MM, RADII_MM + 5, CONVERGED, CENTROID_M)
    found = traces(hull_figure(made_hull(), made_dimensions(), cameras={}, preset="lode", beside=("tuned", other)))
    assert found["lode"].color == PRESET_COLOURS["lode"]
    assert found["tuned"].line.color == PRESET_COLOURS["tuned"]
    pieces = pieces_of(found["tuned"])
    rings = [piece for piece in pieces if np.ptp(piece[:, 2]) < 1e-6]
    assert [from_axis(ring)[0] for ring in rings] == pytest.approx(RADII_MM[CONVERGED] + 5, abs=1e-3)
    along = [piece for piece in pieces if np.ptp(piece[:, 2]) > 1e-6]
    assert len(along) == SIDES // 4
    for piece in along:
        np.testing.assert_allclose(from_axis(piece), RADII_MM[CONVERGED] + 5, atol=1e-3)
    failed = ("tuned", Hull.failed("no"))
    assert "tuned" not in traces(hull_figure(made_hull(), made_dimensions(), cameras={}, beside=failed))


def test_the_surface_is_coloured_by_its_distance_from_a_known_profile():
    known = KnownProfile([0, 60], [41, 41], "true profile", base_mm=40)
    surface = traces(hull_figure(made_hull(), made_dimensions(), cameras={}, known=known))["paper"]
    errors = dict(zip(HEIGHTS_MM[CONVERGED], RADII_MM[CONVERGED] - 41, strict=True))
    np.testing.assert_allclose(surface.intensity, [errors[z] for z in points_of(surface)[:, 2]], atol=1e-5)
    assert surface.cmin == -surface.cmax
    assert surface.cmax % 5 == 0
    assert surface.colorbar.title.text == "distance to the<br>true profile (mm)"


def test_a_fit_without_a_lower_end_has_no_errors_from_a_profile_that_stands_nowhere():
    known = KnownProfile.frustum(61, 98, 119)
    surface = traces(hull_figure(made_hull(), Dimensions(reason="no"), cameras={}, known=known))["paper"]
    assert surface.intensity is None
    assert traces(hull_figure(made_hull(), made_dimensions(), cameras={}, known=known))["paper"].intensity is not None
