"""Calibrated pinhole cameras: projection and linear triangulation.

Conventions: world coordinates in metres, z up; ``rotation`` and ``translation`` take world points to camera
points, ``x_camera = rotation @ x_world + translation``; pixels are ``(x, y)`` with the origin at the centre of the
top-left pixel.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from corsmal.errors import ArgumentError

Floats = NDArray[np.float64]

ROTATION_TOLERANCE = 1e-3
"""How far R Rᵀ may be from the identity: calibration files hold single-precision numbers."""


@dataclass(frozen=True, eq=False)
class Camera:
    """A calibrated camera without lens distortion.

    Args:
        intrinsic: (3, 3) float, pixels; last row 0 0 1, focal lengths positive.
        rotation: (3, 3) float, world to camera.
        translation: (3,) float, metres, world to camera.
        size: (width, height) of the image in pixels.

    Raises:
        ArgumentError: a shape is wrong, a number is not finite, or ``rotation`` is not a rotation.
    """

    intrinsic: Floats
    rotation: Floats
    translation: Floats
    size: tuple[int, int]

    def __post_init__(self) -> None:
        for name, shape in (("intrinsic", (3, 3)), ("rotation", (3, 3)), ("translation", (3,))):
            object.__setattr__(self, name, _finite(getattr(self, name), shape=shape, name=name))
        object.__setattr__(self, "size", (int(self.size[0]), int(self.size[1])))
        if min(self.size) < 1:
            raise ArgumentError(f"size must be two positive numbers of pixels (width, height), got {self.size}")
        if self.intrinsic[0, 0] <= 0 or self.intrinsic[1, 1] <= 0 or not np.allclose(self.intrinsic[2], (0, 0, 1)):
            raise ArgumentError("intrinsic must have positive focal lengths and the last row 0 0 1")
        with np.errstate(over="ignore", invalid="ignore"):
            product = self.rotation @ self.rotation.T
            is_rotation = np.allclose(product, np.eye(3), atol=ROTATION_TOLERANCE) and np.linalg.det(self.rotation) > 0
        if not is_rotation:
            raise ArgumentError("rotation must be a (3, 3) rotation matrix (orthonormal, determinant +1)")

    @cached_property
    def projection(self) -> Floats:
        """The (3, 4) matrix from homogeneous world coordinates (m) to homogeneous pixels."""
        return self.intrinsic @ np.column_stack([self.rotation, self.translation])

    @cached_property
    def centre_m(self) -> Floats:
        """The (3,) optical centre in the world, metres."""
        return -self.rotation.T @ self.translation

    def project(self, points_m: ArrayLike) -> Floats:
        """Project world points.

        Args:
            points_m: (n, 3) metres.

        Returns:
            (n, 2) pixels ``(x, y)``; NaN for points in or behind the camera's plane.
        """
        points = np.asarray(points_m, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ArgumentError(f"points_m must have shape (n, 3), got {points.shape}")
        homogeneous = points @ self.projection[:, :3].T + self.projection[:, 3]
        depth = homogeneous[:, 2:]
        return np.divide(homogeneous[:, :2], depth, out=np.full((len(points), 2), np.nan), where=depth > 0)

    def scaled(self, size: tuple[int, int]) -> "Camera":
        """The same camera for images resized to ``size`` (width, height), pixel centres kept in place."""
        x_scale, y_scale = size[0] / self.size[0], size[1] / self.size[1]
        to_scaled = np.array(
            [[x_scale, 0, (x_scale - 1) / 2], [0, y_scale, (y_scale - 1) / 2], [0, 0, 1]], dtype=np.float64
        )
        return replace(self, intrinsic=to_scaled @ self.intrinsic, size=size)


def triangulate(cameras: Sequence[Camera], points_px: ArrayLike, *, has_unit_rows: bool = True) -> Floats:
    """The world point seen at one pixel in each camera, by linear (DLT) triangulation.

    Args:
        cameras: two or more cameras.
        points_px: (n, 2) pixels, one per camera.
        has_unit_rows: whether the rows of the linear system are scaled to unit length, or stay as they are (OpenCV).

    Returns:
        (3,) metres. Not finite where the rays are exactly parallel: check ``parallax_deg`` for nearly parallel ones.

    References:
        Hartley and Zisserman, *Multiple View Geometry*, 2nd ed., section 12.2.
    """
    points = _finite(points_px, shape=(len(cameras), 2), name="points_px")
    if len(cameras) < 2:
        raise ArgumentError(f"triangulation needs at least two cameras, got {len(cameras)}")
    rows = [
        point[axis] * camera.projection[2] - camera.projection[axis]
        for camera, point in zip(cameras, points, strict=True)
        for axis in (0, 1)
    ]
    system = np.array([row / np.linalg.norm(row) for row in rows] if has_unit_rows else rows)
    homogeneous = np.linalg.svd(system)[2][-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        return homogeneous[:3] / homogeneous[3]


def parallax_deg(cameras: Sequence[Camera], point_m: Floats) -> float:
    """The largest angle, in degrees, between two of the cameras' rays to a world point; 0 where one is at the point."""
    rays = np.array([point_m - camera.centre_m for camera in cameras])
    lengths = np.linalg.norm(rays, axis=1, keepdims=True)
    if not lengths.all():
        return 0.0
    rays /= lengths
    return float(np.degrees(np.arccos(np.clip((rays @ rays.T).min(), -1, 1))))


def _finite(values: ArrayLike, *, shape: tuple[int, ...], name: str) -> Floats:
    array = np.array(values, dtype=np.float64)
    if array.shape != shape:
        raise ArgumentError(f"{name} must have shape {shape}, got {array.shape}")
    if not np.isfinite(array).all():
        raise ArgumentError(f"{name} must be finite, got {array.tolist()}")
    array.flags.writeable = False
    return array
