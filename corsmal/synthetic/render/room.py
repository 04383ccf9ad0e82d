"""The room that does not move: walls, window sill or curtain, table, and the shadows on the table."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from corsmal.geometry import Floats
from corsmal.synthetic.render.shading import Depth, Image, Rays
from corsmal.synthetic.scene.furniture import Furniture
from corsmal.synthetic.scene.looks import Light, Look

TABLE_THICKNESS_M = 0.028
DEPTH_MAX_M = 50.0
WALL, SIDE_WALL, FLOOR = 0, 1, 2

Grid = NDArray[np.float32]
Body = tuple[Floats, float, float]
"""Where something is (3,), its radius in metres, and the share of the light that it takes, 0..1."""


def draw_room(furniture: Furniture, look: Look, light: Light, rays: Rays) -> tuple[Image, Depth, NDArray[np.bool_]]:
    """The empty room.

    Returns:
        (H, W, 3) uint8 RGB; (H, W) float32 depth in metres; (H, W) bool, where the table's top is.
    """
    dx, dy, dz = _directions(rays, (0, rays.size[0], 0, rays.size[1]))
    ox, oy, oz = (np.float32(value) for value in rays.centre_m)
    with np.errstate(divide="ignore"):
        depths = np.stack(
            [
                np.where(dy < 0, (np.float32(furniture.wall_y_m) - oy) / dy, DEPTH_MAX_M),
                np.where(dx < 0, (np.float32(furniture.side_x_m) - ox) / dx, DEPTH_MAX_M),
                np.where(dz < 0, (np.float32(furniture.floor_z_m) - oz) / dz, DEPTH_MAX_M),
            ]
        )
    surface = depths.argmin(axis=0)
    t = depths.min(axis=0)
    table, is_top = _table_depth((ox, oy, oz), (dx, dy, dz), furniture)
    is_table = table < t
    t = np.where(is_table, table, t)
    x, y, z = ox + t * dx, oy + t * dy, oz + t * dz
    colour, value = _walls(furniture, look, light, surface, (x, y, z))
    colour[is_table] = look.table
    value[is_table] = _table_value(furniture, light, x[is_table], y[is_table], is_top[is_table])
    image = np.clip(colour * value[..., None] * np.array(light.gains, dtype=np.float32), 0, 255).astype(np.uint8)
    return image, t.astype(np.float32), is_table & is_top


def draw_shadows(
    image: Image, is_table: NDArray[np.bool_], bodies: Sequence[Body], *, table_z_m: float, rays: Rays, light: Light
) -> None:
    """Darken the table's top before anything stands on it: the higher a body, the softer and further from the lamp.

    ``image`` (H, W, 3) is changed where ``is_table`` (H, W); every body throws a round shadow.
    """
    x_shift, y_shift = (-light.direction[k] / max(light.direction[2], 0.2) for k in (0, 1))
    for place_m, radius_m, strength in bodies:
        rise = max(float(place_m[2]) - table_z_m, 0.0)
        softness_m, strongest = 0.012 + 0.35 * rise, strength * max(0.0, 1 - rise / 0.35)
        middle_x, middle_y = place_m[0] + x_shift * (rise + 0.02), place_m[1] + y_shift * (rise + 0.02)
        reach = radius_m + softness_m
        corners = [[middle_x + i * reach, middle_y + j * reach, table_z_m] for i in (-1, 1) for j in (-1, 1)]
        x0, x1, y0, y1 = rays.windows(np.array(corners))
        if x0 >= x1 or y0 >= y1:
            continue
        dx, dy, dz = _directions(rays, (x0, x1, y0, y1))
        t = np.float32(table_z_m - rays.centre_m[2]) / dz
        x = t * dx + np.float32(rays.centre_m[0] - middle_x)
        y = t * dy + np.float32(rays.centre_m[1] - middle_y)
        share = np.clip((reach - np.sqrt(x * x + y * y)) / np.float32(2 * softness_m), 0, 1)
        factor = 1 - np.float32(strongest) * share * share * (3 - 2 * share) * is_table[y0:y1, x0:x1]
        image[y0:y1, x0:x1] = (image[y0:y1, x0:x1] * factor[..., None]).astype(np.uint8)


def _directions(rays: Rays, window: tuple[int, int, int, int]) -> tuple[Grid, Grid, Grid]:
    """The rays' directions in the world for a window (x0, x1, y0, y1) of the image, float32."""
    x0, x1, y0, y1 = window
    columns = np.arange(x0, x1, dtype=np.float32)
    rows = np.arange(y0, y1, dtype=np.float32)[:, None]
    matrix = rays.matrix.astype(np.float32)
    first, second, third = (row[0] * columns + (row[1] * rows + row[2]) for row in matrix)
    return first, second, third


