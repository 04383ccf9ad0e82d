import numpy as np
import pytest

from corsmal.errors import ArgumentError
from corsmal.mass import filling_mass_g, mm_per_pixel
from tests.tiny import tiny_cameras


@pytest.mark.parametrize(
    ("filling_type", "filling_level", "mass_g"),
    [(0, 0, 0), (1, 1, 85), (1, 2, 153), (2, 1, 205), (2, 2, 369), (3, 1, 250), (3, 2, 450), (0, 2, 0), (3, 0, 0)],
)
def test_filling_mass_of_500_ml(filling_type, filling_level, mass_g):
    assert filling_mass_g(filling_type, filling_level, 500.0) == pytest.approx(mass_g)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ((4, 1, 500.0), "filling_type"),
        ((-1, 1, 500.0), "filling_type"),
        ((1, 3, 500.0), "filling_level"),
        ((1, 0.5, 500.0), "filling_level"),
        ((1, 1, -1.0), "capacity_ml"),
        ((1, 1, float("nan")), "capacity_ml"),
        ((1, 1, float("inf")), "capacity_ml"),
    ],
)
def test_numbers_out_of_their_range_are_named(arguments, name):
    with pytest.raises(ArgumentError, match=f"{name} must be"):
        filling_mass_g(*arguments)


@pytest.mark.parametrize("size", [(1280, 720), (640, 360)])
def test_a_millimetre_across_the_view_is_so_many_pixels(size):
    camera = tiny_cameras(size)["view3"]
    right = camera.rotation[0]  # the camera's own x axis in the world
    point = camera.centre_m + 0.7 * camera.rotation[2]
    moved = camera.project(np.array([point, point + 0.05 * right]))
    assert 50 / np.linalg.norm(moved[1] - moved[0]) == pytest.approx(mm_per_pixel(camera, point), rel=0.01)


@pytest.mark.parametrize("point", [[0.0, 0.0], [np.nan, 0.0, 0.0]])
def test_a_point_that_is_none_has_no_scale(point):
    with pytest.raises(ArgumentError, match="point_m must be three finite metres"):
        mm_per_pixel(tiny_cameras((640, 360))["view3"], np.array(point))


def test_a_point_behind_the_camera_has_no_scale():
    camera = tiny_cameras((640, 360))["view3"]
    with pytest.raises(ArgumentError, match="in front of the camera"):
        mm_per_pixel(camera, camera.centre_m - camera.rotation[2])
