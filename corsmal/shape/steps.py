"""The widths as the authors' released program finds them: where the steps between a profile's radii become smaller."""

import numpy as np
from numpy.typing import NDArray

from corsmal.geometry import Floats
from corsmal.parameters import ShapeParameters

ON_GRID_MM = 1e-6
"""A radius that differs by less from one that was tried is that one."""


def metres_of(radii_mm: Floats, parameters: ShapeParameters) -> Floats:
    """Radii (n,) in metres, bit for bit those that the program tries.

    It compares steps without a tolerance. Equal steps of the grid differ in their last bit, and which one is the
    smaller depends on the unit.
    """
    tried_m = np.linspace(parameters.radius_max_mm / 1000, parameters.radius_min_mm / 1000, parameters.radii)
    step_m = (tried_m[0] - tried_m[-1]) / (parameters.radii - 1)
    places = np.rint((tried_m[0] - radii_mm / 1000) / step_m).clip(0, parameters.radii - 1).astype(np.intp)
    is_tried = np.abs(1000 * tried_m[places] - radii_mm) < ON_GRID_MM
    return np.where(is_tried, tried_m[places], radii_mm / 1000)


def kept_steps(radii_m: Floats, *, max_difference_m: float) -> NDArray[np.intp]:
    """Which radii (n,), from the lowest circumference up, the program keeps.

    One is kept if the next differs from it by less than d_max, and from the one after the last kept by d_max or more.

    Returns:
        (k,) their positions, ascending.
    """
    kept: list[int] = []
    after_kept_m = -1.0
    for place, (radius_m, next_m) in enumerate(zip(radii_m[:-1].tolist(), radii_m[1:].tolist(), strict=True)):
        if abs(next_m - radius_m) < max_difference_m and abs(next_m - after_kept_m) >= max_difference_m:
            kept.append(place)
            after_kept_m = next_m
    return np.array(kept, dtype=np.intp)


def step_ends(kept_m: Floats) -> tuple[int | None, int | None]:
    """Where the widths of a profile's kept radii (k,) are measured.

    Going up, the bottom is the upper radius of the first step that is smaller than the step before it. Going down, the
    top is the upper radius of the first step that is smaller than the one before, which lies above it.

    Returns:
        Positions of the bottom and of the top; None where no step is smaller.
    """
    steps_m = np.abs(np.diff(kept_m))
    slowing = np.flatnonzero(steps_m[:-1] > steps_m[1:])
    quickening = np.flatnonzero(steps_m[:-1] < steps_m[1:])
    bottom = int(slowing[0]) + 2 if len(slowing) else None
    top = int(quickening[-1]) + 1 if len(quickening) else None
    return bottom, top