def _table_depth(
    origin: tuple[np.float32, ...], direction: tuple[Grid, Grid, Grid], furniture: Furniture
) -> tuple[Grid, NDArray[np.bool_]]:
    """Depth of the table (large where it is missed), and whether it is its top that is met."""
    x0, x1, y0, y1, top = furniture.table_m
    start, end = np.zeros_like(direction[0]), np.full_like(direction[0], DEPTH_MAX_M)
    is_top = np.zeros(direction[0].shape, dtype=np.bool_)
    for axis, (low, high) in enumerate(((x0, x1), (y0, y1), (top - TABLE_THICKNESS_M, top))):
        way = np.where(np.abs(direction[axis]) < 1e-9, np.float32(1e-9), direction[axis])
        first, second = (np.float32(low) - origin[axis]) / way, (np.float32(high) - origin[axis]) / way
        near = np.minimum(first, second)
        is_top = (near > start) & (way < 0) if axis == 2 else is_top
        start, end = np.maximum(start, near), np.minimum(end, np.maximum(first, second))
    return np.where(start < end, start, DEPTH_MAX_M), is_top


def _table_value(furniture: Furniture, light: Light, x: Grid, y: Grid, is_top: NDArray[np.bool_]) -> Grid:
    """Brightness of the table: grain of the wood, and at its far end the bright wall mirrored."""
    phase = furniture.phase
    value = 0.9 + 0.045 * np.sin(90 * y + 3 * np.sin(5 * x + phase) + 2 * np.sin(31 * y + phase))
    value += 0.015 * np.sin(400 * y + 8 * np.sin(3 * x))
    lit = light.ambient + light.lamp * max(0.3, light.direction[2])
    value *= np.where(is_top, lit, 0.62 * light.ambient)
    return np.asarray(value * (1 + 0.1 * np.clip((0.35 - y) * 2, 0, 1) * is_top), dtype=np.float32)


def _walls(
    furniture: Furniture, look: Look, light: Light, surface: NDArray[np.intp], place: tuple[Grid, Grid, Grid]
) -> tuple[Grid, Grid]:
    """Colours (H, W, 3) and brightness (H, W) of walls and floor."""
    x, _, z = place
    value = light.ambient + light.lamp * (0.42 + 0.2 * np.clip(z, -1, 1) + 0.12 * np.sin(0.9 * x + furniture.phase))
    value = value * np.array([1.0, 0.9, 0.5], dtype=np.float32)[surface]
    is_side, is_back = surface == SIDE_WALL, surface == WALL
    value[is_side] *= _sill(z[is_side])
    value[(surface != FLOOR) & (z < furniture.floor_z_m + 0.1)] *= 0.75
    colour = np.empty((*value.shape, 3), dtype=np.float32)
    colour[:] = look.wall
    if furniture.background:
        _decorate(colour, value, is_back, place=place, furniture=furniture, look=look)
    return colour, value.astype(np.float32)


def _sill(z: Grid) -> Grid:
    """How bright a wall is with a window sill and a pipe below it."""
    pipe = 0.8 + 0.36 * np.sin(np.clip((z - 0.02) / 0.04, 0, 1) * np.pi)
    bands = [(z > 0.16) & (z < 0.19), (z > 0.12) & (z <= 0.16), (z > 0.02) & (z < 0.06)]
    return np.select(bands, [np.full_like(z, 1.16), np.full_like(z, 0.78), pipe], default=np.float32(1))


def _decorate(
    colour: Grid,
    value: Grid,
    is_back: NDArray[np.bool_],
    *,
    place: tuple[Grid, Grid, Grid],
    furniture: Furniture,
    look: Look,
) -> None:
    """Pictures on the wall behind, and a curtain at one side of it; ``colour`` and ``value`` are changed."""
    x, _, z = place
    curtain = is_back & (x > furniture.table_m[1] + 0.25 + 0.1 * np.sin(furniture.phase))
    bare = is_back & ~curtain
    for number, (x0, x1, z0, z1) in enumerate(furniture.pictures_m):
        border = np.minimum(np.minimum(x - x0, x1 - x), np.minimum(z - z0, z1 - z))
        inside, frame = bare & (border > 0.015), bare & (border > 0) & (border <= 0.015)
        value[frame] *= 0.45
        colour[inside] = look.accent
        value[inside] *= 0.7 + 0.3 * np.sin(9 * x[inside] + number) + 0.22 * np.sin(13 * z[inside] + 2 * number)
    colour[curtain] = look.accent
    value[curtain] *= 0.82 + 0.2 * np.sin(x[curtain] * 46 + np.sin(z[curtain] * 3 + furniture.phase))
