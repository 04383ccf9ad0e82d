import io

import numpy as np
import pytest
import trimesh

from corsmal.errors import ArgumentError
from corsmal.shape import MESH_FORMATS, Hull, export_mesh, hull_mesh, measure_hull, profile_table

CYLINDER = Hull(
    np.array([-10.0, 0.0, 50.0, 100.0, 110.0]),
    np.array([2.5, 35.0, 35.0, 35.0, 2.5]),
    np.array([False, True, True, True, False]),
    np.array([0.1, -0.2, 0.05]),
)


def test_mesh_is_closed_and_holds_the_volume_of_its_prism():
    mesh = trimesh.Trimesh(*hull_mesh(CYLINDER, sides=24))
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(24 / 2 * np.sin(2 * np.pi / 24) * 35**2 * 100)
    np.testing.assert_allclose(mesh.bounds[:, 2], (0, 100))
    np.testing.assert_allclose(mesh.bounds.mean(axis=0)[:2], (100, -200))


def test_mesh_of_a_box_is_the_box():
    radii, heights = np.full(3, 60.0), np.array([0.0, 50.0, 150.0])
    box = Hull(heights, radii, np.ones(3, dtype=bool), np.array([0.1, 0.2, 0.0]), depth_mm=40.0, yaw=np.pi / 2)
    mesh = trimesh.Trimesh(*hull_mesh(box))
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(120 * 40 * 150)
    np.testing.assert_allclose(mesh.bounds, [[80, 140, 0], [120, 260, 150]], atol=1e-9)


def test_mesh_of_a_leaning_hull_leans():
    direction = np.array([0.6, 0.0, 0.8])
    heights = np.array([0.0, 100.0])
    hull = Hull(heights, np.full(2, 30.0), np.ones(2, dtype=bool), np.zeros(3), direction=direction)
    mesh = trimesh.Trimesh(*hull_mesh(hull))
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(np.pi * 30**2 * 100, rel=0.002)
    np.testing.assert_allclose(mesh.center_mass, 50 * direction, atol=1e-6)


@pytest.mark.parametrize("file_format", MESH_FORMATS)
def test_a_file_read_back_is_the_same_solid(file_format):
    content = export_mesh(CYLINDER, file_format=file_format)
    mesh = trimesh.load_mesh(io.BytesIO(content), file_type=file_format)
    mesh.merge_vertices()
    assert mesh.is_watertight
    assert mesh.volume / 1000 == pytest.approx(np.pi * 35**2 * 0.1, rel=0.002)


def test_a_hull_of_nothing_has_no_mesh():
    vertices, faces = hull_mesh(Hull.failed("empty"))
    assert (vertices.shape, faces.shape) == ((0, 3), (0, 3))
    with pytest.raises(ArgumentError, match="no mesh to export"):
        export_mesh(Hull.failed("empty"), file_format="ply")


def test_unknown_formats_and_too_few_sides_are_refused():
    with pytest.raises(ArgumentError, match="obj, ply, stl"):
        export_mesh(CYLINDER, file_format="exe")
    with pytest.raises(ArgumentError, match="sides"):
        hull_mesh(CYLINDER, sides=2)


def test_profile_table_marks_what_was_kept_and_the_ends():
    table = profile_table(CYLINDER, measure_hull(CYLINDER))
    assert table["kept"].tolist() == [False, True, True, True, False]
    assert table["end"].tolist() == ["", "bottom", "", "top", ""]
    assert table["height_mm"].tolist() == CYLINDER.heights_mm.tolist()
