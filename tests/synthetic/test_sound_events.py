import dataclasses

import numpy as np
import pytest

from corsmal.errors import ArgumentError
from corsmal.synthetic.sound.events import SoundEvents, pour_duration_s

CUP = SoundEvents("cup", "plastic", 520.0, 119.0, 96.0, "water", 2, 2.0, "pour", 0.3, 1.8, (0.0, 0.0, 0.1), (0.1,))
BOX = dataclasses.replace(
    CUP, container_kind="box", material="cardboard", capacity_ml=1240.0, filling="rice", action="shake"
)


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


@pytest.mark.parametrize(
    ("filling", "level", "capacity_ml", "pace"),
    [("rice", 0, 400, 1), ("none", 1, 400, 1), ("sand", 1, 400, 1), ("rice", 3, 400, 1), ("rice", 1, 0, 1),
     ("rice", 1, np.nan, 1), ("rice", 1, 400, -1)],
)  # fmt: skip
def test_impossible_pours_are_refused(filling, level, capacity_ml, pace):
    with pytest.raises(ArgumentError):
        pour_duration_s(filling, level, capacity_ml, rng=np.random.default_rng(0), pace=pace)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"action": "pour"}, "never hold water"),
        ({"filling": "water"}, "never hold water"),
        ({"container_kind": "cup"}, "only boxes are shaken"),
        ({"container_kind": "jar"}, "container_kind must be one of"),
        ({"material": "wood"}, "material must be one of"),
        ({"level": 0}, "level 0"),
        ({"filling": "none"}, "level 0"),
        ({"action": "handle"}, "leaves the container empty"),
        ({"capacity_ml": -1.0}, "capacity_ml"),
        ({"duration_s": np.nan}, "duration_s"),
        ({"end_s": 2.5}, "end_s"),
        ({"end_s": 0.3}, "after start_s"),
        ({"contacts_s": (3.0,)}, "contacts_s"),
        ({"source_path_m": (0.0, 1.0)}, "source_path_m"),
        ({"source_path_m": np.zeros((2, 3)), "times_s": None}, "source_path_m"),
        ({"source_path_m": np.zeros((2, 3)), "times_s": (1.0, 1.0)}, "increase"),
        ({"source_path_m": (0.0, np.inf, 0.0)}, "finite"),
    ],
)
def test_impossible_recordings_are_refused(changes, message):
    fields = {**{field.name: getattr(BOX, field.name) for field in dataclasses.fields(BOX)}, **changes}
    with pytest.raises(ArgumentError, match=message):
        SoundEvents(**fields)


def test_an_empty_container_cannot_be_poured_into_with_nothing():
    with pytest.raises(ArgumentError, match="needs a filling"):
        dataclasses.replace(CUP, filling="none", level=0)
