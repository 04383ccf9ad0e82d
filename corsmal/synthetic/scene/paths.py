"""What ways are made of: where they begin, smooth ramps, and rotations."""

import numpy as np
from numpy.typing import ArrayLike

from corsmal.synthetic.render.kernels import Floats

CENTRE_X_M = 0.27
"""Where the person sits and the container stands, along the table."""


def ramp(times_s: Floats, start_s: float, end_s: float, *, is_smooth: bool = True) -> Floats:
    """From 0 at ``start_s`` to 1 at ``end_s``, (F,); smooth at both ends unless told otherwise."""
    share = np.clip((times_s - start_s) / max(end_s - start_s, 1e-6), 0, 1)
    return share * share * (3 - 2 * share) if is_smooth else share


def axis_rotation(axis: ArrayLike, angles_rad: ArrayLike) -> Floats:
    """(n, 3, 3) rotations about a unit axis (3,) by the angles (n,)."""
    x, y, z = np.asarray(axis, dtype=np.float64)
    angles = np.atleast_1d(np.asarray(angles_rad, dtype=np.float64))[:, None, None]
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angles) * cross + (1 - np.cos(angles)) * (cross @ cross)
