"""See-through vessels: what is behind them, their walls, and what is filled in."""

import math

from corsmal.geometry import Floats
from corsmal.synthetic.render.kernels import Pixel, Vector, kernel
from corsmal.synthetic.render.shading import (
    Image,
    Layers,
    Shade,
    Walls,
    Window,
    gleam,
    lit,
    paint_filling,
    ray,
)
from corsmal.synthetic.render.tracing import INF, TINY, at, cylinder_span, profile_crossings

RIM_M = 0.0022
"""Height of the bright rim."""


@kernel
def draw_clear(layers: Layers, window: Window, walls: Walls, shade: Shade) -> None:
    """Draw a see-through vessel into a window of the layers."""
    image, behind, depth, visible, amodal = layers
    pose, _, _ = shade
    outer, inner, _ = walls
    origin, top = (pose[0, 0], pose[0, 1], pose[0, 2]), outer[0, -1]
    largest, hollow = outer[1].max(), inner[1].max()
    for y in range(window[2], window[3]):
        for x in range(window[0], window[1]):
            pixel = (y, x)
            direction = ray(pose, pixel)
            t, normal, end, back = profile_crossings(origin, direction, outer, largest)
            if t == INF:
                continue
            amodal[y, x] = True
            if t >= depth[y, x]:
                continue
            visible[y, x] = True
            z, z_end = origin[2] + t * direction[2], origin[2] + end * direction[2]
            start, stop = cylinder_span(origin, direction, hollow, inner[0, 0], inner[0, -1])
            is_front = not (normal[2] == 1.0 and z > top - 1e-6)
            source = _bent(pixel, normal, (6.0 if start > stop else 1.5) if is_front else 0.0, pose, image.shape[1])
            source = source if depth[y, source] >= t else x
            _tint(image, pixel, behind, source, shade)
            if end < depth[y, x]:
                _glaze(image, pixel, back, (0.7, 1.0 if z_end > top - RIM_M else 0.0), shade)
            _draw_content(layers, pixel, walls, shade)
            if is_front:
                _glaze(image, pixel, normal, (1.0, 1.0 if z > top - RIM_M else 0.0), shade)


@kernel
def _bent(pixel: Pixel, normal: Vector, bend: float, pose: Floats, width: int) -> int:
    """The column whose background a clear wall shows, ``bend`` pixels away at its edge."""
    # the ray matrix' first column tells which way the image's x axis points in the vessel's frame
    across = (normal[0] * pose[1, 0] + normal[1] * pose[2, 0]) / max(math.hypot(pose[1, 0], pose[2, 0]), TINY)
    return min(max(round(pixel[1] - bend * across), 0), width - 1)


@kernel
def _tint(image: Image, pixel: Pixel, behind: Image, source: int, shade: Shade) -> None:
    _, finish, light = shade
    y, x = pixel
    for channel in range(3):
        tint = finish[12] * finish[channel] * light[3] * 1.45 * light[5 + channel]
        image[y, x, channel] = min(255.0, behind[y, source, channel] * (1 - finish[12]) + tint)


@kernel
def _glaze(image: Image, pixel: Pixel, normal: Vector, strength: tuple[float, float], shade: Shade) -> None:
    """A clear wall itself: denser towards its edge, bright at the rim and where the lamp is mirrored.

    ``strength`` is how much of the wall is seen, and 1 at the rim, else 0.
    """
    pose, finish, light = shade
    direction = ray(pose, pixel)
    norm = math.sqrt(direction[0] ** 2 + direction[1] ** 2 + direction[2] ** 2)
    facing = normal[0] * direction[0] + normal[1] * direction[1] + normal[2] * direction[2]
    edge = max(finish[13], 0.05 + 0.62 * (1.0 - min(1.0, abs(facing) / norm)) ** 3, 0.5 * strength[1]) * strength[0]
    value = (0.62 + 0.4 * finish[13]) * lit(pose, normal, light) + 0.4 * strength[1]
    shine = 0.75 * gleam(normal, direction, pose, light, 120.0)
    shine += 0.22 * gleam((normal[1], -normal[0], 0.0), direction, pose, light, 60.0)
    for channel in range(3):
        wall = min(255.0, finish[channel] * value * light[5 + channel])
        mixed = image[pixel[0], pixel[1], channel] * (1 - edge) + wall * edge
        image[pixel[0], pixel[1], channel] = min(255.0, mixed + strength[0] * shine * 200.0 * light[5 + channel])


@kernel
def _draw_content(layers: Layers, pixel: Pixel, walls: Walls, shade: Shade) -> None:
    """What is filled in, seen through the wall or from above."""
    image, behind, depth, _, _ = layers
    pose, finish, light = shade
    filled = walls[2]
    if filled.shape[1] < 2:
        return
    y, x = pixel
    origin, direction = (pose[0, 0], pose[0, 1], pose[0, 2]), ray(pose, pixel)
    t, normal, _, _ = profile_crossings(origin, direction, filled, filled[1].max())
    if t >= depth[y, x]:
        return
    place = at(origin, direction, t)
    value = lit(pose, normal, light)
    if finish[11] == 0.0:
        paint_filling(image, pixel, place, value, shade)
        return
    is_top = normal[2] == 1.0
    mix = 0.55 if is_top else 0.16 + (0.3 if place[2] > filled[0, -1] - 0.0025 else 0.0)
    # water in a round vessel is a lens: it shows what is behind it swapped left for right
    radius_px = filled[1, -1] / max(math.hypot(pose[1, 0], pose[2, 0]), TINY) / t
    source = _bent(pixel, normal, 0.0 if is_top else 2.6 * radius_px, pose, image.shape[1])
    for channel in range(3):
        surface = min(255.0, finish[6 + channel] * value * light[5 + channel])
        image[y, x, channel] = behind[y, source, channel] * (1 - mix) + surface * mix
