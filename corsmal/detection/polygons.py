"""Masks from polygons. What a file may cost is bounded; the bounds are far beyond what programs write."""

from collections import Counter
from typing import Any

import numpy as np
import pycocotools.mask as coco_mask
from numpy.typing import NDArray

from corsmal.detection.rle import Size, numbers
from corsmal.errors import ArgumentError

POLYGONS_MAX = 1_000
POINTS_MAX = 50_000
"""Of one mask."""

OUTLINE_MAX = 50
"""Length of one mask's outlines, of the image's width and height together: drawing costs time by its length."""

FILE_OUTLINE_MAX_PX = 100_000_000
"""Length of all outlines of a file, which takes about half a minute."""

TOO_FEW = "a polygon of the mask is not a list of three or more points [x0, y0, x1, y1, ...]"
OUTSIDE = "a polygon of the mask lies more than an image size outside the image"


class Outlines:
    """Draws the polygons of a file's masks in images of ``size`` (H, W).

    ``dropped`` counts, by the reason, the polygons that were left out of masks that have others.
    """

    def __init__(self, size: Size) -> None:
        self.size = size
        self.dropped: Counter[str] = Counter()
        self._left_px = float(FILE_OUTLINE_MAX_PX)
        self._limits = np.array([size[1], size[0]], dtype=np.float64)

    def counts(self, polygons: list[Any]) -> bytes:
        """The compressed run lengths of a mask of one or more polygons, ``[x0, y0, x1, y1, ...]`` in pixels.

        Polygons that cannot be used are left out where another can.

        Raises:
            ArgumentError: none can be used, or drawing them would take too long.
        """
        if all(type(value) in (int, float) for value in polygons):
            polygons = [polygons]  # a single polygon, not in a list of its own
        if len(polygons) > POLYGONS_MAX:
            raise ArgumentError(f"the mask has more than {POLYGONS_MAX} polygons, write run lengths instead")
        good, reasons = [], []
        for polygon in polygons:
            points = numbers(polygon)
            reason = self._reason(points)
            reasons += [reason] if reason else []
            good += [] if reason else [points]
        if not good:
            raise ArgumentError(reasons[0])
        self._spend(good)
        self.dropped.update(reasons)
        return coco_mask.merge(coco_mask.frPyObjects([points.tolist() for points in good], *self.size))["counts"]

    def _reason(self, points: NDArray[np.float64]) -> str:
        """Why a polygon cannot be used; empty if it can."""
        if len(points) < 6 or len(points) % 2:
            return TOO_FEW
        # pycocotools allocates by the length of an outline, so a point far outside could take all memory
        is_near = (np.abs(points.reshape(-1, 2) - self._limits / 2) <= 1.5 * self._limits).all()
        return "" if is_near else OUTSIDE

    def _spend(self, polygons: list[NDArray[np.float64]]) -> None:
        """Take what drawing the polygons costs off what the file may cost."""
        if sum(map(len, polygons)) > 2 * POINTS_MAX:
            raise ArgumentError(f"the mask has more than {POINTS_MAX} points, write run lengths instead")
        corners = [points.reshape(-1, 2) for points in polygons]
        lengths = [np.abs(points - np.roll(points, 1, axis=0)).max(axis=1).sum() for points in corners]
        length_px = float(sum(lengths))
        if length_px > OUTLINE_MAX * self._limits.sum():
            raise ArgumentError(f"the mask's outlines are longer than {OUTLINE_MAX} times the image's width and height")
        if length_px > self._left_px:
            raise ArgumentError(
                f"the file's outlines are longer than {FILE_OUTLINE_MAX_PX} pixels, write run lengths instead"
            )
        self._left_px -= length_px
