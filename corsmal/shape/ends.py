"""Where a container ends: the base and the rim of a solid of revolution in the outlines of masks."""

from collections.abc import Sequence

import numpy as np

from corsmal.geometry import Floats
from corsmal.shape.outlines import FacingView

INSET_MM = 4.0
"""Within a pixel or two of its ends an outline is rounded by the mask's resolution: the ends are read from inside."""
SLOPE_MAX = 0.3
"""Walls that open faster than this are not continued to the ends."""
MIDDLE_SHARE = 0.6
"""Ends are looked for where the silhouette of a circle is nearly flat."""
END_TRUST_MM = 5.0
"""What hides an end only takes from a mask: of the views' ends the outermost counts, and those that are near to it."""


def end_of(
    views: Sequence[FacingView], trust: Floats, heights_mm: Floats, radii_mm: Floats, *, upper: bool
) -> tuple[float, float]:
    """Height of the base or the rim, and how far the views disagree on it.

    It is the first circle, from the middle on, whose silhouette reaches the mask's end.
    Circles beyond it would still project inside the mask, whose end is the far or near side of the rim or base.
    """
    middle = len(heights_mm) // 2
    order = np.arange(middle, len(heights_mm)) if upper else np.arange(middle, -1, -1)
    inset = round(INSET_MM)
    inner = np.clip(order - inset if upper else order + inset, 0, len(heights_mm) - 1)
    places, radii = heights_mm[order], np.maximum(radii_mm[inner], 1.0)
    shares = np.linspace(-MIDDLE_SHARE, MIDDLE_SHARE, 9)
    sign = 1.0 if upper else -1.0
    ends, counts = [], []
    for view, count in zip(views, trust, strict=True):
        missing_mm = view.missing_mm(places, radii, shares, upper=upper)
        if (reached := _crossing(places, missing_mm)) is not None:
            ends.append(reached)
            counts.append(count)
    if not ends:
        return float(heights_mm[-1 if upper else 0]), 0.0
    found = sign * np.array(ends)
    weights = np.array(counts) / (1 + ((found - found.max()) / END_TRUST_MM) ** 2) ** 2
    return sign * float((weights * found).sum() / weights.sum()), float(np.ptp(found))


def _crossing(places_mm: Floats, missing_mm: Floats) -> float | None:
    """The first place at which nothing is missing any more; None where the view does not show it."""
    reached = np.flatnonzero(~(missing_mm > 0))
    if not len(reached) or not np.isfinite(missing_mm[0]):
        return None
    first = int(reached[0])
    if first == 0 or not np.isfinite(missing_mm[first]):
        return float(places_mm[first])
    pair = slice(first, first - 2 if first > 1 else None, -1)
    return float(np.interp(0.0, missing_mm[pair], places_mm[pair]))


def continued_profile(heights_mm: Floats, radii_mm: Floats, places_mm: Floats) -> Floats:
    """Radii at places from the base to the rim; near both, what lies just inside is continued in a straight line."""
    profile = np.interp(places_mm, heights_mm, radii_mm)
    for end_mm, inwards in ((places_mm[0], 1.0), (places_mm[-1], -1.0)):
        from_mm = end_mm + inwards * INSET_MM
        near, far = np.interp([from_mm, from_mm + inwards * 2 * INSET_MM], heights_mm, radii_mm)
        slope = np.clip((near - far) / (2 * INSET_MM), -SLOPE_MAX, SLOPE_MAX)
        beyond = inwards * (from_mm - places_mm)
        profile = np.where(beyond > 0, np.maximum(profile, near + slope * beyond), profile)
    return np.maximum(profile, 0.5)
