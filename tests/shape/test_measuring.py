import numpy as np
import pytest

from corsmal.parameters import ShapeParameters
from corsmal.shape import Hull, measure_hull
from corsmal.shape.measuring import capacity_ml, frusta_volume_ml, profile_ends, smooth


def hull_of(radii_mm, *, step_mm=10.0, converged=None):
    radii = np.array(radii_mm, dtype=float)
    flags = np.ones(len(radii), dtype=bool) if converged is None else np.array(converged, dtype=bool)
    return Hull(np.arange(len(radii)) * step_mm, radii, flags, np.zeros(3))


def test_volume_of_a_cylinder_a_cone_and_a_sphere():
    assert frusta_volume_ml(np.array([0.0, 100.0]), np.array([35.0, 35.0])) == pytest.approx(np.pi * 35**2 * 0.1)
    assert frusta_volume_ml(np.array([0.0, 120.0]), np.array([0.0, 45.0])) == pytest.approx(np.pi * 45**2 * 0.12 / 3)
    angles = np.linspace(0, np.pi, 2001)
    sphere = frusta_volume_ml(50 - 50 * np.cos(angles), 50 * np.sin(angles))
    assert sphere == pytest.approx(4 / 3 * np.pi * 125, rel=1e-5)
    assert frusta_volume_ml(np.array([7.0]), np.array([3.0])) == 0


def test_volume_by_hand():
    # two frusta of height 3: pi/3 * 3 * ((4 + 2 + 1) + (9 + 6 + 4)) mm3
    assert frusta_volume_ml(np.array([0.0, 3.0, 6.0]), np.array([1.0, 2.0, 3.0])) == pytest.approx(np.pi * 26 / 1000)


@pytest.mark.parametrize(
    ("radii", "kept"),
    [
        ([30, 31, 32, 33], [True, True, True, True]),
        ([20, 31, 32, 30], [False, True, False, True]),
        ([20, 22, 24, 26], [False, False, False, True]),
        ([30], [True]),
        ([], []),
    ],
)
def test_smoothing_drops_a_radius_that_the_next_one_differs_from(radii, kept):
    assert smooth(np.array(radii, dtype=float), max_difference_mm=1).tolist() == kept


def test_ends_by_hand():
    # steps 8 2 1 1 3 9: equation 7 gives the second radius (8 > 2), equation 8 the fifth (3 < 9)
    radii = np.array([10.0, 18.0, 20.0, 21.0, 22.0, 25.0, 16.0])
    assert profile_ends(radii) == (1, 4)


def test_ends_of_a_straight_profile_are_its_first_and_last():
    grid = np.linspace(75, 2.5, 145)
    assert profile_ends(grid[40:60][::-1]) == (0, 19)
    assert profile_ends(np.full(7, 30.0)) == (0, 6)


def test_dimensions_by_hand():
    dimensions = measure_hull(hull_of([28, 30, 30.5, 31, 31.2, 31.9, 33]), ShapeParameters(max_difference_mm=2))
    # steps 2 .5 .5 .2 .7 1.1: lower end at 30 (2 > .5), upper end at 31.2 (.7 < 1.1)
    assert (dimensions.bottom, dimensions.top) == (1, 4)
    assert dimensions.width_bottom_mm == pytest.approx(60)
    assert dimensions.width_top_mm == pytest.approx(62.4)
    assert dimensions.height_mm == pytest.approx(30)
    assert dimensions.capacity_ml == pytest.approx(
        frusta_volume_ml(np.arange(7) * 10.0, np.array([28, 30, 30.5, 31, 31.2, 31.9, 33]))
    )


def test_indices_point_into_the_hull_past_what_did_not_converge_or_was_smoothed_away():
    radii = [2.5, 10, 28, 28.6, 29, 29.1, 29.3, 2.5]
    dimensions = measure_hull(hull_of(radii, converged=[0, 1, 1, 1, 1, 1, 1, 0]))
    # 10 is dropped; the steps .6 .4 .1 .2 remain
    assert dimensions.kept.tolist() == [2, 3, 4, 5, 6]
    assert (dimensions.bottom, dimensions.top) == (3, 4)
    assert dimensions.height_mm == pytest.approx(10)
    assert dimensions.capacity_ml == pytest.approx(frusta_volume_ml(np.arange(1, 7) * 10.0, np.array(radii[1:7])))


def test_widest_takes_the_largest_radius_and_the_whole_extent():
    dimensions = measure_hull(
        hull_of([2.5, 20, 44, 30, 2.5], converged=[0, 1, 1, 1, 0]), ShapeParameters(width_rule="widest")
    )
    assert dimensions.width_top_mm == dimensions.width_bottom_mm == 88
    assert dimensions.height_mm == 20
    assert (dimensions.bottom, dimensions.top) == (1, 3)


@pytest.mark.parametrize(
    ("hull", "reason"),
    [
        (Hull.failed("mask 1 of 2 is empty"), "mask 1 of 2 is empty"),
        (hull_of([2.5, 30, 30, 2.5], converged=[0, 1, 1, 0]), "only 2 of 4"),
        (hull_of([10, 20, 30, 40, 50]), "d_max is too small"),
        (hull_of([30, 30.1, 30.9, 30.8, 30.7]), "below its lower end"),
    ],
)
def test_a_failed_fit_says_why_and_holds_no_number(hull, reason):
    dimensions = measure_hull(hull)
    assert not dimensions.ok
    assert reason in dimensions.reason
    assert dimensions.capacity_ml is None
    assert dimensions.height_mm is None


def test_the_whole_profile_is_taken_as_it_is():
    dimensions = measure_hull(hull_of([20, 40, 25, 30]), ShapeParameters(width_rule="whole"))
    assert (dimensions.width_bottom_mm, dimensions.width_top_mm, dimensions.height_mm) == (40, 60, 30)
    assert dimensions.kept.tolist() == [0, 1, 2, 3]


def test_a_wall_makes_the_cavity_narrower():
    cylinder = hull_of([35] * 11)
    assert capacity_ml(cylinder) == pytest.approx(np.pi * 35**2 * 0.1)
    assert capacity_ml(cylinder, wall_mm=2) == pytest.approx(np.pi * 33**2 * 0.1)
    assert capacity_ml(hull_of([0.5] * 11), wall_mm=2) == 0


def test_a_glass_holds_nothing_below_the_narrowest_place_of_its_stem():
    foot, stem, bowl = [30, 30], [4] * 6, [20, 40, 40, 40]
    glass = hull_of([*foot, *stem, *bowl])
    # from the stem's first circumference, the lowest of equal ones
    radii = np.array([*stem, *bowl]) - 1.0
    assert capacity_ml(glass, wall_mm=1) == pytest.approx(frusta_volume_ml(np.arange(10) * 10.0, radii))
    assert capacity_ml(glass) > capacity_ml(glass, wall_mm=0.1) + 40


def test_a_box_holds_its_volume_whatever_the_wall():
    heights = np.array([0.0, 50.0, 150.0])
    box = Hull(heights, np.full(3, 60.0), np.ones(3, dtype=bool), np.zeros(3), depth_mm=40.0)
    assert capacity_ml(box, wall_mm=1) == capacity_ml(box) == pytest.approx(120 * 40 * 150 / 1000)
