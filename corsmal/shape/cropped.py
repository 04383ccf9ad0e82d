"""A mask's pixels without the empty ones around them: most of a picture shows no container."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.geometry import Floats

Mask = NDArray[np.bool_]

MARGIN_PX = 3
TONGUE_SHARE = 0.3
"""What is thinner than this share of the square root of a mask's pixels may be a tongue between fingers."""
THICK_MIN = 0.9
"""A mask of which less remains without its thin parts shows a glass on a stem, or too little."""
SPECK_SHARE = 0.1
"""Pieces of a mask that are smaller, against its largest, are specks; a hand may part a container in larger ones."""


@dataclass(frozen=True, eq=False)
class Cropped:
    """The part of a mask that has all of its pixels. What is derived from it is computed once.

    Args:
        pixels: (h, w) bool, the least rectangle; (0, 0) of an empty mask.
        left: column of the picture where it begins.
        top: row of the picture where it begins.
        size: (width, height) of the picture.
    """

    pixels: Mask
    left: int
    top: int
    size: tuple[int, int]

    @classmethod
    def of(cls, mask: Mask, left: int = 0, top: int = 0, size: tuple[int, int] | None = None) -> "Cropped":
        """The part of a (H, W) bool mask, which may itself begin at ``left`` and ``top`` of a picture of a size."""
        x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
        pixels = np.array(mask[y : y + height, x : x + width], order="C")
        return cls(pixels, left + x, top + y, size or mask.shape[::-1])

    @classmethod
    def empty(cls, size: tuple[int, int]) -> "Cropped":
        """A mask of no pixels in a picture of a size (width, height)."""
        return cls(np.zeros((0, 0), dtype=np.bool_), 0, 0, size)

    @cached_property
    def count(self) -> int:
        """The number of pixels."""
        return int(np.count_nonzero(self.pixels))

    @cached_property
    def centroid(self) -> Floats | None:
        """(2,) centroid of the largest contour by image moments, pixels ``(x, y)``; None where none has an area."""
        found = contour_centroid(self.pixels)
        return None if found is None else found + np.array([self.left, self.top])

    @cached_property
    def window(self) -> tuple[NDArray[np.float32], int, int]:
        """The pixels as numbers, with a margin of empty ones, and the column and row where that begins."""
        x, y = max(0, self.left - MARGIN_PX), max(0, self.top - MARGIN_PX)
        left, top, (height, width) = self.left - x, self.top - y, self.pixels.shape
        numbers = np.zeros((top + height + MARGIN_PX, left + width + MARGIN_PX), dtype=np.float32)
        numbers[top : top + height, left : left + width] = self.pixels
        return numbers, x, y

    @cached_property
    def without_specks(self) -> "Cropped":
        """The mask without the pieces that are small against its largest."""
        pieces, labels, statistics, _ = cv2.connectedComponentsWithStats(self.pixels.view(np.uint8), connectivity=8)
        if pieces <= 2:
            return self
        areas = statistics[1:, cv2.CC_STAT_AREA]
        kept: Mask = np.concatenate([[False], areas >= SPECK_SHARE * areas.max()])[labels]
        return Cropped.of(kept, self.left, self.top, self.size)

    @cached_property
    def whole(self) -> "Cropped":
        """About what the mask would be without a hand: no tongues between fingers, and bites at its sides filled in.

        That is the convex hull of what remains of it without its thin parts. It has the container's axis, not its
        outline. A mask with much that is thin, such as a glass on its stem, stays as it is.
        """
        padded = np.pad(self.pixels, 1).view(np.uint8)
        side = max(3, round(TONGUE_SHARE * float(np.sqrt(self.count))))
        thick = cv2.morphologyEx(padded, cv2.MORPH_OPEN, np.ones((side, side), np.uint8))
        if np.count_nonzero(thick) < THICK_MIN * self.count:
            return self
        contours, _ = cv2.findContours(thick, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        filled = np.zeros(padded.shape, dtype=np.uint8)
        cv2.fillConvexPoly(filled, cv2.convexHull(np.concatenate(contours)), 1)
        (width, height), left, top = self.size, self.left - 1, self.top - 1  # an even square moves what it opens
        inside = filled.view(np.bool_)[max(0, -top) : height - top, max(0, -left) : width - left]
        return Cropped.of(inside, max(0, left), max(0, top), self.size)

    def pixels_in_both(self, other: "Cropped") -> int:
        """How many pixels of the picture lie in this mask and in another one."""
        left, top = max(self.left, other.left), max(self.top, other.top)
        right = min(each.left + each.pixels.shape[1] for each in (self, other))
        bottom = min(each.top + each.pixels.shape[0] for each in (self, other))
        if right <= left or bottom <= top:
            return 0
        own, others = (
            each.pixels[top - each.top : bottom - each.top, left - each.left : right - each.left]
            for each in (self, other)
        )
        return int(np.count_nonzero(own & others))

    def in_picture(self) -> Mask:
        """The mask in the whole picture, (H, W) bool."""
        painted = np.zeros(self.size[::-1], dtype=np.bool_)
        height, width = self.pixels.shape
        painted[self.top : self.top + height, self.left : self.left + width] = self.pixels
        return painted


def contour_centroid(mask: Mask) -> Floats | None:
    """Centroid of a mask's largest contour by image moments.

    Args:
        mask: (H, W) bool.

    Returns:
        (2,) pixels ``(x, y)``; None where no contour encloses an area.
    """
    if mask.size == 0:
        return None
    contours, _ = cv2.findContours(np.ascontiguousarray(mask, np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    moments = cv2.moments(max(contours, key=cv2.contourArea)) if contours else {"m00": 0}
    if moments["m00"] == 0:
        return None
    return np.array([moments["m10"], moments["m01"]]) / moments["m00"]
