"""The symmetry axis of a container in its mask: from the ends of its base (paper 3.3), its whole outline or its top."""

from dataclasses import dataclass
from typing import Literal, get_args

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from corsmal.errors import ArgumentError
from corsmal.geometry import Floats

Mask = NDArray[np.bool_]
Points = NDArray[np.int32]

AxisRule = Literal["base", "whole", "top"]
AXIS_RULES: tuple[AxisRule, ...] = get_args(AxisRule)

CONTOUR_PIXELS = cv2.CHAIN_APPROX_NONE
"""Every pixel of a contour, none left out on straight stretches."""

BASE_SLOPE_MAX_DEG = 40.0
"""Edges of the hull that rise more than this from the base's own direction are the container's sides."""

BASE_ROUNDS = 10

STRIPS_PER_SIDE, STRIP_PX_MIN = 50, 2.0
"""Number of strips of the longer side of the outline's box, unless they would be narrower than the second value."""

STEPS_PER_STRIP = 4
WEIGHT_MIN = 0.01
"""Of a strip in the middle; those at the ends have 1."""

COARSE_DEG, FINE_DEG = 3.0, 0.5
UPRIGHT_SHARE = 0.5
"""Share of its agreement that an axis loses when it lies flat: boxes have two axes, and people hold them upright."""


@dataclass(frozen=True)
class Axis:
    """A line in an image.

    Args:
        point: (x, y) on the line, pixels.
        direction: (x, y) of unit length along it, towards the container's upper end; y is negative upwards.

    Raises:
        ArgumentError: a number is not finite, or the direction has another length.
    """

    point: tuple[float, float]
    direction: tuple[float, float]

    def __post_init__(self) -> None:
        if not np.isfinite([*self.point, *self.direction]).all() or abs(np.hypot(*self.direction) - 1) > 1e-6:
            raise ArgumentError(f"an axis needs a finite point and a direction of length 1, got {self}")

    @property
    def tilt_deg(self) -> float:
        """How far the line leans from the vertical, -90..90 degrees; positive where its upper end leans right."""
        x, y = self.direction
        return float(np.degrees(np.arctan2(x, -y)))

    @classmethod
    def leaning(cls, tilt_deg: float, point: ArrayLike) -> "Axis":
        """The axis through a point that leans so far."""
        x, y = np.asarray(point, dtype=np.float64)
        tilt = np.radians(tilt_deg)
        return cls((float(x), float(y)), (float(np.sin(tilt)), float(-np.cos(tilt))))


@dataclass(frozen=True, eq=False)
class Outline:
    """What the contours of a mask say.

    Args:
        points: (n, 2) pixels ``(x, y)`` of the outer contours of all its parts.
        parts: how many parts do not touch each other.
        holes: how many holes the parts have.
    """

    points: Points
    parts: int
    holes: int


def outline(mask: Mask) -> Outline:
    """The outline of a mask (H, W); without points where it is empty."""
    contours, hierarchy = cv2.findContours(np.ascontiguousarray(mask).view(np.uint8), cv2.RETR_CCOMP, CONTOUR_PIXELS)
    if not contours:
        return Outline(np.empty((0, 2), np.int32), 0, 0)
    outer = [contour for contour, links in zip(contours, hierarchy[0], strict=True) if links[3] < 0]
    points = np.concatenate(outer).reshape(-1, 2).astype(np.int32, copy=False)
    return Outline(points, len(outer), len(contours) - len(outer))


def base_ends(points: Points) -> tuple[Floats, Floats] | None:
    """The left and the right end of the base: of the lower edges of the convex hull that are no sides.

    An edge belongs to the base when it rises by less than 40 degrees from the base's direction, which is the image's
    horizontal at first and then that of the segment between the ends found, until it stays. So a base that is an arc,
    or that is tilted, ends where the container's sides begin.

    Returns:
        Two (2,) points; None where outline pixels (n, 2) have no such edge: a line that leans more, or a point.
    """
    hull = cv2.convexHull(points, clockwise=True).reshape(-1, 2).astype(np.float64)  # the base from left to right
    if len(hull) < 2:
        return None
    steps = np.roll(hull, -1, axis=0) - hull
    slopes = np.degrees(np.arctan2(steps[:, 1], steps[:, 0]))
    base_deg, ends = 0.0, None
    for _ in range(BASE_ROUNDS):
        is_base = np.abs((slopes - base_deg + 180) % 360 - 180) < BASE_SLOPE_MAX_DEG
        if not is_base.any():
            return None
        left = hull[is_base & ~np.roll(is_base, 1)][0]
        right = np.roll(hull, -1, axis=0)[is_base & ~np.roll(is_base, -1)][0]
        if ends is not None and np.array_equal(ends, (left, right)):
            break
        ends = left, right
        base_deg = float(np.degrees(np.arctan2(*(right - left)[::-1])))
    return ends


