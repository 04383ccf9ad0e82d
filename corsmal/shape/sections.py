"""Where a hull's circumferences lie in the world, and the silhouettes that they make."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from corsmal.errors import ArgumentError
from corsmal.geometry import Camera, Floats
from corsmal.parameters import AngleRule
from corsmal.shape.outlines import Axis, Mask
from corsmal.shape.records import Hull

SIDES, SLICES = 24, 40
"""Corners and number of the circumferences that silhouettes are painted from."""
SUBPIXEL_BITS = 4


def unit_circle(points: int, *, angle_rule: AngleRule = "circle") -> Floats:
    """Points of the unit circle, (points, 2), at the angles of ``ShapeParameters.angle_rule``."""
    if angle_rule == "0-359":
        angles = np.radians(np.linspace(0.0, 359.0, points))
    else:
        angles = np.arange(points) * (2 * np.pi / points)
    return np.column_stack([np.cos(angles), np.sin(angles)])


def circumference_points(hull: Hull, *, points: int, angle_rule: AngleRule = "circle") -> Floats:
    """World points of a hull's circumferences, metres, (L, points, 3).

    They lie at the angles of ``unit_circle``; on a box's rectangles each side has a quarter of them, the first at a
    corner.
    """
    if hull.centroid_m is None:
        return np.empty((0, points, 3))
    heights = hull.heights_mm / 1000 - hull.centroid_m[2]
    centres = hull.centroid_m + heights[:, None] * hull.direction
    flat = _ring(hull, points=points, angle_rule=angle_rule) @ Axis(hull.centroid_m, hull.direction).across
    return centres[:, None] + flat


def silhouettes(hull: Hull, cameras: Sequence[Camera]) -> list[Mask]:
    """What cameras see of a hull: an (H, W) bool mask for each, empty where fewer than two circumferences converged."""
    chosen = np.flatnonzero(hull.converged)
    if len(chosen) < 2:
        return [np.zeros(camera.size[::-1], dtype=np.bool_) for camera in cameras]
    if len(chosen) > SLICES:
        chosen = chosen[np.linspace(0, len(chosen) - 1, SLICES).round().astype(np.intp)]
    if hull.depth_mm is not None:
        chosen = chosen[[0, -1]]
    rings = circumference_points(hull, points=SIDES)[chosen]
    masks = []
    for camera in cameras:
        painted = np.zeros(camera.size[::-1], dtype=np.uint8)
        pixels = camera.project(rings.reshape(-1, 3)).reshape(len(rings), -1, 2).astype(np.float32)
        for piece in np.concatenate([pixels[:-1], pixels[1:]], axis=1):
            if np.isfinite(piece).all():
                outline = np.rint(cv2.convexHull(piece) * (1 << SUBPIXEL_BITS)).astype(np.int32)
                cv2.fillConvexPoly(painted, outline, 1, shift=SUBPIXEL_BITS)
        masks.append(painted.view(np.bool_))
    return masks


@dataclass(frozen=True)
class Agreement:
    """How a hull's silhouette agrees with a mask.

    Args:
        both: pixels that lie in both.
        mask: pixels of the mask, at least 1.
        silhouette: pixels of the silhouette.
    """

    both: int
    mask: int
    silhouette: int

    @property
    def explained(self) -> float:
        """The share of the mask that the silhouette covers, 0..1."""
        return self.both / self.mask

    @property
    def beyond(self) -> float:
        """The silhouette's pixels outside the mask, as a share of the mask, 0 or more."""
        return (self.silhouette - self.both) / self.mask

    @property
    def overlap(self) -> float:
        """Intersection over union, 0..1."""
        return self.both / (self.mask + self.silhouette - self.both)


def agreement(silhouette: Mask, mask: Mask) -> Agreement:
    """How a silhouette agrees with a mask, both (H, W).

    Raises:
        ArgumentError: the mask is empty.
    """
    left, top, width, height = cv2.boundingRect(mask.view(np.uint8))
    if not width:
        raise ArgumentError("the mask must have a pixel, got an empty one")
    window = np.s_[top : top + height, left : left + width]
    counted = (mask[window] & silhouette[window], mask[window], silhouette)
    return Agreement(*(int(np.count_nonzero(pixels)) for pixels in counted))


def _ring(hull: Hull, *, points: int, angle_rule: AngleRule) -> Floats:
    """(L, points, 2) of the circumferences about their centres, metres."""
    if hull.depth_mm is None:
        return hull.radii_mm[:, None, None] / 1000 * unit_circle(points, angle_rule=angle_rule)
    along = np.arange(points) * (4 / points)
    corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1)], dtype=np.float64)
    square = np.column_stack([np.interp(along, np.arange(5), corners[:, axis]) for axis in (0, 1)])
    turn = np.array([[np.cos(hull.yaw), np.sin(hull.yaw)], [-np.sin(hull.yaw), np.cos(hull.yaw)]])
    halves = np.column_stack([hull.radii_mm, np.full(len(hull.radii_mm), hull.depth_mm / 2)]) / 1000
    return (halves[:, None] * square) @ turn
