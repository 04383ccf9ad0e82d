"""Profiles that are known, with what bends them."""

import numpy as np
import pytest

from corsmal.shape.agreed_kernels import reweighted_smoothing, second_difference_bands, solve_bands
from corsmal.shape.profiles import smooth_profile

HEIGHTS = np.arange(120.0)
CONE = 30.0 + 0.15 * HEIGHTS
FULL = np.full(120, 4.0)


def test_a_straight_wall_stays_as_it_is():
    np.testing.assert_allclose(smooth_profile(CONE, FULL), CONE, atol=1e-6)


def test_a_tongue_of_a_mask_that_one_side_of_six_shows_bends_nothing():
    bent, weights = CONE.copy(), FULL.copy()
    bent[20:28], weights[20:28] = 55.0, 1.0
    np.testing.assert_allclose(smooth_profile(bent, weights), CONE, atol=1.0)


def test_what_no_view_shows_is_bridged_and_nothing_is_added_at_the_ends():
    seen = CONE.copy()
    seen[40:80] = seen[:5] = seen[-3:] = np.nan
    found = smooth_profile(seen, FULL)
    assert np.isnan(found[:5]).all()
    assert np.isnan(found[-3:]).all()
    np.testing.assert_allclose(found[5:-3], CONE[5:-3], atol=1e-3)


def test_a_corner_stays_sharp():
    shoulder = np.minimum(20.0 + 1.0 * HEIGHTS, 50.0)
    found = smooth_profile(shoulder, FULL)
    np.testing.assert_allclose(found, shoulder, atol=0.6)


def test_the_foot_of_a_glass_that_all_sides_show_stays():
    glass = np.where(HEIGHTS < 8, 33.0, np.where(HEIGHTS < 60, 5.0, 35.0))
    found = smooth_profile(glass, FULL)
    for rows, radius in ((slice(1, 6), 33.0), (slice(12, 56), 5.0), (slice(64, 118), 35.0)):
        np.testing.assert_allclose(found[rows], radius, atol=1.5)


def test_noise_of_a_millimetre_becomes_a_third():
    noise = np.random.default_rng(3).normal(0, 1.0, 120)
    found = smooth_profile(CONE + noise, FULL)
    assert np.abs(found - CONE).mean() < np.abs(noise).mean() / 3


@pytest.mark.parametrize("rows", [0, 1, 4])
def test_too_few_rows_stay_as_they_are(rows):
    few = np.full(20, np.nan)
    few[3 : 3 + rows] = 7.0
    np.testing.assert_array_equal(smooth_profile(few, np.ones(20)), few)


def stiff(radii, trust, stiffness):
    """The solution of the whole matrix."""
    second = np.diff(np.eye(len(radii)), n=2, axis=0)
    return np.linalg.solve(np.diag(trust) + second.T @ np.diag(stiffness) @ second, trust * radii)


@pytest.mark.parametrize("rows", [3, 4, 9])
def test_the_banded_solution_is_that_of_the_whole_matrix(rows):
    rng = np.random.default_rng(4)
    radii, trust, stiffness = rng.uniform(10, 40, rows), rng.uniform(0.1, 3, rows), rng.uniform(1, 300, rows - 2)
    bands, right = second_difference_bands(stiffness), np.column_stack([trust * radii, trust])
    bands[2] += trust
    solve_bands(bands, right)
    np.testing.assert_allclose(right[:, 0], stiff(radii, trust, stiffness), rtol=1e-9)
    np.testing.assert_allclose(right[:, 1], stiff(np.ones(rows), trust, stiffness), rtol=1e-9)


def test_corners_and_outliers_are_found_again_in_each_round():
    rng = np.random.default_rng(5)
    radii, believed = rng.uniform(10, 40, 9), rng.uniform(0.1, 3, 9)
    trust, bends = believed, np.full(7, 30.0)
    for tolerance in (16.0, 8.0, 1.0):
        expected = stiff(radii, trust, bends)
        bends = 30 / (1 + (np.diff(expected, 2) / (0.08 * tolerance)) ** 2)
        trust = believed / (1 + ((radii - expected) / (3 * tolerance)) ** 2) ** 2
    found = reweighted_smoothing(radii, believed, np.array([16.0, 8.0, 1.0]), 30.0, 0.08, 3.0)
    np.testing.assert_allclose(found, expected, rtol=1e-6)
