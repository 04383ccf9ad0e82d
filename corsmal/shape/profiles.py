"""Profiles of containers: smooth in long stretches, with few corners."""

import numpy as np
from numpy.typing import NDArray

from corsmal.geometry import Floats

STIFFNESS = 30.0
"""What a square of the second difference of radii (mm per mm² of height) costs against a square millimetre of error,
where all sides agree."""
AGREEING_POWER = 3.0
"""A radius counts with this power of the share of the sides that agree on it: the foot of a glass is thin as well, but
all sides show it, and the tongue of a mask between two fingers is in one side of one view."""
CORNER = 0.08
"""A second difference so large is half a corner: it costs little more if it grows."""
OUTLIER_MM = 3.0
"""A radius that lies so far from the profile counts a quarter."""
ROUNDS, FIRST_TOLERANCE = 8, 16.0
"""At first corners and outliers must be so much larger, then less and less."""
ROWS_MIN = 5


def smooth_profile(radii_mm: Floats, weights: Floats) -> Floats:
    """Radii that are smooth but for a few corners, from radii of which some are wrong.

    The squares of errors and of second differences are made least together. Their weights are found again and again: an
    error that stays large is an outlier, and a second difference that stays large a corner.

    Args:
        radii_mm: (H,) at heights one millimetre apart, mm, NaN where nothing is seen.
        weights: (H,) how much each is believed, not negative.

    Returns:
        (H,) mm; what is not seen between two seen heights is bridged, what lies beyond them stays NaN.
    """
    from corsmal.shape.agreed_kernels import reweighted_smoothing  # noqa: PLC0415 - Numba takes long to import

    seen: NDArray[np.bool_] = np.isfinite(radii_mm)
    rows = np.flatnonzero(seen)
    if len(rows) < ROWS_MIN:
        return radii_mm
    inner = slice(rows[0], rows[-1] + 1)
    known = np.where(seen, radii_mm, 0.0)[inner]
    shares = np.where(seen, weights, 0.0)[inner] / max(float(weights[seen].max()), 1e-9)
    believed = shares**AGREEING_POWER + np.where(seen[inner], 1e-6, 0.0)
    tolerances = np.maximum(1.0, FIRST_TOLERANCE / 2.0 ** np.arange(ROUNDS))
    result = radii_mm.copy()
    result[inner] = reweighted_smoothing(known, believed, tolerances, STIFFNESS, CORNER, OUTLIER_MM)
    return result
