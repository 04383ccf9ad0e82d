"""A solid of revolution from the outlines of masks, with an axis that may lean and hands that may hide a side.

In each view the mask's outline gives two radii at each height, left and right of the axis. The container is round and
rigid, and what hides it only takes from a mask: so the radii that agree, and lie farthest out, are believed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from corsmal.geometry import Camera, Floats
from corsmal.shape.outlines import Axis, FacingView, Mask, whole_mask
from corsmal.shape.profiles import smooth_profile
from corsmal.shape.records import Hull

ROUNDS = 3
"""How often the outlines are read again, about a better axis."""

TRUST_MM = 3.0
"""A radius so much smaller than what the others agree on counts a quarter; one that is larger, at half as much more."""
OUTWARD = 1.5
FIRST_TRUST, REWEIGHTINGS = 5.0, 10
"""At first so much more is forgiven, then less and less: a start with little trust would stay where it began."""
PIXELS = 3.0
"""A view whose sides are this many of its pixels off what all views say together counts half as much as one without
error: it is blurred, or its mask is cut or too wide. Fewer pixels would let a single view outdo the others."""
FIRST_QUANTILE = 0.75
"""Of the sides at a height, small to large: what hides a side makes it smaller, a wrong mask may make it larger."""

TILT_WEIGHT = 80.0
"""Rows of an outline err together: this many mm² of error between independent ones, against the expected tilt."""

INSET_MM = 4.0
"""Within a pixel or two of its ends an outline is rounded by the mask's resolution: the ends are read from inside."""
SLOPE_MAX = 0.3
"""Walls that open faster than this are not continued to the ends."""
MIDDLE_SHARE = 0.6
"""Ends are looked for where the silhouette of a circle is nearly flat."""
END_TRUST_MM = 5.0
"""What hides an end only takes from a mask: of the views' ends the outermost counts, and those that are near to it."""
COMMON_MIN = 0.25
"""Views of one container show at least this share of the least seen stretch of the axis together."""
HEIGHT_MIN_MM, SIZE_MAX_MM = 15.0, 400.0
"""What a hand takes is larger and smaller than that; masks of different objects meet where they look larger."""
STEEPEST = 0.95
"""Sine of the steepest angle at which a camera may look down on a container whose outline it is to show."""


def fit_revolution(
    cameras: Sequence[Camera], masks: Sequence[Mask], axis: Axis, *, tilt_deg: float, circumferences: int
) -> Hull:
    """Fit a solid of revolution to the outlines of masks, see ``fit_outlines``; the search starts at ``axis``.

    With a ``tilt_deg`` of 0 the axis keeps its direction. Circumferences are equally spaced from the base to the rim.

    Returns:
        The hull; a failed one, with a reason, where the masks show too little.
    """
    for repetition in range(ROUNDS):
        if any(_steepness(camera, axis) > STEEPEST for camera in cameras):
            return Hull.failed("a camera looks along the container's axis", centroid_m=axis.point_m)
        shown = masks if repetition else [whole_mask(mask) for mask in masks]
        views = [FacingView(camera, mask, axis) for camera, mask in zip(cameras, shown, strict=True)]
        extents = np.array([view.extent_mm for view in views])
        low_mm, high_mm = extents[:, 0].min(axis=0), extents[:, 1].max(axis=0)
        if not (high_mm - low_mm < SIZE_MAX_MM).all():
            return Hull.failed(
                "the masks meet in nothing of a container's size: they may show different objects",
                centroid_m=axis.point_m,
            )
        heights_mm = np.arange(np.floor(low_mm[1]), high_mm[1])
        for view in views:
            view.unroll(heights_mm[0], len(heights_mm))
        sides = np.array([view.radii() for view in views])
        rows = np.isfinite(sides).any(axis=1)
        if rows.all(axis=0).sum() < COMMON_MIN * rows.sum(axis=1).min():
            return Hull.failed(
                "the views show different heights of the axis: they may show different objects", centroid_m=axis.point_m
            )
        agreed = _agree(views, sides, heights_mm, axis, tilt_deg=tilt_deg)
        if repetition < ROUNDS - 1:
            axis = axis.moved(agreed.shift_mm, agreed.slope)
    smooth_mm = smooth_profile(agreed.radii_mm, agreed.weights.sum(axis=(0, 1)))
    seen = np.isfinite(smooth_mm)
    if seen.sum() < HEIGHT_MIN_MM:
        return Hull.failed("the masks show too little of the container", centroid_m=axis.point_m)
    heights_mm, radii_mm = heights_mm[seen], smooth_mm[seen]
    ends = [_end(views, agreed.trust, heights_mm, radii_mm, upper=upper) for upper in (False, True)]
    (base_mm, _), (rim_mm, _) = ends
    if not rim_mm - base_mm > HEIGHT_MIN_MM:
        return Hull.failed("the masks show no more than a rim or a base", centroid_m=axis.point_m)
    places_mm = np.linspace(base_mm, rim_mm, circumferences)
    profile_mm = _profile(heights_mm, radii_mm, places_mm)
    return Hull(
        places_mm + 1000 * axis.point_m[2],
        profile_mm,
        np.ones(circumferences, dtype=bool),
        axis.point_m,
        direction=axis.direction,
        view_weights=agreed.trust,
        evidence=_evidence(agreed, smooth_mm, views, ends),
    )


