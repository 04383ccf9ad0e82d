"""How surfaces look: light, the rays of a camera's pixels, and the colours that are painted."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from corsmal.geometry import Camera, Floats
from corsmal.synthetic.render.kernels import Pixel, Vector, kernel
from corsmal.synthetic.render.tracing import INF, NEAR, TINY, at, grain
from corsmal.synthetic.scene.looks import Light

Image = NDArray[np.uint8]
Depth = NDArray[np.float32]
Mask = NDArray[np.bool_]
Window = NDArray[np.int64]
"""Columns from and to, rows from and to, the ends excluded."""
Layers = tuple[Image, Image, Depth, Mask, Mask]
"""The image, the image before the vessel, depth, visible and amodal mask."""
Walls = tuple[Floats, Floats, Floats]
"""Profiles (2, n) in metres of the outer wall, the cavity and the filling; the last may be a single point."""
Shade = tuple[Floats, Floats, Floats]
"""Pose (7, 3), finish (14,) and light (8,)."""


@dataclass(frozen=True, eq=False)
class Rays:
    """The rays of a camera's pixels: ``centre + t · (matrix @ (x, y, 1))``, t being the depth."""

    centre_m: Floats
    matrix: Floats
    projection: Floats
    size: tuple[int, int]

    @classmethod
    def of(cls, camera: Camera) -> "Rays":
        """Of a camera."""
        matrix = camera.rotation.T @ np.linalg.inv(camera.intrinsic)
        return cls(camera.centre_m, matrix, camera.projection, camera.size)

    def windows(self, points_m: Floats) -> Window:
        """The parts of the image around projected points (..., n, 3): (..., 4) columns and rows from and to."""
        homogeneous = points_m @ self.projection[:, :3].T + self.projection[:, 3]
        pixels = homogeneous[..., :2] / np.maximum(homogeneous[..., 2:], NEAR)
        is_near = homogeneous[..., 2].min(axis=-1)[..., None] < NEAR
        low = np.where(is_near, 0, np.floor(pixels.min(axis=-2)))
        high = np.where(is_near, self.size, np.ceil(pixels.max(axis=-2)) + 1)
        ends = np.stack([low, high], axis=-1).clip(0, np.array(self.size)[:, None])
        return ends.reshape(*ends.shape[:-2], 4).astype(np.int64)


def light_values(light: Light) -> Floats:
    """The light as (8,) numbers for the kernels: direction, ambient, lamp, gains."""
    return np.array([*light.direction, light.ambient, light.lamp, *light.gains])


def solid_pose(base_m: Floats, rotation: Floats, rays: Rays) -> Floats:
    """(7, 3): camera centre, the rays' three rows, and the rotation's, in or from the vessel's frame."""
    return np.concatenate([[rotation.T @ (rays.centre_m - base_m)], rotation.T @ rays.matrix, rotation])


@kernel
def ray(pose: Floats, pixel: Pixel) -> Vector:
    """Direction of a pixel's ray in a solid's frame."""
    y, x = pixel
    return (
        pose[1, 0] * x + pose[1, 1] * y + pose[1, 2],
        pose[2, 0] * x + pose[2, 1] * y + pose[2, 2],
        pose[3, 0] * x + pose[3, 1] * y + pose[3, 2],
    )


@kernel
def lit(pose: Floats, normal: Vector, light: Floats) -> float:
    """Brightness of a surface whose normal is given in a solid's frame."""
    nx, ny, nz = normal
    in_world = (
        pose[4, 0] * nx + pose[4, 1] * ny + pose[4, 2] * nz,
        pose[5, 0] * nx + pose[5, 1] * ny + pose[5, 2] * nz,
        pose[6, 0] * nx + pose[6, 1] * ny + pose[6, 2] * nz,
    )
    return brightness(in_world, light)


@kernel
def gleam(normal: Vector, direction: Vector, pose: Floats, light: Floats, sharpness: float) -> float:
    """The upright streak that a lamp leaves on a round wall: from the horizontal parts of light and view."""
    lx = pose[4, 0] * light[0] + pose[5, 0] * light[1] + pose[6, 0] * light[2]
    ly = pose[4, 1] * light[0] + pose[5, 1] * light[1] + pose[6, 1] * light[2]
    view, lamp = max(math.hypot(direction[0], direction[1]), TINY), max(math.hypot(lx, ly), TINY)
    hx, hy = lx / lamp - direction[0] / view, ly / lamp - direction[1] / view
    norm = max(math.hypot(hx, hy) * math.hypot(normal[0], normal[1]), TINY)
    return float(max(0.0, (normal[0] * hx + normal[1] * hy) / norm) ** sharpness)


@kernel
def brightness(normal: Vector, light: Floats) -> float:
    """Light that a surface with that normal (any length) gives back: ambient, most from above, and the lamp's."""
    nx, ny, nz = normal
    norm = math.sqrt(nx * nx + ny * ny + nz * nz)
    if norm <= 0.0 or norm == INF:
        return float(light[3])
    facing = (nx * light[0] + ny * light[1] + nz * light[2]) / norm
    ambient = light[3] * (0.8 + 0.2 * nz / norm + 0.08 * ny / norm)
    return float(ambient + light[4] * max(0.0, facing))


@kernel
def paint(image: Image, pixel: Pixel, colour: Vector, value: float, light: Floats) -> None:
    """Set a pixel to a colour of a brightness under the light's own colour."""
    for channel in range(3):
        image[pixel[0], pixel[1], channel] = min(255.0, max(0.0, colour[channel] * value * light[5 + channel]))


@kernel
def surface_of_filling(origin: Vector, direction: Vector, filled: Floats) -> float:
    """Depth at which a ray from above meets the filling's surface; infinity where it does not."""
    if filled.shape[1] < 2 or direction[2] >= 0.0:
        return INF
    t = (filled[0, -1] - origin[2]) / direction[2]
    x, y, _ = at(origin, direction, t)
    return float(t if x * x + y * y <= filled[1, -1] * filled[1, -1] else INF)


@kernel
def paint_filling(image: Image, pixel: Pixel, place: Vector, value: float, shade: Shade) -> None:
    """Grains, or the surface of water."""
    _, finish, light = shade
    size = finish[9]
    speckle = 0.84 + 0.3 * grain(math.floor(place[0] / size), math.floor(place[1] / size), math.floor(place[2] / size))
    speckle = 1.0 if finish[11] > 0.0 else speckle
    paint(image, pixel, (finish[6], finish[7], finish[8]), value * speckle, light)
