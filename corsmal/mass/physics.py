"""What follows from capacity, filling and scale; no network is needed."""

import math

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset.annotation import DENSITIES_G_PER_ML, LEVEL_FRACTIONS
from corsmal.errors import ArgumentError
from corsmal.geometry import Camera


def filling_mass_g(filling_type: int, filling_level: int, capacity_ml: float | None) -> float | None:
    """Mass of a filling: level fraction × capacity × density.

    Args:
        filling_type: 0 none, 1 pasta, 2 rice, 3 water.
        filling_level: 0 empty, 1 half, 2 full.
        capacity_ml: of the container, mL, not negative; None where it is not known.

    Returns:
        Grams; 0 for a type without a level or a level without a type, whatever the capacity; None where the capacity is
        needed and not known.

    Raises:
        ArgumentError: a number is out of its range.

    Example:
        >>> filling_mass_g(2, 1, 500.0)
        205.0
    """
    for name, value, values in (
        ("filling_type", filling_type, DENSITIES_G_PER_ML),
        ("filling_level", filling_level, LEVEL_FRACTIONS),
    ):
        if value not in range(len(values)):
            raise ArgumentError(f"{name} must be a whole number from 0 to {len(values) - 1}, got {value!r}")
    share = LEVEL_FRACTIONS[filling_level] * DENSITIES_G_PER_ML[filling_type]
    if capacity_ml is None:
        return None if share else 0.0
    if not 0 <= capacity_ml < math.inf:
        raise ArgumentError(f"capacity_ml must be a finite number of mL, 0 or more, got {capacity_ml!r}")
    return LEVEL_FRACTIONS[filling_level] * float(capacity_ml) * DENSITIES_G_PER_ML[filling_type]


def mm_per_pixel(camera: Camera, point_m: NDArray[np.float64]) -> float:
    """Millimetres that one pixel of a camera's image spans at the depth of a world point (3,), in metres.

    Raises:
        ArgumentError: the point is not finite, or lies behind the camera.
    """
    point = np.asarray(point_m, dtype=np.float64)
    depth_m = float(camera.rotation[2] @ point + camera.translation[2]) if point.shape == (3,) else math.nan
    if not 0 < depth_m < math.inf:
        raise ArgumentError(f"point_m must be three finite metres in front of the camera, got {point.tolist()}")
    return 1000 * depth_m / math.sqrt(camera.intrinsic[0, 0] * camera.intrinsic[1, 1])