def _evidence(
    agreed: "_Agreed", radii_mm: Floats, views: Sequence[FacingView], ends: Sequence[tuple[float, float]]
) -> dict[str, float]:
    """What says how good the fit is, see ``corsmal.shape.quality``; ``ends``: heights and spreads."""
    radius_mm = max(float(np.nanmean(radii_mm)), 1.0)
    bent = np.abs(agreed.radii_mm - radii_mm)
    (base_mm, base_spread_mm), (rim_mm, rim_spread_mm) = ends
    return {
        "bent": float(bent[np.isfinite(bent)].mean()) / radius_mm,
        "ends": (base_spread_mm + rim_spread_mm) / max(rim_mm - base_mm, 1.0),
        "coarse": float(np.mean([view.pixel_mm for view in views])) / radius_mm,
    }


def _steepness(camera: Camera, axis: Axis) -> float:
    towards = camera.centre_m - axis.point_m
    return abs(float(towards @ axis.direction)) / max(float(np.linalg.norm(towards)), 1e-9)


@dataclass(frozen=True, eq=False)
class _Agreed:
    """What the sides of the views agree on.

    Args:
        shift_mm: (2,) of the axis.
        slope: (2,) of the axis.
        radii_mm: (H,) NaN where nothing is seen.
        weights: (V, 2, H) how much each side counts at each height.
        trust: (V,) how much each view counts, at most 1.
    """

    shift_mm: Floats
    slope: Floats
    radii_mm: Floats
    weights: Floats
    trust: Floats


