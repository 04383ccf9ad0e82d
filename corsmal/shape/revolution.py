"""A solid of revolution from the outlines of masks, with an axis that may lean and hands that may hide a side.

In each view the mask's outline gives two radii at each height, left and right of the axis. The container is round and
rigid, and what hides it only takes from a mask: so the radii that agree, and lie farthest out, are believed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from corsmal.geometry import Camera, Floats
from corsmal.shape.agreed import PATIENCE, Agreed, agree, misfit
from corsmal.shape.cropped import Cropped
from corsmal.shape.ends import continued_profile, end_of
from corsmal.shape.outlines import Axis, FacingView
from corsmal.shape.records import Hull

WHOLE_ROUNDS = 2
"""So often the axis is looked for in masks without what a hand adds and takes, before they are read as they are."""
LAST_PATIENCE = 1.7
"""The axis is good by then: what lies far from what the whole masks show is not believed again."""

COMMON_MIN = 0.25
"""Views of one container show at least this share of the least seen stretch of the axis together."""
HEIGHT_MIN_MM, SIZE_MAX_MM = 15.0, 400.0
"""What a hand takes is larger and smaller than that; masks of different objects meet where they look larger."""
STEEPEST = 0.95
"""Sine of the steepest angle at which a camera may look down on a container whose outline it is to show."""


def fit_revolution(
    cameras: Sequence[Camera], masks: Sequence[Cropped], axis: Axis, *, tilt_deg: float, circumferences: int
) -> Hull:
    """Fit a solid of revolution to the outlines of masks, see ``fit_outlines``; the search starts at ``axis``.

    It is fitted twice, with a radius of its own at each height and with a profile that is straight but for corners, and
    the one with the smaller misfit is taken. With a ``tilt_deg`` of 0 the axis keeps its direction. Circumferences are
    equally spaced from the base to the rim.

    Returns:
        The hull; a failed one, with a reason, where the masks show too little.
    """
    whole = [mask.whole for mask in masks]
    first = _look(cameras, whole, axis)
    if isinstance(first, str):
        return Hull.failed(first, centroid_m=axis.point_m)
    found = [
        _fit(
            cameras,
            masks,
            whole,
            axis,
            first,
            tilt_deg=tilt_deg,
            circumferences=circumferences,
            is_straight=is_straight,
        )
        for is_straight in (False, True)
    ]
    fitted = [hull for hull in found if hull.ok]
    return min(fitted, key=lambda hull: hull.evidence["misfit"]) if fitted else found[0]


def _fit(
    cameras: Sequence[Camera],
    masks: Sequence[Cropped],
    whole: Sequence[Cropped],
    axis: Axis,
    first: "_Seen",
    *,
    tilt_deg: float,
    circumferences: int,
    is_straight: bool,
) -> Hull:
    """The hull of one kind of profile: the axis from the whole masks, then the profile from the masks as they are.

    ``first`` is what the whole masks show about ``axis``, whatever the profile.
    """
    profile: tuple[Floats, Floats] | None = None
    for repetition in range(WHOLE_ROUNDS):
        seen = _look(cameras, whole, axis) if repetition else first
        if isinstance(seen, str):
            return Hull.failed(seen, centroid_m=axis.point_m)
        agreed = agree(
            seen.views, seen.sides, seen.heights_mm, axis, tilt_deg=tilt_deg, is_straight=is_straight, patience=PATIENCE
        )
        shown = np.isfinite(agreed.profile_mm)
        profile = seen.heights_mm[shown], agreed.profile_mm[shown]
        axis = axis.moved(agreed.shift_mm, agreed.slope)
    seen = _look(cameras, masks, axis)
    if isinstance(seen, str):
        return Hull.failed(seen, centroid_m=axis.point_m)
    agreed = agree(
        seen.views,
        seen.sides,
        seen.heights_mm,
        axis,
        tilt_deg=tilt_deg,
        is_straight=is_straight,
        patience=LAST_PATIENCE,
        first_mm=None if profile is None or is_straight else np.interp(seen.heights_mm, *profile),
    )
    return _hull(seen, agreed, axis, circumferences)


@dataclass(frozen=True, eq=False)
class _Seen:
    """What views show about an axis.

    Args:
        views: the V views.
        sides: (V, 2, H) radii on either side, mm, NaN where they are not seen.
        heights_mm: (H,) one millimetre apart.
    """

    views: Sequence[FacingView]
    sides: Floats
    heights_mm: Floats


def _look(cameras: Sequence[Camera], masks: Sequence[Cropped], axis: Axis) -> _Seen | str:
    """The outlines of masks about an axis, or why they are of no use."""
    if any(_steepness(camera, axis) > STEEPEST for camera in cameras):
        return "a camera looks along the container's axis"
    views = [FacingView(camera, mask, axis) for camera, mask in zip(cameras, masks, strict=True)]
    extents = np.array([view.extent_mm for view in views])
    low_mm, high_mm = extents[:, 0].min(axis=0), extents[:, 1].max(axis=0)
    if not (high_mm - low_mm < SIZE_MAX_MM).all():
        return "the masks meet in nothing of a container's size: they may show different objects"
    heights_mm = np.arange(np.floor(low_mm[1]), high_mm[1])
    for view in views:
        view.unroll(heights_mm[0], len(heights_mm))
    sides = np.array([view.radii() for view in views])
    rows = np.isfinite(sides).any(axis=1)
    if rows.all(axis=0).sum() < COMMON_MIN * rows.sum(axis=1).min():
        return "the views show different heights of the axis: they may show different objects"
    if rows.any(axis=0).sum() < HEIGHT_MIN_MM:
        return "the masks show too little of the container"
    return _Seen(views, sides, heights_mm)


def _steepness(camera: Camera, axis: Axis) -> float:
    towards = camera.centre_m - axis.point_m
    return abs(float(towards @ axis.direction)) / max(float(np.linalg.norm(towards)), 1e-9)


def _hull(seen: _Seen, agreed: Agreed, axis: Axis, circumferences: int) -> Hull:
    """The hull between base and rim, with its evidence, see ``corsmal.shape.quality``."""
    shown = np.isfinite(agreed.profile_mm)
    heights_mm, radii_mm = seen.heights_mm[shown], agreed.profile_mm[shown]
    (base_mm, base_spread_mm), (rim_mm, rim_spread_mm) = (
        end_of(seen.views, agreed.trust, heights_mm, radii_mm, upper=upper) for upper in (False, True)
    )
    if not rim_mm - base_mm > HEIGHT_MIN_MM:
        return Hull.failed("the masks show no more than a rim or a base", centroid_m=axis.point_m)
    places_mm = np.linspace(base_mm, rim_mm, circumferences)
    profile_mm = continued_profile(heights_mm, radii_mm, places_mm)
    pixels_mm = np.array([view.pixel_mm for view in seen.views])
    evidence = {
        "misfit": misfit(seen.sides, seen.heights_mm, (places_mm, profile_mm), pixels_mm),
        "ends": (base_spread_mm + rim_spread_mm) / (rim_mm - base_mm),
        "coarse": float(pixels_mm.mean()) / max(float(radii_mm.mean()), 1.0),
    }
    return Hull(
        places_mm + 1000 * axis.point_m[2],
        profile_mm,
        np.ones(circumferences, dtype=bool),
        axis.point_m,
        direction=axis.direction,
        view_weights=agreed.trust,
        evidence=evidence,
    )
