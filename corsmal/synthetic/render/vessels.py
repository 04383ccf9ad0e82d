"""Vessels: opaque and see-through solids of revolution with what is filled in."""

import math
from dataclasses import dataclass

import numpy as np

from corsmal.geometry import Floats
from corsmal.synthetic.render.glass import draw_clear
from corsmal.synthetic.render.kernels import Pixel, kernel
from corsmal.synthetic.render.shading import (
    Depth,
    Image,
    Layers,
    Mask,
    Rays,
    Shade,
    Walls,
    Window,
    gleam,
    lit,
    paint,
    paint_filling,
    ray,
    solid_pose,
    surface_of_filling,
)
from corsmal.synthetic.render.tracing import INF, at, profile_crossings
from corsmal.synthetic.scene.looks import Colour
from corsmal.synthetic.scene.profiles import Profile

FILLING_COLOURS: tuple[Colour, ...] = ((0, 0, 0), (222, 178, 92), (234, 228, 212), (196, 214, 222))
"""Of none, pasta, rice and water."""

GRAIN_SIZES_M = (0.01, 0.006, 0.0022, 0.01)
_CIRCLE = np.linspace(0, 2 * np.pi, 24, endpoint=False)
_CIRCUMSCRIBED = 1 / math.cos(math.pi / 24)


@dataclass(frozen=True, eq=False)
class Vessel:
    """A solid of revolution as it is drawn.

    Args:
        colour: RGB of the wall; of a see-through one, its tint.
        inside: RGB of the cavity's wall.
        is_clear: whether one can see through it.
        ridges_m: distance of rings in the wall; 0 where it is smooth.
        fill_height_mm: how high the filling stands above the base.
        tint: how much of its colour a see-through wall lends to what is behind, 0..1.
        veil: how much a milky wall hides of what is filled in, 0..1.
    """

    outer: Profile
    inner: Profile
    colour: Colour
    inside: Colour
    is_clear: bool
    ridges_m: float = 0.0
    filling_type: int = 0
    fill_height_mm: float = 0.0
    tint: float = 0.12
    veil: float = 0.0


def draw_vessel(
    image: Image, depth: Depth, vessel: Vessel, *, base_m: Floats, rotation: Floats, rays: Rays, light: Floats
) -> tuple[Mask, Mask]:
    """Draw a vessel into an image where it is nearer than what is there.

    ``image`` (H, W, 3) RGB is changed, and ``depth`` (H, W), metres, unless the vessel is see-through. ``base_m`` (3,)
    is the point of its axis at its base, ``rotation`` (3, 3) leads from the vessel to the world.

    Returns:
        (H, W) bool: its visible pixels, and all pixels of its silhouette.
    """
    visible, amodal = np.zeros(depth.shape, dtype=np.bool_), np.zeros(depth.shape, dtype=np.bool_)
    outer, inner = _in_metres(vessel.outer), _in_metres(vessel.inner)
    window = rays.windows(base_m + _hull_points(outer) @ rotation.T)
    if window[0] >= window[1] or window[2] >= window[3]:
        return visible, amodal
    has_filling = vessel.filling_type > 0 and vessel.fill_height_mm > vessel.inner.heights_mm[0] + 0.5
    filled = _in_metres(vessel.inner.below(vessel.fill_height_mm)) if has_filling else inner[:, :1].copy()
    finish = np.array(
        [
            *vessel.colour, *vessel.inside, *FILLING_COLOURS[vessel.filling_type],
            GRAIN_SIZES_M[vessel.filling_type], vessel.ridges_m, float(vessel.filling_type == 3), vessel.tint,
            vessel.veil,
        ]
    )  # fmt: skip
    layers = (image, image.copy() if vessel.is_clear else image, depth, visible, amodal)
    draw = draw_clear if vessel.is_clear else _draw_opaque
    draw(layers, window, (outer, inner, filled), (solid_pose(base_m, rotation, rays), finish, light))
    return visible, amodal


def _in_metres(profile: Profile) -> Floats:
    return np.ascontiguousarray(np.stack([profile.heights_mm, profile.radii_mm])) / 1000


def _hull_points(profile: Floats) -> Floats:
    heights, radii = profile
    points = np.empty((len(heights), len(_CIRCLE), 3))
    points[:, :, 0] = radii[:, None] * _CIRCUMSCRIBED * np.cos(_CIRCLE)
    points[:, :, 1] = radii[:, None] * _CIRCUMSCRIBED * np.sin(_CIRCLE)
    points[:, :, 2] = heights[:, None]
    return points.reshape(-1, 3)


@kernel
def _draw_opaque(layers: Layers, window: Window, walls: Walls, shade: Shade) -> None:
    image, _, depth, visible, amodal = layers
    pose, finish, light = shade
    outer, inner, _ = walls
    origin, top, largest = (pose[0, 0], pose[0, 1], pose[0, 2]), outer[0, -1], outer[1].max()
    for y in range(window[2], window[3]):
        for x in range(window[0], window[1]):
            direction = ray(pose, (y, x))
            t, normal, _, _ = profile_crossings(origin, direction, outer, largest)
            if t == INF:
                continue
            amodal[y, x] = True
            if t >= depth[y, x]:
                continue
            px, py, pz = at(origin, direction, t)
            if normal[2] == 1.0 and pz > top - 1e-6 and px * px + py * py < inner[1, -1] ** 2:
                # what stands in the mouth, such as a stream, hides the cavity behind it
                visible[y, x] = _draw_cavity(image, (y, x), depth[y, x], walls, shade)
                depth[y, x] = t if visible[y, x] else depth[y, x]
                continue
            visible[y, x] = True
            depth[y, x] = t
            value = lit(pose, normal, light) + 0.3 * gleam(normal, direction, pose, light, 40.0)
            if finish[10] > 0.0:
                value *= 1.0 + 0.06 * math.sin(2 * math.pi * pz / finish[10])
            value *= 1.06 if pz > top - 0.003 else 1.0
            paint(image, (y, x), (finish[0], finish[1], finish[2]), value, light)


@kernel
def _draw_cavity(image: Image, pixel: Pixel, limit: float, walls: Walls, shade: Shade) -> bool:
    """Inside of an opaque vessel, seen through its mouth; false where something stands in front of it."""
    pose, finish, light = shade
    _, inner, filled = walls
    origin, direction = (pose[0, 0], pose[0, 1], pose[0, 2]), ray(pose, pixel)
    _, _, t, normal = profile_crossings(origin, direction, inner, inner[1].max())
    level = surface_of_filling(origin, direction, filled)
    t = min(t, level)
    if t >= limit:
        return False
    place = at(origin, direction, t)
    shadow = 1.0 - 0.5 * (inner[0, -1] - place[2]) / (inner[0, -1] - inner[0, 0])
    if t == level:
        paint_filling(image, pixel, place, shadow, shade)
    else:
        value = (0.5 * lit(pose, (-normal[0], -normal[1], -normal[2]), light) + 0.45) * shadow
        paint(image, pixel, (finish[3], finish[4], finish[5]), value, light)
    return True