def _agree(views: Sequence[FacingView], sides: Floats, heights_mm: Floats, axis: Axis, *, tilt_deg: float) -> "_Agreed":
    """Shift and slope of the axis and the radius at each height that most sides of most views agree on.

    Every side of every view says ``radius ± (shift + slope · height) along its sideways``. Radii are eliminated per
    height; the rest is a least-squares problem whose weights are found again and again, first with much tolerance.

    Args:
        views: the V views.
        sides: (V, 2, H) their radii on either side, mm, NaN where they are not seen.
        heights_mm: (H,).
        axis: that the radii are counted from.
        tilt_deg: how far it is expected to lean.
    """
    seen = np.isfinite(sides)
    sides = np.where(seen, sides, 0.0)
    along = np.array([[[1.0], [-1.0]] * (axis.across @ view.sideways) for view in views])  # (V, sides, across)
    pixels_mm = PIXELS * np.array([view.pixel_mm for view in views])
    design = along[:, :, None].repeat(len(heights_mm), 2)  # (V, 2, H, unknowns)
    prior = np.diag([1e-6, 1e-6])
    if tilt_deg > 0:
        design = np.concatenate([design, design * heights_mm[:, None]], axis=3)
        prior = np.diag([1e-6, 1e-6, *[TILT_WEIGHT / np.tan(np.radians(tilt_deg)) ** 2] * 2])
    unknowns = np.zeros(len(prior))
    radii_mm = _upper(sides, seen)
    for tolerance in TRUST_MM * np.geomspace(FIRST_TRUST, 1.0, REWEIGHTINGS):
        corrected = sides - design @ unknowns
        error = corrected - radii_mm
        trust = _trust(error, seen, pixels_mm)
        weights = (
            trust[:, None, None] * seen / (1 + (error / np.where(error < 0, tolerance, OUTWARD * tolerance)) ** 2) ** 2
        )
        total = np.maximum(weights.sum(axis=(0, 1)), 1e-9)
        radii_mm = (weights * corrected).sum(axis=(0, 1)) / total
        centred = design - (weights[..., None] * design).sum(axis=(0, 1)) / total[:, None]
        measured = sides - (weights * sides).sum(axis=(0, 1)) / total
        flat = centred.reshape(-1, len(unknowns))
        weighted = flat * weights.reshape(-1, 1)
        unknowns = np.linalg.solve(weighted.T @ flat + prior, weighted.T @ measured.ravel())
    shift, slope = unknowns[:2], unknowns[2:] if tilt_deg > 0 else np.zeros(2)
    radii_mm = np.where(seen.any(axis=(0, 1)), radii_mm, np.nan)
    return _Agreed(shift, slope, radii_mm, weights, trust)


def _trust(error_mm: Floats, seen: NDArray[np.bool_], pixels_mm: Floats) -> Floats:
    """How much each view counts, by the size of its pixels and its usual error: (V,), 1 for the best."""
    usual = [np.median(np.abs(error[mask])) if mask.any() else 0.0 for error, mask in zip(error_mm, seen, strict=True)]
    trust: Floats = 1 / (np.square(usual) + pixels_mm**2)
    return trust / trust.max()


def _upper(sides: Floats, seen: NDArray[np.bool_]) -> Floats:
    """Of each height's sides, the one at three quarters from the smallest to the largest."""
    ordered = np.sort(np.where(seen, sides, np.inf).reshape(-1, sides.shape[2]), axis=0)
    counts = seen.sum(axis=(0, 1))
    places = np.rint(FIRST_QUANTILE * np.maximum(counts - 1, 0)).astype(np.intp)
    found = ordered[places, np.arange(len(places))]
    return np.where(counts > 0, found, 0.0)


def _end(
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
        reach = view.reach_mm((radii[:, None] * shares).ravel(), upper=upper).reshape(len(places), -1)
        expected = places[:, None] + view.overhang_mm(places, radii, upper=upper)[:, None] * np.sqrt(1 - shares**2)
        missing = np.sort(sign * (reach - expected), axis=1)  # NaN comes last
        seen = np.isfinite(missing).sum(axis=1)
        missing_mm = missing[np.arange(len(places)), np.maximum(seen - 1, 0) // 2]
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


def _profile(heights_mm: Floats, radii_mm: Floats, places_mm: Floats) -> Floats:
    """Radii at places from the base to the rim; near both, what lies just inside is continued in a straight line."""
    profile = np.interp(places_mm, heights_mm, radii_mm)
    for end_mm, inwards in ((places_mm[0], 1.0), (places_mm[-1], -1.0)):
        from_mm = end_mm + inwards * INSET_MM
        near, far = np.interp([from_mm, from_mm + inwards * 2 * INSET_MM], heights_mm, radii_mm)
        slope = np.clip((near - far) / (2 * INSET_MM), -SLOPE_MAX, SLOPE_MAX)
        beyond = inwards * (from_mm - places_mm)
        profile = np.where(beyond > 0, np.maximum(profile, near + slope * beyond), profile)
    return np.maximum(profile, 0.5)
