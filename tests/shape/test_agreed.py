"""What the sides of several views agree on."""

from types import SimpleNamespace

import numpy as np
import pytest

from corsmal.shape.agreed import LEAST_WEIGHT, _least_squares, agree, misfit
from corsmal.shape.outlines import Axis

HEIGHTS = np.arange(120.0)
CONE = 30 + 0.15 * HEIGHTS
UPRIGHT = Axis(np.zeros(3), np.array([0.0, 0.0, 1.0]))


def facing(*angles_deg):
    angles = np.radians(angles_deg)
    return [SimpleNamespace(sideways=np.array([np.cos(a), np.sin(a), 0.0]), pixel_mm=1.0) for a in angles]


@pytest.mark.parametrize("is_straight", [False, True])
def test_sides_of_a_cone_about_a_shifted_axis_give_the_cone_and_the_shift(is_straight):
    views, shift = facing(0, 70, 130), np.array([2.0, -3.0])
    moved = np.array([view.sideways[:2] @ shift for view in views])
    sides = np.stack([CONE + moved[:, None], CONE - moved[:, None]], axis=1)
    found = agree(views, sides, HEIGHTS, UPRIGHT, tilt_deg=3.0, is_straight=is_straight)
    np.testing.assert_allclose(found.shift_mm, shift, atol=0.05)
    np.testing.assert_allclose(found.slope, 0, atol=1e-3)
    np.testing.assert_allclose(found.profile_mm, CONE, atol=0.1)


def test_a_straight_profile_is_continued_below_what_a_hand_hides_on_one_side_of_all_views():
    views = facing(0, 20)
    sides = np.repeat(CONE[None, None], 2, axis=0).repeat(2, axis=1)
    sides[:, 1, :50] -= 12 + 6 * np.sin(HEIGHTS[:50] / 4)  # what four fingers take from one side
    worst = {}
    for is_straight in (False, True):
        found = agree(views, sides, HEIGHTS, UPRIGHT, tilt_deg=3.0, is_straight=is_straight)
        worst[is_straight] = np.abs(found.profile_mm - CONE).max()
    assert worst[True] < 0.7 * worst[False]


def test_a_straight_profile_has_corners():
    views, cornered = facing(0, 70), np.interp(HEIGHTS, [0, 60, 119], [20, 35, 37])
    sides = np.repeat(cornered[None, None], 2, axis=0).repeat(2, axis=1)
    found = agree(views, sides, HEIGHTS, UPRIGHT, tilt_deg=3.0, is_straight=True)
    np.testing.assert_allclose(found.profile_mm, cornered, atol=1.0)


def test_heights_that_nothing_shows_are_bridged_between_and_left_out_beyond():
    views = facing(0, 70)
    sides = np.repeat(CONE[None, None], 2, axis=0).repeat(2, axis=1)
    sides[:, :, 50:60] = np.nan
    sides[:, :, :5] = np.nan
    for is_straight in (False, True):
        found = agree(views, sides, HEIGHTS, UPRIGHT, tilt_deg=0.0, is_straight=is_straight)
        assert np.flatnonzero(np.isnan(found.profile_mm)).tolist() == list(range(5))
        np.testing.assert_allclose(found.profile_mm[5:], CONE[5:], atol=0.1)


def test_least_squares_are_those_of_the_whole_system():
    rng = np.random.default_rng(3)
    rows, unknowns = 12, 4
    sides, weights = rng.normal(30, 3, (3, 2, rows)), rng.uniform(0.1, 1, (3, 2, rows))
    design, stiffness = rng.normal(size=(3, 2, rows, unknowns)), rng.uniform(0, 50, rows - 2)
    prior = np.diag([1e-6, 1e-6, 2.0, 3.0])
    found_mm, found = _least_squares(sides, design, weights, prior, stiffness)
    system, right = [], []
    for view, side, row in np.ndindex(3, 2, rows):
        root = np.sqrt(weights[view, side, row])
        system.append(root * np.concatenate([np.eye(rows)[row], design[view, side, row]]))
        right.append(root * sides[view, side, row])
    for row in range(rows - 2):
        bend = np.zeros(rows + unknowns)
        bend[row : row + 3] = (1, -2, 1)
        system.append(np.sqrt(stiffness[row]) * bend)
    system += list(np.sqrt(np.diag([LEAST_WEIGHT] * rows + [*np.diag(prior)])))
    right += [0.0] * (len(system) - len(right))
    expected = np.linalg.lstsq(np.array(system), np.array(right), rcond=None)[0]
    np.testing.assert_allclose(np.concatenate([found_mm, found]), expected, rtol=1e-6)


def test_the_misfit_counts_what_is_too_small_half_and_coarse_views_less():
    hull = np.array([0.0, 120.0]), np.array([40.0, 40.0])
    heights, pixels = np.arange(1.0, 121.0), np.array([1.0, 3.0])
    exact = np.full((2, 2, 120), 40.0)
    assert misfit(exact, heights, hull, pixels) == 0
    # 4 mm too small costs half of one half, 6 mm too large half; of the two views the second counts a third
    for side, view, cost in ((36.0, 0, 0.25 / 2), (46.0, 0, 0.5 / 2), (46.0, 1, 0.5 / 3 / 2)):
        sides = exact.copy()
        sides[view, 1] = side
        assert misfit(sides, heights, hull, pixels) == pytest.approx(cost / (4 / 3))
    unseen = exact.copy()
    unseen[1] = np.nan
    assert misfit(unseen, heights, hull, pixels) == 0
