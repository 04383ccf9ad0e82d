import numpy as np
import pytest

from corsmal.errors import ArgumentError
from corsmal.mass.axis import Axis, agreement, base_axis, base_ends, outline, whole_axis
from tests.mass.made import BOX, CUP, GLASS, container, gripped

BASE = (320, 260)


def offset_px(axis, point):
    """Distance of a point from an axis."""
    x, y = np.subtract(point, axis.point)
    return abs(x * axis.direction[1] - y * axis.direction[0])


def test_base_of_a_level_rectangle_ends_at_its_lower_corners():
    mask = np.zeros((60, 80), bool)
    mask[10:50, 20:45] = True
    left, right = base_ends(outline(mask).points)
    assert (left.tolist(), right.tolist()) == ([20, 49], [44, 49])
    axis = base_axis(outline(mask).points)
    assert axis.point == (32, 49)
    assert axis.direction == pytest.approx((0, -1))
    assert axis.tilt_deg == 0


def test_base_ends_of_a_tilted_rectangle_are_its_corners():
    mask = container(BOX, sag=0, tilt_deg=20)
    left, right = base_ends(outline(mask).points)
    along = 45 * np.array([np.cos(np.radians(20)), np.sin(np.radians(20))])
    np.testing.assert_allclose(left, np.array(BASE) - along, atol=1.5)
    np.testing.assert_allclose(right, np.array(BASE) + along, atol=1.5)


@pytest.mark.parametrize("tilt_deg", [-30, -17, -5, 0, 3, 12, 30])
@pytest.mark.parametrize("profile", [CUP, GLASS, BOX])
def test_axis_of_the_base_has_the_containers_tilt_and_place(profile, tilt_deg):
    axis = base_axis(outline(container(profile, tilt_deg=tilt_deg)).points)
    assert axis.tilt_deg == pytest.approx(tilt_deg, abs=2)
    assert offset_px(axis, BASE) < 1.5


def test_a_stray_part_above_does_not_move_the_base():
    mask = container(CUP)
    mask[20:40, 500:520] = True
    assert offset_px(base_axis(outline(mask).points), BASE) < 1


@pytest.mark.parametrize("tilt_deg", [-70, -60, -45, -20, 0, 10, 33, 70])
@pytest.mark.parametrize("profile", [CUP, GLASS])
def test_axis_of_the_whole_is_found_standing_or_leaning_by_up_to_70_degrees(profile, tilt_deg):
    axis = whole_axis(outline(container(profile, base=(320, 200), tilt_deg=tilt_deg)).points)
    assert axis.tilt_deg == pytest.approx(tilt_deg, abs=1)
    assert offset_px(axis, (320, 200)) < 1.5


@pytest.mark.parametrize("tilt_deg", [-25, 0, 8, 25])
@pytest.mark.parametrize("scale", [1, 3])
def test_axis_of_the_whole_is_found_though_a_hand_hides_half_of_one_side(tilt_deg, scale):
    profile = tuple((scale * width, scale * height) for width, height in CUP)
    pose = {"base": (320 * scale, 260 * scale), "tilt_deg": tilt_deg}
    mask = container(profile, size=(400 * scale, 640 * scale), **pose)
    seen = gripped(mask, low=40 * scale, high=115 * scale, **pose)
    axis = whole_axis(outline(seen).points)
    assert axis.tilt_deg == pytest.approx(tilt_deg, abs=1)
    assert offset_px(axis, pose["base"]) < 1.5 * scale


def test_whole_is_better_than_the_base_where_the_base_is_hidden():
    seen = container(CUP)
    y, x = np.mgrid[: seen.shape[0], : seen.shape[1]]
    seen &= y < 215 + 0.5 * (x - 320)  # something slanted hides the base and more on the left
    points = outline(seen).points
    assert offset_px(base_axis(points), BASE) > 10
    assert abs(base_axis(points).tilt_deg) > 15
    assert offset_px(whole_axis(points), BASE) < 3
    assert abs(whole_axis(points).tilt_deg) < 3
    assert agreement(points, base_axis(points)) < 0.5 * agreement(points, whole_axis(points))


def test_all_of_a_symmetric_outline_agrees_on_its_axis_and_little_of_it_on_another():
    points = outline(container(CUP)).points
    assert agreement(points, Axis((320, 0), (0, -1))) > 0.97
    assert agreement(points, Axis((330, 0), (0, -1))) == 0
    assert agreement(points, Axis.leaning(30, BASE)) < 0.3


def test_a_point_and_a_steep_line_have_no_base():
    mask = np.zeros((30, 30), bool)
    mask[10, 12] = True
    assert base_ends(outline(mask).points) is None
    mask[2:20, 12] = True
    assert base_axis(outline(mask).points) is None


def test_outline_counts_parts_and_holes():
    mask = np.zeros((50, 50), bool)
    assert (len(outline(mask).points), outline(mask).parts, outline(mask).holes) == (0, 0, 0)
    mask[5:20, 5:20] = True
    mask[8:10, 8:10] = mask[14, 14] = False
    mask[30:40, 30:40] = True
    mask[40, 40] = True  # touches at a corner
    found = outline(mask)
    assert (found.parts, found.holes) == (2, 2)
    assert found.points.min() == 5
    assert found.points.max() == 40


@pytest.mark.parametrize("values", [((0, 0), (0, 0)), ((0, 0), (1, 1)), ((np.nan, 0), (0, -1))])
def test_axis_needs_a_point_and_a_unit_direction(values):
    with pytest.raises(ArgumentError, match="finite point and a direction of length 1"):
        Axis(*values)
