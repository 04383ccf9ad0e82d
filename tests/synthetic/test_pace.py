import pytest

from corsmal.synthetic.writing.pace import SOUND_COST, WINDOW, Pace

PARTS = ("view1", "view2", "view3", "sound")


def made(parts, seconds):
    """A pace and what it forecast after each piece: its time, and what was left then."""
    clock = [0.0]
    pace = Pace(len(parts) // len(PARTS), parts, clock_s=lambda: clock[0])
    told = []
    for part, duration_s in zip(parts, seconds, strict=True):
        clock[0] += duration_s
        pace.note(part)
        told.append((clock[0], pace.left_s))
    return pace, told


def test_a_view_is_one_unit_and_a_sound_a_share_of_it():
    pace, _ = made(PARTS, [1] * 4)
    assert pace.fraction == 1
    half = Pace(2, PARTS)
    assert half.fraction == 0.5
    half.note("view1")
    assert half.fraction == pytest.approx(0.5 + 1 / (2 * (3 + SOUND_COST)))


def test_at_a_steady_pace_the_forecast_is_right_whatever_the_first_piece_took():
    parts = PARTS * 30
    _, told = made(parts, [300.0] + [2.0 if part != "sound" else 2.0 * SOUND_COST for part in parts[1:]])
    end_s = told[-1][0]
    assert told[0][1] is None
    for time_s, left_s in told[1:]:
        assert abs(left_s - (end_s - time_s)) < 1e-6


def test_after_a_change_of_pace_the_forecast_is_right_within_the_window():
    parts = PARTS * 30
    cost = [SOUND_COST if part == "sound" else 1.0 for part in parts]
    _, told = made(parts, [unit * (1.0 if index < 40 else 5.0) for index, unit in enumerate(cost)])
    end_s = told[-1][0]
    assert told[39][1] < (end_s - told[39][0]) / 4
    for time_s, left_s in told[40 + WINDOW : -1]:
        assert 0.99 < left_s / (end_s - time_s) < 1.01


def test_a_cheap_and_a_dear_view_stay_within_a_factor_of_two():
    """The left, right and frontal view take 1.2, 0.9 and 1.5 units, as measured, and glass half as much again."""
    units = {"view1": 1.2, "view2": 0.9, "view3": 1.5, "sound": 0.2}
    parts = PARTS * 30
    seconds = [units[part] * (1.4 if index // 4 % 15 in range(3, 6) else 1.0) for index, part in enumerate(parts)]
    _, told = made(parts, [30.0 + seconds[0], *seconds[1:]])
    end_s = told[-1][0]
    for time_s, left_s in told[1:-1]:
        assert 0.5 < left_s / (end_s - time_s) < 2
