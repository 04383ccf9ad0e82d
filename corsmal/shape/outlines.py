"""One view's mask seen in the plane through a container's axis: its outline in millimetres."""

import math
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from corsmal.geometry import Camera, Floats
from corsmal.shape.cropped import Cropped

MARGIN_MM = 6.0
BORDER_PX = 1.5
"""An outline so near to the image's border is where the picture ends, not where the container does."""


@dataclass(frozen=True, eq=False)
class Axis:
    """A container's axis.

    Args:
        point_m: (3,) a point on it, metres; heights along the axis are counted from there.
        direction: (3,) unit vector, upwards.
    """

    point_m: Floats
    direction: Floats

    @cached_property
    def across(self) -> Floats:
        """(2, 3) unit vectors square to the axis and to each other; those of x and y where the axis is vertical."""
        x, y, z = self.direction.tolist()
        level = math.sqrt(y * y + z * z)  # the first one is the x axis less its part along the direction
        return np.array([[level, -x * y / level, -x * z / level], [0.0, z / level, -y / level]])

    def moved(self, shift_mm: Floats, slope: Floats) -> "Axis":
        """The axis after a shift and a change of slope (mm of shift per mm of height), both along ``across``."""
        direction = self.direction + slope @ self.across
        return Axis(self.point_m + shift_mm @ self.across / 1000, direction / np.linalg.norm(direction))


class FacingView:
    """A mask in the plane that holds the axis and faces the camera.

    Args:
        camera: of the view.
        mask: of the container, not empty.
        axis: of the container.

    Attributes:
        sideways: (3,) unit vector of the plane, square to the axis.
        distance_mm: from the camera to the axis.
        camera_mm: how high the camera stands along the axis.
        pixel_mm: what a pixel spans there.
        extent_mm: (2, 2) lowest and highest sideways and upward place of the mask.
    """

    def __init__(self, camera: Camera, mask: Cropped, axis: Axis) -> None:
        towards = camera.centre_m - axis.point_m
        height = float(towards @ axis.direction)
        level = towards - height * axis.direction
        distance = float(np.linalg.norm(level))
        self.sideways = _crossed(axis.direction, level / distance)
        self.distance_mm, self.camera_mm = 1000 * distance, 1000 * height
        self.pixel_mm = self.distance_mm / float(camera.intrinsic[0, 0])
        self._last = np.array(camera.size) - 1 - BORDER_PX
        plane = np.array([self.sideways / 1000, axis.direction / 1000, axis.point_m]).T
        self._pixels_from_mm = camera.projection[:, :3] @ plane
        self._pixels_from_mm[:, 2] += camera.projection[:, 3]
        self._mask, (height_px, width) = mask, mask.pixels.shape
        left, top, right, bottom = mask.left, mask.top, mask.left + width, mask.top + height_px
        corners = np.array([(left, top, 1.0), (left, bottom, 1.0), (right, top, 1.0), (right, bottom, 1.0)])
        corners = corners @ np.linalg.inv(self._pixels_from_mm).T
        with np.errstate(divide="ignore", invalid="ignore"):
            corners = corners[:, :2] / corners[:, 2:]
        self.extent_mm = np.array([corners.min(axis=0) - MARGIN_MM, corners.max(axis=0) + MARGIN_MM])

    def unroll(self, low_mm: float, rows: int) -> None:
        """Look at the plane in rows of one millimetre from a height on: ``radii`` and ``reach_mm`` refer to them."""
        first = float(np.floor(self.extent_mm[0, 0]))
        columns = int(self.extent_mm[1, 0] - first) + 1
        self._first, self._low = first, low_mm
        window, x, y = self._mask.window
        pixels = np.array([[1, 0, -x], [0, 1, -y], [0, 0, 1]]) @ self._pixels_from_mm
        pixels = pixels @ np.array([[1, 0, first], [0, 1, low_mm], [0, 0, 1]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        self._plane = cv2.warpPerspective(window, pixels, (columns, rows), flags=flags)

    def radii(self) -> Floats:
        """(2, rows) distance of the outline from the axis on either side, mm, NaN where it is not seen.

        A line of sight touches a solid of revolution a little before the plane: the radius is that of the circle that
        it touches.
        """
        from corsmal.shape.outline_kernels import ends_of_rows  # noqa: PLC0415 - Numba takes long to import

        low, high = ends_of_rows(self._plane, self._first, self._low, self._pixels_from_mm, BORDER_PX, self._last)
        radii: Floats = self.distance_mm * np.sin(np.arctan(np.stack([high, -low]) / self.distance_mm))
        return radii

    @cached_property
    def _reaches(self) -> Floats:
        """(2, columns) heights at which the mask ends below and above, NaN where that is not seen."""
        from corsmal.shape.outline_kernels import ends_of_rows  # noqa: PLC0415 - Numba takes long to import

        upright = np.ascontiguousarray(self._pixels_from_mm[:, [1, 0, 2]])
        return ends_of_rows(np.ascontiguousarray(self._plane.T), self._low, self._first, upright, BORDER_PX, self._last)

    def missing_mm(self, heights_mm: Floats, radii_mm: Floats, shares: Floats, *, upper: bool) -> Floats:
        """How far beyond the silhouettes of circles the mask reaches: negative where it ends before, NaN where unseen.

        Args:
            heights_mm: (n,) of the circles.
            radii_mm: (n,) of the circles.
            shares: (m,) where that is read, shares of the radius; of the m numbers their lower median counts.
            upper: whether the mask's upper end counts, or its lower one.
        """
        from corsmal.shape.outline_kernels import middle_of_missing  # noqa: PLC0415 - Numba takes long to import

        reach_mm, above = self._reaches[1 if upper else 0], heights_mm - self.camera_mm
        ways = [above * self.distance_mm / (self.distance_mm + sign * radii_mm) - above for sign in (1, -1)]
        overhangs_mm = np.maximum(*ways) if upper else np.minimum(*ways)
        sign = 1.0 if upper else -1.0
        return middle_of_missing(reach_mm, self._first, heights_mm, radii_mm, overhangs_mm, shares, sign)


def _crossed(first: Floats, second: Floats) -> Floats:
    """The cross product of two (3,) vectors; NumPy's takes longer, since it knows other shapes."""
    (a, b, c), (x, y, z) = first.tolist(), second.tolist()
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])
