import numpy as np
import pytest

from corsmal.errors import ArgumentError
from corsmal.shape import Hull, capacity_ml, learn_wall_mm, learn_walls_of_others

BOX = Hull(np.array([0.0, 9.0]), np.ones(2), np.ones(2, dtype=bool), np.zeros(3), depth_mm=2.0)


def cup(bottom_mm, top_mm):
    heights = np.arange(0.0, 110.0, 10.0)
    return Hull(heights, np.linspace(bottom_mm, top_mm, len(heights)), np.ones(len(heights), dtype=bool), np.zeros(3))


CUPS = [cup(30, 49), cup(21, 34), cup(28, 44)]


def test_the_wall_is_learnt_from_known_capacities():
    truth = [capacity_ml(cup, wall_mm=1.7) for cup in CUPS]
    assert learn_wall_mm([*CUPS, BOX, Hull.failed("no")], [*truth, 1.0, 1.0]) == pytest.approx(1.7)
    with pytest.raises(ArgumentError, match="capacity for each"):
        learn_wall_mm(CUPS, truth[:2])
    with pytest.raises(ArgumentError, match="round"):
        learn_wall_mm([BOX], [1.0])


def test_containers_without_walls_teach_none():
    assert learn_wall_mm(CUPS, [capacity_ml(cup) for cup in CUPS]) == 0


def test_a_container_is_given_the_wall_of_the_others():
    walls = (1.0, 2.0, 3.0)
    hulls = [*CUPS, *CUPS]
    truth = [capacity_ml(hull, wall_mm=wall) for hull, wall in zip(hulls, walls * 2, strict=True)]
    found = learn_walls_of_others(hulls[:5], truth[:5], ["a", "b", "c", "a", "b"])
    assert found == [
        learn_wall_mm([hulls[i] for i in kept], [truth[i] for i in kept])
        for kept in ((1, 2, 4), (0, 2, 3), (0, 1, 3, 4), (1, 2, 4), (0, 2, 3))
    ]
    assert found[0] == 2.0


def test_the_only_round_container_is_given_none():
    truth = [capacity_ml(CUPS[0], wall_mm=0.8), 1.0]
    assert learn_walls_of_others([CUPS[0], BOX], truth, ["cup", "box"]) == [None, pytest.approx(0.8)]
