"""Where a hull's circumferences lie in the world, and the silhouettes that they make."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.errors import ArgumentError
from corsmal.geometry import Camera, Floats
from corsmal.parameters import AngleRule
from corsmal.shape.cropped import Cropped, Mask
from corsmal.shape.outlines import Axis
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
    return [each.in_picture() for each in cropped_silhouettes(hull, cameras)]


def cropped_silhouettes(hull: Hull, cameras: Sequence[Camera]) -> list[Cropped]:
    """The silhouettes without the empty pixels around them."""
    chosen = np.flatnonzero(hull.converged)
    if len(chosen) < 2:
        return [Cropped.empty(camera.size) for camera in cameras]
    if len(chosen) > SLICES:
        chosen = chosen[np.linspace(0, len(chosen) - 1, SLICES).round().astype(np.intp)]
    if hull.depth_mm is not None:
        chosen = chosen[[0, -1]]
    rings = circumference_points(hull, points=SIDES)[chosen]
    return [_painted(camera.project(rings.reshape(-1, 3)).reshape(*rings.shape[:2], 2), camera) for camera in cameras]


def _painted(rings_px: Floats, camera: Camera) -> Cropped:
    """The convex hulls of each two neighbours of (L, N, 2) rings; those with points behind the camera are left out."""
    pixels = rings_px.astype(np.float32)
    is_seen: NDArray[np.bool_] = np.all(np.isfinite(pixels), axis=(1, 2))
    pieces = np.flatnonzero(is_seen[:-1] & is_seen[1:])
    last = np.array(camera.size) - 1
    inside = np.clip(pixels[is_seen], -1, last + 1)
    if not len(pieces):
        return Cropped.empty(camera.size)
    left, top = np.clip(np.floor(inside.min(axis=(0, 1))) - 1, 0, last).astype(int).tolist()
    right, bottom = np.clip(np.ceil(inside.max(axis=(0, 1))) + 1, 0, last).astype(int).tolist()
    painted = np.zeros((bottom - top + 1, right - left + 1), dtype=np.uint8)
    pixels = np.where(is_seen[:, None, None], pixels, 0)
    corners = np.rint(pixels * (1 << SUBPIXEL_BITS)).astype(np.int32) - np.array([left, top]) * (1 << SUBPIXEL_BITS)
    for piece in pieces:
        pair = slice(piece, piece + 2)
        outline = cv2.convexHull(pixels[pair].reshape(-1, 2), returnPoints=False)[:, 0]
        cv2.fillConvexPoly(painted, corners[pair].reshape(-1, 2)[outline], 1, shift=SUBPIXEL_BITS)
    return Cropped.of(painted.view(np.bool_), left, top, camera.size)


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
    return cropped_agreement(Cropped.of(silhouette), Cropped.of(mask))


def cropped_agreement(silhouette: Cropped, mask: Cropped) -> Agreement:
    """As ``agreement``, of masks without the empty pixels around them."""
    if not mask.count:
        raise ArgumentError("the mask must have a pixel, got an empty one")
    return Agreement(mask.pixels_in_both(silhouette), mask.count, silhouette.count)


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
