"""What the sides of several views agree on."""

from types import SimpleNamespace

import numpy as np
import pytest

from corsmal.shape.agreed import LEAST_WEIGHT, agree, misfit
from corsmal.shape.agreed_kernels import least_squares, median, reweighted_agreement
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


def solved(sides, heights, along, weights, *, prior, stiffness):
    """Radii and unknowns from the whole system, a row for each side, bend and prior."""
    rows, system, right = len(heights), [], []
    for view, side, row in np.ndindex(sides.shape):
        root, sign = np.sqrt(weights[view, side, row]), (1, -1)[side]
        grows = sign * np.concatenate([along[view], heights[row] * along[view]])
        system.append(root * np.concatenate([np.eye(rows)[row], grows]))
        right.append(root * sides[view, side, row])
    for row in range(rows - 2):
        bend = np.zeros(rows + 4)
        bend[row : row + 3] = (1, -2, 1)
        system.append(np.sqrt(stiffness[row]) * bend)
    system += list(np.sqrt(np.diag([LEAST_WEIGHT] * rows + [*prior])))
    right += [0.0] * (len(system) - len(right))
    found = np.linalg.lstsq(np.array(system), np.array(right), rcond=None)[0]
    return found[:rows], found[rows:]


def made_sides(rng, *, rows=12):
    heights = np.arange(30.0, 30.0 + rows)
    return rng.normal(30, 3, (3, 2, rows)), heights, rng.normal(size=(3, 2)), np.array([1e-6, 1e-6, 2.0, 3.0])


def test_least_squares_are_those_of_the_whole_system():
    rng = np.random.default_rng(3)
    sides, heights, along, prior = made_sides(rng)
    weights, stiffness = rng.uniform(0.1, 1, sides.shape), rng.uniform(0, 50, len(heights) - 2)
    radii, unknowns = np.zeros(len(heights)), np.zeros(4)
    least_squares(sides, heights, along, weights, prior, stiffness, LEAST_WEIGHT, radii, unknowns)
    expected = solved(sides, heights, along, weights, prior=prior, stiffness=stiffness)
    np.testing.assert_allclose(np.concatenate([radii, unknowns]), np.concatenate(expected), rtol=1e-6)


@pytest.mark.parametrize("cost", [0.0, 700.0])
def test_weights_are_found_again_in_each_round(cost):
    sides, heights, along, prior = made_sides(np.random.default_rng(4))
    seen = np.ones(sides.shape, dtype=bool)
    seen[1, 0, 3:6] = False
    sides[~seen] = 0.0
    steps, costs, pixels = np.array([5.0, 2.0, 1.0]), cost * np.array([9.0, 3.0, 1.0]), np.array([2.0, 3.0, 4.0])
    first = np.full(len(heights), 30.0)
    found = reweighted_agreement(
        sides, seen, heights, along, prior, first, steps, costs, np.array([3.0, *pixels]), 1.5, 0.05, LEAST_WEIGHT
    )
    radii, unknowns, stiffness = first, np.zeros(4), np.full(len(heights) - 2, costs[0])
    for step, stiff in zip(steps, costs, strict=True):
        moved = (along @ unknowns[:2])[:, None] + (along @ unknowns[2:])[:, None] * heights
        error = sides - np.stack([radii + moved, radii - moved], axis=1)
        usual = np.array([np.median(np.abs(each[mask])) for each, mask in zip(error, seen, strict=True)])
        trust = 1 / (usual**2 + pixels**2)
        trust /= trust.max()
        weights = seen * trust[:, None, None] / (1 + (error / (3 * step * np.where(error < 0, 1, 1.5))) ** 2) ** 2
        agreeing = weights.sum(axis=(0, 1))
        if cost:
            weights *= agreeing / agreeing.max()
        radii, unknowns = solved(sides, heights, along, weights, prior=prior, stiffness=stiffness)
        stiffness = stiff / (1 + (np.diff(radii, 2) / (0.05 * step)) ** 2)
    for ours, plain in zip(found, (radii, unknowns, trust, agreeing), strict=True):
        np.testing.assert_allclose(ours, plain, rtol=1e-5, atol=1e-7)


def test_an_upright_axis_keeps_its_direction():
    views, moved = facing(0, 70, 130), 0.1 * HEIGHTS
    sides = np.stack([CONE + moved, CONE - moved])[None].repeat(3, axis=0)
    assert agree(views, sides, HEIGHTS, UPRIGHT, tilt_deg=0.0).slope.tolist() == [0.0, 0.0]
    assert np.abs(agree(views, sides, HEIGHTS, UPRIGHT, tilt_deg=3.0).slope).max() > 0.01


@pytest.mark.parametrize("count", [0, 1, 2, 5, 40, 41])
def test_the_median_is_numpys(count):
    rng = np.random.default_rng(count)
    for values in (rng.normal(size=50), rng.integers(0, 4, 50).astype(float), np.arange(50.0), -np.arange(50.0)):
        assert median(values[:count].copy()) == (np.median(values[:count]) if count else 0.0)


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
