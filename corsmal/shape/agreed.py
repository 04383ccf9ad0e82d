"""What the outlines of several views agree on: where the axis is, and a radius at each height."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from corsmal.geometry import Floats
from corsmal.shape.outlines import Axis, FacingView
from corsmal.shape.profiles import smooth_profile

TRUST_MM = 3.0
"""A radius so much smaller than what the others agree on counts a quarter; one that is larger, at half as much more."""
OUTWARD = 1.5
PATIENCE, REWEIGHTINGS = 5.0, 10
"""At first so much more is forgiven, then less and less: a start with little trust would stay where it began."""
PIXELS = 3.0
"""A view whose sides are this many of its pixels off what all views say together counts half as much as one without
error: it is blurred, or its mask is cut or too wide. Fewer pixels would let a single view outdo the others."""
FIRST_QUANTILE = 0.75
"""Of the sides at a height, small to large: what hides a side makes it smaller, a wrong mask may make it larger."""
TILT_WEIGHT = 160.0
"""Rows of an outline err together: this many mm² of error between independent ones, against the expected tilt."""

STRAIGHT, FIRST_STRAIGHT = 2000.0, 100.0
"""What a square of the second difference of radii (mm per mm² of height) costs a straight profile against a square
millimetre of error of one side; at first so much more."""
CORNER = 0.05
"""A second difference of a straight profile that is so large is half a corner: it costs little more if it grows."""
LEAST_WEIGHT = 1e-6

MISFIT_MM, HIDING = 4.0, 0.5
"""Where fits are compared, an outline that is so much too small costs half of what it can cost at most, and that is so
much of what one costs that is too large."""


@dataclass(frozen=True, eq=False)
class Agreed:
    """What the sides of the views agree on.

    Args:
        shift_mm: (2,) of the axis.
        slope: (2,) of the axis.
        profile_mm: (H,) radii as a container has them: smooth, with corners; what is hidden in between is bridged, and
            NaN where nothing is seen.
        trust: (V,) how much each view counts, at most 1.
    """

    shift_mm: Floats
    slope: Floats
    profile_mm: Floats
    trust: Floats


def agree(
    views: Sequence[FacingView],
    sides: Floats,
    heights_mm: Floats,
    axis: Axis,
    *,
    tilt_deg: float,
    is_straight: bool = False,
    patience: float = PATIENCE,
    first_mm: Floats | None = None,
) -> Agreed:
    """Shift and slope of the axis and the radius at each height that most sides of most views agree on.

    Every side of every view says ``radius ± (shift + slope · height) along its sideways``. That is a least-squares
    problem whose weights are found again and again, first with much tolerance. Each height has a radius of its own,
    which is smoothed afterwards; or the profile is straight but for corners from the beginning, so that where a hand
    hides one side, what both sides show above and below decides on the axis.

    Args:
        views: the V views.
        sides: (V, 2, H) their radii on either side, mm, NaN where they are not seen.
        heights_mm: (H,) one millimetre apart.
        axis: that the radii are counted from.
        tilt_deg: how far it is expected to lean.
        is_straight: whether the profile is straight but for corners.
        patience: how much more is forgiven at first.
        first_mm: (H,) radii to begin with; default: of each height's sides a large one.
    """
    from corsmal.shape.agreed_kernels import reweighted_agreement  # noqa: PLC0415 - Numba takes long to import

    is_seen = np.isfinite(sides)
    rows = np.flatnonzero(is_seen.any(axis=(0, 1)))
    inner = slice(rows[0], rows[-1] + 1)
    seen = np.ascontiguousarray(is_seen[:, :, inner])
    sides_mm = np.where(seen, sides[:, :, inner], 0.0)
    costs = STRAIGHT * _falling(FIRST_STRAIGHT) if is_straight else np.zeros(REWEIGHTINGS)
    radii_mm, unknowns, trust, weights = reweighted_agreement(
        sides_mm,
        seen,
        heights_mm[inner],
        np.array([axis.across @ view.sideways for view in views]),
        _prior(tilt_deg),
        _upper(sides_mm, seen) if first_mm is None else first_mm[inner],
        _falling(patience),
        costs,
        np.array([TRUST_MM, *(PIXELS * view.pixel_mm for view in views)]),
        OUTWARD,
        CORNER,
        LEAST_WEIGHT,
    )
    if not is_straight:
        radii_mm = smooth_profile(np.where(seen.any(axis=(0, 1)), radii_mm, np.nan), weights)
    profile_mm = np.full(len(heights_mm), np.nan)
    profile_mm[inner] = radii_mm
    return Agreed(unknowns[:2], unknowns[2:], profile_mm, trust)


def misfit(sides: Floats, heights_mm: Floats, hull_mm: tuple[Floats, Floats], pixels_mm: Floats) -> float:
    """How badly a profile explains the sides of views, all about its axis: 0 is perfect, 1 is not at all.

    An error counts the less the larger it grows: a hand or a tongue is as wrong as it can be after a few millimetres.
    What makes a side smaller counts a little less than what makes it larger, since hands hide more often than masks
    have tongues, and a view with coarse pixels counts less.

    Args:
        sides: (V, 2, H) radii on either side, mm, NaN where they are not seen.
        heights_mm: (H,).
        hull_mm: heights, from base to rim, and radii of the profile.
        pixels_mm: (V,) what a pixel of each view spans.
    """
    places_mm, radii_mm = hull_mm
    counted = np.isfinite(sides) & (heights_mm >= places_mm[0] - 1) & (heights_mm <= places_mm[-1] + 1)
    error = np.where(counted, sides - np.interp(heights_mm, places_mm, radii_mm), 0.0)
    squares = (error / (MISFIT_MM * np.where(error < 0, 1.0, OUTWARD))) ** 2
    costs = np.where(error < 0, HIDING, 1.0) * squares / (1 + squares)
    shares = pixels_mm.min() / pixels_mm
    return float((costs.sum(axis=(1, 2)) * shares).sum() / (2 * np.ptp(places_mm) * shares.sum()))


@cache
def _falling(first: float) -> Floats:
    """(R,) from a number down to 1, each by the same factor."""
    return np.geomspace(first, 1.0, REWEIGHTINGS)


def _prior(tilt_deg: float) -> Floats:
    """(4,) what squares of the axis' shifts and slopes cost."""
    slope = TILT_WEIGHT / np.tan(np.radians(tilt_deg)) ** 2 if tilt_deg > 0 else np.inf
    return np.array([1e-6, 1e-6, slope, slope])


def _upper(sides: Floats, seen: NDArray[np.bool_]) -> Floats:
    """Of each height's sides, the one at three quarters from the smallest to the largest."""
    ordered = np.sort(np.where(seen, sides, np.inf).reshape(-1, sides.shape[2]), axis=0)
    counts = seen.sum(axis=(0, 1))
    places = np.rint(FIRST_QUANTILE * np.maximum(counts - 1, 0)).astype(np.intp)
    found = ordered[places, np.arange(len(places))]
    return np.where(counts > 0, found, 0.0)
