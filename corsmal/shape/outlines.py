"""One view's mask seen in the plane through a container's axis: its outline in millimetres."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.geometry import Camera, Floats

Mask = NDArray[np.bool_]

MARGIN_MM = 6.0
BORDER_PX = 1.5
"""An outline so near to the image's border is where the picture ends, not where the container does."""
TONGUE_SHARE = 0.3
"""What is thinner than this share of the square root of a mask's pixels may be a tongue between fingers."""
THICK_MIN = 0.9
"""A mask of which less remains without its thin parts shows a glass on a stem, or too little."""
SPECK_SHARE = 0.1
"""Pieces of a mask that are smaller, against its largest, are specks; a hand may part a container in larger ones."""


def across(direction: Floats) -> Floats:
    """(..., 2, 3) unit vectors square to directions (..., 3), unit vectors too, and to each other."""
    x, y, z = np.moveaxis(direction, -1, 0)
    level = np.sqrt(y * y + z * z)  # the first one is the x axis less its part along the direction
    zero = np.zeros_like(level)
    rows = [level, -x * y / level, -x * z / level, zero, z / level, -y / level]
    return np.stack(rows, axis=-1).reshape(*direction.shape[:-1], 2, 3)


@dataclass(frozen=True, eq=False)
class Axis:
    """A container's axis.

    Args:
        point_m: (3,) a point on it, metres; heights along the axis are counted from there.
        direction: (3,) unit vector, upwards.
    """

    point_m: Floats
    direction: Floats

    @property
    def across(self) -> Floats:
        """(2, 3) unit vectors square to the axis and to each other; those of x and y where the axis is vertical."""
        return across(self.direction)

    def moved(self, shift_mm: Floats, slope: Floats) -> "Axis":
        """The axis after a shift and a change of slope (mm of shift per mm of height), both along ``across``."""
        direction = self.direction + slope @ self.across
        return Axis(self.point_m + shift_mm @ self.across / 1000, direction / np.linalg.norm(direction))


