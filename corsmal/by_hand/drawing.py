"""Tools that change a mask: functions of arrays, in pixels of the picture."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from corsmal.errors import ArgumentError

Mask = NDArray[np.bool_]
Points = NDArray[np.float64]

OUTSIDE = "Nothing was drawn: all of it lies outside the picture."
BITS = 4
"""Of a pixel's parts that OpenCV draws with: 1/16 pixel."""

RADIUS_MAX_PX, POINTS_MAX, REACH_MAX_PX = 400.0, 20_000, 100_000.0


@dataclass(frozen=True, eq=False)
class Drawn:
    """A mask after a tool.

    Args:
        mask: (H, W) bool, a new array.
        said: a sentence where the tool did nothing; else empty.
    """

    mask: Mask
    said: str = ""


def brush(mask: Mask, points: ArrayLike, *, radius_px: float) -> Drawn:
    """Add a round brush's stroke through (n, 2) points (x, y), n ≥ 1.

    Raises:
        ArgumentError: the mask, the points or the radius cannot be used.
    """
    stroke = _stroke(mask, points, radius_px)
    return Drawn(mask | stroke) if stroke.any() else Drawn(mask.copy(), OUTSIDE)


def eraser(mask: Mask, points: ArrayLike, *, radius_px: float) -> Drawn:
    """Remove what a round brush's stroke covers; arguments as for ``brush``."""
    stroke = _stroke(mask, points, radius_px)
    return Drawn(mask & ~stroke) if stroke.any() else Drawn(mask.copy(), OUTSIDE)


def polygon(mask: Mask, points: ArrayLike) -> Drawn:
    """Replace the mask by the inside of a polygon, which may leave the picture.

    Args:
        mask: (H, W) bool.
        points: (n, 2) corners (x, y), n ≥ 3, in pixels; (0.5, 0.5) is the middle of the first one.

    Raises:
        ArgumentError: the mask or the points cannot be used.
    """
    corners = _points(mask, points, at_least=3)
    inside = np.zeros(mask.shape, dtype=np.uint8)
    cv2.fillPoly(inside, [_fixed(corners)], 1, shift=BITS)
    if not inside.any():
        return Drawn(mask.copy(), OUTSIDE)
    return Drawn(inside.view(np.bool_))


def fill(mask: Mask, point: Sequence[float]) -> Drawn:
    """Fill the hole of a mask that holds a point (x, y); an area that is open to the picture's border stays as it is.

    Raises:
        ArgumentError: the mask or the point cannot be used.
    """
    [(x, y)] = np.floor(_points(mask, [point], at_least=1)).astype(int)
    if not (0 <= y < mask.shape[0] and 0 <= x < mask.shape[1]):
        return Drawn(mask.copy(), OUTSIDE)
    if mask[y, x]:
        return Drawn(mask.copy(), "Nothing was filled: this place is in the mask already.")
    _, areas = cv2.connectedComponents((~mask).view(np.uint8), connectivity=4)
    hole = areas == areas[y, x]
    if hole[0].any() or hole[-1].any() or hole[:, 0].any() or hole[:, -1].any():
        return Drawn(mask.copy(), "Nothing was filled: the area around this place is open to the picture's border.")
    return Drawn(mask | hole)


def stroke_mask(shape: tuple[int, int], points: Points, *, radius_px: float) -> Mask:
    """The (H, W) pixels whose middle is within a radius of the line through (n, 2) points."""
    painted = np.zeros(shape, dtype=np.uint8)
    fixed = _fixed(points)
    width = max(1, round(2 * radius_px))
    if width > 1:
        for x, y in fixed:
            cv2.circle(painted, (int(x), int(y)), round(radius_px * 2**BITS), 1, -1, shift=BITS)
    if len(fixed) == 1 and width == 1:
        fixed = np.repeat(fixed, 2, axis=0)
    cv2.polylines(painted, [fixed], isClosed=False, color=1, thickness=width, shift=BITS)
    return painted.view(np.bool_)


def _stroke(mask: Mask, points: ArrayLike, radius_px: float) -> Mask:
    radius_px = float(numbers(radius_px, name="radius_px", dimensions=0))
    if not 0 < radius_px <= RADIUS_MAX_PX:
        raise ArgumentError(f"radius_px must lie between 0 and {RADIUS_MAX_PX:g}, got {radius_px:g}")
    found = _points(mask, points, at_least=1)
    low, high = found.min(axis=0) - radius_px, found.max(axis=0) + radius_px
    if (high < 0).any() or (low > (mask.shape[1], mask.shape[0])).any():
        return np.zeros(mask.shape, dtype=bool)
    return stroke_mask(mask.shape[:2], found, radius_px=radius_px)


def _fixed(points: Points) -> NDArray[np.int32]:
    """Points as OpenCV draws them: in parts of a pixel, (0, 0) being the middle of the first one."""
    return np.rint((points - 0.5) * 2**BITS).astype(np.int32)


def _points(mask: Mask, points: ArrayLike, *, at_least: int) -> Points:
    if mask.ndim != 2 or mask.dtype != np.bool_:
        raise ArgumentError(f"mask must be (H, W) bool, got {mask.shape} of {mask.dtype}")
    found = numbers(points, name="points", dimensions=2)
    if found.shape[1] != 2 or not at_least <= len(found) <= POINTS_MAX:
        raise ArgumentError(f"points must be (n, 2) with n from {at_least} to {POINTS_MAX}, got {found.shape}")
    if np.abs(found).max() > REACH_MAX_PX:
        raise ArgumentError(f"points must be within {REACH_MAX_PX:g} px")
    return found


def numbers(values: ArrayLike, *, name: str, dimensions: int) -> NDArray[np.float64]:
    """Finite numbers as an array of so many dimensions.

    Raises:
        ArgumentError: they are anything else, such as an integer beyond all floats; the text begins with ``name``.
    """
    try:
        found = np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise ArgumentError(f"{name} must be numbers: {error}") from error
    if found.ndim != dimensions or not np.isfinite(found).all():
        expected = ("a finite number", "finite numbers in a row", "finite points (x, y)")[dimensions]
        raise ArgumentError(f"{name} must be {expected}, got an array of shape {found.shape}")
    return found
