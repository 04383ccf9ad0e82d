"""The wall that a hull has and a capacity has not: learned from containers whose capacities are known."""

from collections.abc import Hashable, Sequence

import numpy as np

from corsmal.errors import ArgumentError
from corsmal.parameters import WALL_MAX_MM
from corsmal.shape.measuring import capacity_ml
from corsmal.shape.records import Hull

WALL_STEP_MM = 0.1


def learn_wall_mm(hulls: Sequence[Hull], capacities_ml: Sequence[float]) -> float:
    """The wall, in steps of 0.1 mm, with which hulls hold what is annotated, with the least mean error in %.

    Boxes and failed hulls count for nothing.

    Raises:
        ArgumentError: there is not a capacity for each hull, or no hull of a round container.
    """
    if len(hulls) != len(capacities_ml):
        raise ArgumentError(f"there must be a capacity for each hull, got {len(capacities_ml)} for {len(hulls)}")
    pairs = [(hull, true) for hull, true in zip(hulls, capacities_ml, strict=True) if hull.ok and hull.depth_mm is None]
    if not pairs:
        raise ArgumentError("hulls must hold a round container's, got none")
    walls = np.arange(0.0, WALL_MAX_MM + WALL_STEP_MM / 2, WALL_STEP_MM)
    errors = [np.mean([abs(capacity_ml(hull, wall_mm=wall) - true) / true for hull, true in pairs]) for wall in walls]
    return round(float(walls[int(np.argmin(errors))]), 1)


def learn_walls_of_others(
    hulls: Sequence[Hull], capacities_ml: Sequence[float], containers: Sequence[Hashable]
) -> list[float | None]:
    """``learn_wall_mm`` for every hull from the hulls of all other containers: what an unseen one would be given.

    ``containers`` says which one each recording shows.

    Returns:
        A wall for each hull, mm; None where no other container is round.
    """
    found_mm: dict[Hashable, float | None] = {}
    for container in containers:
        if container in found_mm:
            continue
        others = [index for index, other in enumerate(containers) if other != container]
        try:
            found_mm[container] = learn_wall_mm([hulls[i] for i in others], [capacities_ml[i] for i in others])
        except ArgumentError:
            found_mm[container] = None
    return [found_mm[container] for container in containers]