class FacingView:
    """A mask in the plane that holds the axis and faces the camera.

    Args:
        camera: of the view.
        mask: (H, W) bool, not empty.
        axis: of the container.

    Attributes:
        sideways: (3,) unit vector of the plane, square to the axis.
        distance_mm: from the camera to the axis.
        camera_mm: how high the camera stands along the axis.
        pixel_mm: what a pixel spans there.
        extent_mm: (2, 2) lowest and highest sideways and upward place of the mask.
    """

    def __init__(self, camera: Camera, mask: Mask, axis: Axis) -> None:
        towards = camera.centre_m - axis.point_m
        height = float(towards @ axis.direction)
        level = towards - height * axis.direction
        distance = float(np.linalg.norm(level))
        self.sideways = np.cross(axis.direction, level / distance)
        self.distance_mm, self.camera_mm = 1000 * distance, 1000 * height
        self.pixel_mm = self.distance_mm / float(camera.intrinsic[0, 0])
        self._size = camera.size
        plane = np.column_stack([self.sideways / 1000, axis.direction / 1000, axis.point_m])
        self._pixels_from_mm = camera.projection[:, :3] @ plane + np.outer(camera.projection[:, 3], (0, 0, 1))
        self._mask, (left, top, width, height_px) = mask, cv2.boundingRect(mask.view(np.uint8))
        self._box = left, top, width, height_px
        corners = np.array([(x, y, 1.0) for x in (left, left + width) for y in (top, top + height_px)])
        corners = corners @ np.linalg.inv(self._pixels_from_mm).T
        with np.errstate(divide="ignore", invalid="ignore"):
            corners = corners[:, :2] / corners[:, 2:]
        self.extent_mm = np.array([corners.min(axis=0) - MARGIN_MM, corners.max(axis=0) + MARGIN_MM])

    def unroll(self, low_mm: float, rows: int) -> None:
        """Look at the plane in rows of one millimetre from a height on: ``radii`` and ``reach_mm`` refer to them."""
        first = float(np.floor(self.extent_mm[0, 0]))
        columns = int(self.extent_mm[1, 0] - first) + 1
        self._first, self._low = first, low_mm
        left, top, width, height = self._box
        x, y = max(0, left - 3), max(0, top - 3)
        window = self._mask[y : top + height + 3, x : left + width + 3].astype(np.float32)
        pixels = np.array([[1, 0, -x], [0, 1, -y], [0, 0, 1]]) @ self._pixels_from_mm
        pixels = pixels @ np.array([[1, 0, first], [0, 1, low_mm], [0, 0, 1]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        self._plane: Floats = cv2.warpPerspective(window, pixels, (columns, rows), flags=flags).astype(np.float64)

    def radii(self) -> Floats:
        """(2, rows) distance of the outline from the axis on either side, mm, NaN where it is not seen.

        A line of sight touches a solid of revolution a little before the plane: the radius is that of the circle that
        it touches.
        """
        low, high = (self._first + ends for ends in _ends(self._plane))
        heights = self._low + np.arange(len(low), dtype=np.float64)
        found = np.stack([np.where(self._in_picture(side, heights), side, np.nan) for side in (high, low)])
        radii: Floats = self.distance_mm * np.sin(np.arctan(found / self.distance_mm))
        return radii * np.array([[1.0], [-1.0]])

    def reach_mm(self, across_mm: Floats, *, upper: bool) -> Floats:
        """Height at which the mask ends above or below places across the axis, NaN where that is not seen."""
        places = self._first + np.arange(self._plane.shape[1], dtype=np.float64)
        ends = self._low + _ends(self._plane.T)[1 if upper else 0]
        ends = np.where(self._in_picture(places, ends), ends, np.nan)
        nearest = np.rint(across_mm - self._first).astype(np.intp)
        inside = (nearest >= 0) & (nearest < len(ends))
        return np.where(inside, ends[np.clip(nearest, 0, len(ends) - 1)], np.nan)

    def overhang_mm(self, heights_mm: Floats, radii_mm: Floats, *, upper: bool) -> Floats:
        """How far beyond its own height a circle's silhouette reaches in the middle, mm, negative downwards."""
        above = heights_mm - self.camera_mm
        ways = [above * self.distance_mm / (self.distance_mm + sign * radii_mm) - above for sign in (1, -1)]
        return np.maximum(*ways) if upper else np.minimum(*ways)

    def _in_picture(self, across_mm: Floats, heights_mm: Floats) -> NDArray[np.bool_]:
        points = np.column_stack([across_mm, heights_mm, np.ones(len(across_mm))]) @ self._pixels_from_mm.T
        with np.errstate(invalid="ignore"):
            pixels = points[:, :2] / points[:, 2:]
            last = np.array(self._size) - 1 - BORDER_PX
            inside: NDArray[np.bool_] = np.all((pixels >= BORDER_PX) & (pixels <= last), axis=1)
        return inside


def without_specks(mask: Mask) -> Mask:
    """A mask without the pieces that are small against its largest."""
    left, top, width, height = cv2.boundingRect(mask.view(np.uint8))
    window = np.s_[top : top + height, left : left + width]
    crop = np.ascontiguousarray(mask[window], np.uint8)
    pieces, labels, statistics, _ = cv2.connectedComponentsWithStats(crop, connectivity=8)
    if pieces <= 2:
        return mask
    areas = statistics[1:, cv2.CC_STAT_AREA]
    kept = np.zeros_like(mask)
    kept[window] = np.concatenate([[False], areas >= SPECK_SHARE * areas.max()])[labels]
    return kept


def whole_mask(mask: Mask) -> Mask:
    """About what a mask would be without a hand: no tongues between fingers, and bites at its sides filled in.

    That is the convex hull of what remains of the mask without its thin parts. It has the container's axis, not its
    outline. A mask with much that is thin, such as a glass on its stem, stays as it is.
    """
    left, top, width, height = cv2.boundingRect(mask.view(np.uint8))
    crop = np.pad(mask[top : top + height, left : left + width], 1).astype(np.uint8)
    side = max(3, round(TONGUE_SHARE * float(np.sqrt(np.count_nonzero(crop)))))
    thick = cv2.morphologyEx(crop, cv2.MORPH_OPEN, np.ones((side, side), np.uint8))
    if np.count_nonzero(thick) < THICK_MIN * np.count_nonzero(crop):
        return mask
    contours, _ = cv2.findContours(thick, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE, offset=(left - 1, top - 1))
    filled = np.zeros(mask.shape, dtype=np.uint8)
    cv2.fillConvexPoly(filled, cv2.convexHull(np.concatenate(contours)), 1)
    return filled.view(np.bool_)


def _ends(plane: Floats) -> tuple[Floats, Floats]:
    """Where each row first and last crosses one half, in columns, between them too; NaN where it never does."""
    on = plane >= 0.5
    rows, last_column = np.arange(len(plane)), plane.shape[1] - 1
    seen = on.any(axis=1)
    ends = []
    for column, step in ((on.argmax(axis=1), -1), (last_column - on[:, ::-1].argmax(axis=1), 1)):
        inside, outside = plane[rows, column], plane[rows, np.clip(column + step, 0, last_column)]
        share = np.where(inside > outside, (inside - 0.5) / np.maximum(inside - outside, 1e-6), 0.5)
        ends.append(np.where(seen, column + step * share, np.nan))
    return ends[0], ends[1]
