import dataclasses

import numpy as np
import pytest

from corsmal.synthetic.sound.events import SoundEvents, pour_duration_s

CUP = SoundEvents("plastic", 520.0, 119.0, 96.0, "water", 2, 2.0, "pour", 0.3, 1.8, (0.0, 0.0, 0.1), (0.1,))


def test_position_is_interpolated_and_held_at_both_ends():
    moving = dataclasses.replace(CUP, source_path_m=[(0, 0, 0), (0.2, 0, 0.1)], times_s=[0.5, 1.5])
    np.testing.assert_allclose(
        moving.position_m([0.0, 1.0, 2.0]), [(0, 0, 0), (0.1, 0, 0.05), (0.2, 0, 0.1)], atol=1e-12
    )
    np.testing.assert_allclose(CUP.position_m(1.7), [(0, 0, 0.1)])


def test_pouring_takes_longer_for_more_but_people_differ():
    half, full = (
        np.array([pour_duration_s("rice", level, 400.0, rng=np.random.default_rng(seed)) for seed in range(300)])
        for level in (1, 2)
    )
    assert np.median(full) == pytest.approx(1.8 * np.median(half), rel=1e-6)
    assert np.median(half) == pytest.approx(0.5 * 13.5, rel=0.1)
    assert np.percentile(half, 95) > np.percentile(full, 25)
    assert half.max() <= 4 * half.min() * (1 + 1e-9)


def test_nothing_poured_takes_no_time_and_a_faster_pace_less():
    assert pour_duration_s("none", 0, 400.0, rng=np.random.default_rng(0)) == 0
    slow = pour_duration_s("water", 1, 400.0, rng=np.random.default_rng(0))
    assert pour_duration_s("water", 1, 400.0, rng=np.random.default_rng(0), pace=2.0) == pytest.approx(slow / 2)