def base_axis(points: Points) -> Axis | None:
    """The perpendicular bisector of the segment between the base's ends (paper 3.3); None where there is no base."""
    ends = base_ends(points)
    if ends is None:
        return None
    left, right = ends
    return Axis.leaning(float(np.degrees(np.arctan2(*(right - left)[::-1]))), (left + right) / 2)


def top_axis(mask: Mask) -> Axis:
    """The vertical through the middle of a mask's topmost row of pixels, as the authors' program has it."""
    top = int(np.argmax(mask.any(axis=1)))
    left, right = np.flatnonzero(mask[top])[[0, -1]]
    return Axis.leaning(0.0, (float(left + (right - left + 1) // 2), float(top)))


def whole_axis(points: Points) -> Axis:
    """The line about which most of an outline, (n, 2) pixels, is symmetric.

    The outline is cut into strips across a direction. The middle between the two outer ends of a strip lies on the
    axis unless something hides one of them, so the axis is where most middles agree. Strips count the more the nearer
    they are to the upper or the lower end, because hands take containers in between. An axis that leans
    loses some of its agreement, so that one that leans by more than about 70 degrees may be missed.
    """
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    strip = _strip_px(points)
    centred = (points - middle)[:: max(1, int(strip / 1.5))]
    tilts = np.arange(COARSE_DEG - 90, 90, COARSE_DEG)
    shares, _ = _best_offsets(centred, tilts, strip)
    best = tilts[np.argmax(shares * (1 - UPRIGHT_SHARE * np.abs(tilts) / 90))]
    tilts = best + np.arange(-COARSE_DEG, COARSE_DEG + FINE_DEG / 2, FINE_DEG)
    shares, offsets = _best_offsets(centred, tilts, strip)
    index = int(np.argmax(shares))
    tilt = float(tilts[index])
    across = np.array([np.cos(np.radians(tilt)), np.sin(np.radians(tilt))])
    return Axis.leaning((tilt + 90) % 180 - 90, middle + offsets[index] * across)


def agreement(points: Points, axis: Axis) -> float:
    """How well an axis fits an outline (n, 2): the share (0..1) of the weighted strips whose middles lie on it."""
    strip = _strip_px(points)
    middles, weights = _strips(points - np.array(axis.point), np.array([axis.tilt_deg]), strip)
    return float(np.sum(weights * np.maximum(0, 1 - (middles / strip) ** 2)) / np.sum(weights))


def _strip_px(points: Points) -> float:
    return max(STRIP_PX_MIN, float(np.ptp(points, axis=0).max()) / STRIPS_PER_SIDE)


def _strips(points: Floats, tilts_deg: Floats, strip_px: float) -> tuple[Floats, Floats]:
    """The middles of the strips across each tilt, pixels, and their weights, 0 for empty ones: (tilts, strips) each."""
    cos, sin = np.cos(np.radians(tilts_deg))[:, None], np.sin(np.radians(tilts_deg))[:, None]
    across = cos * points[:, 0] + sin * points[:, 1]  # (tilts, n)
    along = sin * points[:, 0] - cos * points[:, 1]
    strips = ((along - along.min(axis=1, keepdims=True)) / strip_px).astype(np.intp)
    last = strips.max(axis=1, keepdims=True)
    shape = (len(tilts_deg), int(last.max()) + 1)
    places = (np.arange(shape[0])[:, None] * shape[1] + strips).ravel()
    low, high = np.full(shape, np.inf), np.full(shape, -np.inf)
    np.minimum.at(low.reshape(-1), places, across.ravel())
    np.maximum.at(high.reshape(-1), places, across.ravel())
    is_there = np.isfinite(low)
    middles = np.where(is_there, (low + np.where(is_there, high, 0)) / 2, 0)
    position = 2 * (np.arange(shape[1]) + 0.5) / (last + 1) - 1  # from -1 at the lower to 1 at the upper end
    return middles, np.where(is_there, np.maximum(position**2, WEIGHT_MIN), 0)


def _best_offsets(points: Floats, tilts_deg: Floats, strip_px: float) -> tuple[Floats, Floats]:
    """For each tilt the largest agreement of any offset across the axis, and that offset in pixels."""
    middles, weights = _strips(points, tilts_deg, strip_px)
    step = strip_px / STEPS_PER_STRIP
    start = middles.min() - strip_px
    bins = np.rint((middles - start) / step).astype(np.intp)
    width = int(bins.max()) + STEPS_PER_STRIP + 1
    places = np.arange(len(middles))[:, None] * width + bins
    counts = np.bincount(places.ravel(), weights.ravel(), minlength=len(middles) * width).reshape(-1, width)
    window = 1 - (np.arange(1 - STEPS_PER_STRIP, STEPS_PER_STRIP) / STEPS_PER_STRIP) ** 2
    votes = np.asarray(cv2.filter2D(counts, -1, window[None], borderType=cv2.BORDER_CONSTANT))
    best = votes.argmax(axis=1)
    return votes[np.arange(len(votes)), best] / weights.sum(axis=1), start + best * step
