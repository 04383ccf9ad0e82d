"""A box from the outlines of masks: width, depth, height, place, turn and lean.

A box is convex, so its silhouette is known by how far it reaches in every direction of the image. A hand in front of it
takes pieces out of a mask, but seldom all that reaches farthest.
"""

from collections.abc import Sequence

import cv2
import numpy as np

from corsmal.geometry import Camera, Floats
from corsmal.shape.cropped import Cropped
from corsmal.shape.records import Hull

DIRECTIONS = 24
HALF_PIXEL = 0.5
"""A mask's pixels end half a pixel beyond their centres."""
TRUST_PX = 1.5
TURNS = (-0.6, 0.0, 0.6)
"""Turns from which the fit starts, radians; a box looks the same after half a turn, and a quarter swaps its sides."""
STEPS = 12
SIZE_MIN_M = 0.01
MOVE_MAX = np.array([0.1] * 6 + [0.4] * 3)
DIFFERENCE = np.array([1e-4] * 6 + [1e-3] * 3)


def fit_box(cameras: Sequence[Camera], masks: Sequence[Cropped], start: Hull, *, tilt_deg: float) -> Hull:
    """Fit a box to how far masks that are not empty reach in every direction in two or more cameras.

    Args:
        cameras: two or more.
        masks: one per camera.
        start: a solid of revolution fitted to them, from whose size and place the search starts.
        tilt_deg: how far the axis is expected to lean; 0: it is vertical.
    """
    if start.centroid_m is None:
        return start
    angles = np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS) + 0.05
    directions = np.column_stack([np.cos(angles), np.sin(angles)])
    reach_px = np.array([_reach(mask, directions) for mask in masks])
    projections = np.array([camera.projection for camera in cameras])
    tilt = np.radians(max(tilt_deg, 1e-3))
    height = float(np.ptp(start.heights_mm)) / 1000
    middle = start.centroid_m + (float(np.mean(start.heights_mm)) / 1000 - start.centroid_m[2]) * start.direction
    radius = float(start.radii_mm.max()) / 1000
    best, least = None, np.inf
    for turn in TURNS:
        box = np.array([*middle, 2 * radius, radius, height, turn, 0.0, 0.0])
        box, cost = _descend(box, projections, directions, reach_px, tilt)
        if cost < least:
            best, least = box, cost
    return start if best is None else _hull(best, start)


def _reach(mask: Cropped, directions: Floats) -> Floats:
    outside, way = cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE
    contours, _ = cv2.findContours(mask.pixels.view(np.uint8), outside, way, offset=(mask.left, mask.top))
    points = cv2.convexHull(np.concatenate(contours))[:, 0].astype(np.float64)
    reach: Floats = (points @ directions.T).max(axis=0) + HALF_PIXEL
    return reach


def _descend(
    box: Floats, projections: Floats, directions: Floats, reach_px: Floats, tilt: float
) -> tuple[Floats, float]:
    """Levenberg and Marquardt's descent with weights that forgive what a hand or a wrong mask does."""
    from corsmal.shape.box_kernels import reach_errors  # noqa: PLC0415 - Numba takes long to import

    prior = np.diag([0.0] * 7 + [1 / tilt**2] * 2)
    error, cost = reach_errors(box[None], projections, directions, reach_px)[0], np.inf
    damping = 1e-3
    for _ in range(STEPS):
        nearby = reach_errors(box + np.diag(DIFFERENCE), projections, directions, reach_px)
        slopes = ((nearby - error) / DIFFERENCE[:, None]).T
        weights = 1 / (1 + (error / TRUST_PX) ** 2) / TRUST_PX**2
        normal = (slopes * weights[:, None]).T @ slopes + prior
        gradient = (slopes * weights[:, None]).T @ error + prior @ box
        cost = _cost(error, box, prior)
        for _ in range(5):
            scale = np.diag(damping * (np.diag(normal) + 1e-6))
            tried = box + np.clip(-np.linalg.solve(normal + scale, gradient), -MOVE_MAX, MOVE_MAX)
            tried[3:6] = np.maximum(np.abs(tried[3:6]), SIZE_MIN_M)
            found = reach_errors(tried[None], projections, directions, reach_px)[0]
            reached = _cost(found, tried, prior)
            if reached < cost:
                damping = max(damping / 5, 1e-6)
                break
            damping *= 5
        else:
            break
        gained, box, error, cost = cost - reached, tried, found, reached
        if gained < 1e-3:
            break
    return box, cost


def _cost(error: Floats, box: Floats, prior: Floats) -> float:
    return float(np.log1p((error / TRUST_PX) ** 2).sum() + box @ prior @ box)


def _hull(box: Floats, start: Hull) -> Hull:
    circumferences = len(start.heights_mm)
    middle, (width, depth, height), turn = box[:3], 1000 * box[3:6], float(box[6])
    direction = np.array([*box[7:], 1.0])
    if width < depth:
        width, depth, turn = depth, width, turn + np.pi / 2
    return Hull(
        1000 * middle[2] + np.linspace(-height / 2, height / 2, circumferences),
        np.full(circumferences, width / 2),
        np.ones(circumferences, dtype=bool),
        middle,
        direction=direction / np.linalg.norm(direction),
        depth_mm=float(depth),
        yaw=float((turn + np.pi / 2) % np.pi - np.pi / 2),
        view_weights=start.view_weights,
        evidence=start.evidence,
    )
