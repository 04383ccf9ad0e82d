"""Where rays meet solids: compiled kernels on single rays in a solid's own frame.

A ray is ``origin + t · direction``. Directions come from pixels and are not of unit length: they have depth 1 in the
camera's frame, so that ``t`` is the depth and linear maps of the scene leave it as it is.
"""

import math

import numpy as np

from corsmal.geometry import Floats
from corsmal.synthetic.render.kernels import Vector, kernel

INF = np.inf
TINY = 1e-12
NEAR = 0.02
"""Nothing nearer to the camera than this, in metres, is drawn."""

UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)


@kernel
def at(origin: Vector, direction: Vector, t: float) -> Vector:
    """The point of a ray at a depth."""
    return (origin[0] + t * direction[0], origin[1] + t * direction[1], origin[2] + t * direction[2])


@kernel
def sphere_entry(origin: Vector, direction: Vector, radius: float) -> float:
    """Depth at which a ray enters a sphere around the frame's origin; infinity where it misses."""
    ox, oy, oz = origin
    dx, dy, dz = direction
    a = dx * dx + dy * dy + dz * dz
    b = ox * dx + oy * dy + oz * dz
    root = b * b - a * (ox * ox + oy * oy + oz * oz - radius * radius)
    if root < 0.0:
        return INF
    t = (-b - math.sqrt(root)) / a
    return t if t > NEAR else INF


@kernel
def limb_entry(origin: Vector, direction: Vector, length: float, radii: tuple[float, float]) -> tuple[float, Vector]:
    """Where a ray enters a limb: a cone along z from 0 to ``length`` with a sphere at both ends.

    Returns:
        Depth (infinity where it misses) and normal, which is not of unit length.
    """
    z = -1.0
    if length > TINY:
        slope = (radii[1] - radii[0]) / length
        a, b, c = cone_terms(origin, direction, slope, radii[0] + slope * origin[2])
        root = b * b - a * c
        if a > TINY and root < 0.0:
            # the spheres' overhang over a slender cone is less than a pixel
            return INF, UP
        t = (-b - math.sqrt(root)) / a if a > TINY else INF
        z = origin[2] + t * direction[2] if a > TINY else -1.0
        if t > NEAR and 0.0 <= z <= length:
            x, y, _ = at(origin, direction, t)
            return t, (x, y, -slope * math.sqrt(x * x + y * y))
    best, normal = INF, UP
    if z <= length:
        best = sphere_entry(origin, direction, radii[0])
        normal = at(origin, direction, best)
    if z > length or (z < 0.0 and length > 0.0):
        beyond = (origin[0], origin[1], origin[2] - length)
        t = sphere_entry(beyond, direction, radii[1])
        if t < best:
            best, normal = t, at(beyond, direction, t)
    return best, normal


@kernel
def cone_terms(origin: Vector, direction: Vector, slope: float, at_origin: float) -> Vector:
    """a, b and c of the quadratic a t² + 2 b t + c = 0 for the depths at which a ray meets a cone around z.

    The cone's radius is ``at_origin`` at the height of the ray's origin and grows with z by ``slope``.
    """
    ox, oy, _ = origin
    dx, dy, dz = direction
    a = dx * dx + dy * dy - slope * slope * dz * dz
    b = ox * dx + oy * dy - slope * dz * at_origin
    return a, b, ox * ox + oy * oy - at_origin * at_origin


@kernel
def cylinder_span(origin: Vector, direction: Vector, radius: float, z_low: float, z_high: float) -> tuple[float, float]:
    """The depths between which a ray is inside a closed upright cylinder; the first is larger where it misses."""
    a, b, c = cone_terms(origin, direction, 0.0, radius)
    root = b * b - a * c
    if root < 0.0 or (a < TINY and c > 0.0):
        return 1.0, 0.0
    start, end = -INF, INF
    if a >= TINY:
        start, end = (-b - math.sqrt(root)) / a, (-b + math.sqrt(root)) / a
    if abs(direction[2]) < TINY:
        return (start, end) if z_low <= origin[2] <= z_high else (1.0, 0.0)
    t_low, t_high = (z_low - origin[2]) / direction[2], (z_high - origin[2]) / direction[2]
    return max(start, min(t_low, t_high)), min(end, max(t_low, t_high))


@kernel
def _cap(origin: Vector, direction: Vector, height: float, radius: float) -> float:
    """Depth at which a ray meets a level disc around z; minus infinity where it misses."""
    if abs(direction[2]) < TINY:
        return -INF
    t = (height - origin[2]) / direction[2]
    x, y, _ = at(origin, direction, t)
    return t if t > NEAR and x * x + y * y <= radius * radius else -INF


@kernel
def profile_crossings(
    origin: Vector, direction: Vector, profile: Floats, largest: float
) -> tuple[float, Vector, float, Vector]:
    """Where a ray first enters and last leaves a closed solid of revolution around z.

    ``profile`` (2, n) holds ascending heights and the radii there, of which one is the ``largest``.

    Returns:
        Depth and normal at the entry, depth and normal at the exit; infinite depths where it misses. Normals are of
        unit length and point outwards; a cap's is exactly (0, 0, ±1).
    """
    heights, radii = profile[0], profile[1]
    top = len(heights) - 1
    start, end = cylinder_span(origin, direction, largest, heights[0], heights[top])
    if start > end or end < NEAR:
        return INF, UP, INF, UP
    first, last, entry, leaving = INF, -INF, UP, UP
    for cap, height, radius in ((DOWN, heights[0], radii[0]), (UP, heights[top], radii[top])):
        t = _cap(origin, direction, height, radius)
        if t > NEAR and t < first:
            first, entry = t, cap
        if t > NEAR and t > last:
            last, leaving = t, cap
    z_start, z_end = origin[2] + start * direction[2], origin[2] + end * direction[2]
    z_low, z_high = min(z_start, z_end) - 1e-9, max(z_start, z_end) + 1e-9
    for k in range(top):
        if heights[k + 1] < z_low or heights[k] > z_high:
            continue
        slope = (radii[k + 1] - radii[k]) / (heights[k + 1] - heights[k])
        base = radii[k] + slope * (origin[2] - heights[k])
        a, b, c = cone_terms(origin, direction, slope, base)
        root = b * b - a * c
        if root < 0.0 or abs(a) < TINY:
            continue
        root = math.sqrt(root)
        for t in ((-b - root) / a, (-b + root) / a):
            x, y, z = at(origin, direction, t)
            is_met = t > NEAR and heights[k] <= z <= heights[k + 1] and base + slope * t * direction[2] >= 0.0
            if is_met and (t < first or t > last):
                radius = max(math.sqrt(x * x + y * y), TINY) * math.sqrt(1.0 + slope * slope)
                normal = (x / radius, y / radius, -slope / math.sqrt(1.0 + slope * slope))
                if t < first:
                    first, entry = t, normal
                if t > last:
                    last, leaving = t, normal
    if first == INF:
        return INF, UP, INF, UP
    return first, entry, last, leaving


@kernel
def block_entry(origin: Vector, direction: Vector, half: Vector) -> tuple[float, int, float]:
    """Where a ray enters a block of half sizes ``half`` around the frame's origin.

    Returns:
        Depth (infinity where it misses), the axis (0, 1, 2) of the face, and the face's sign.
    """
    start, end, axis = -INF, INF, 0
    for k in range(3):
        if abs(direction[k]) < TINY:
            if abs(origin[k]) > half[k]:
                return INF, 0, 1.0
            continue
        near, far = (-half[k] - origin[k]) / direction[k], (half[k] - origin[k]) / direction[k]
        if near > far:
            near, far = far, near
        if near > start:
            start, axis = near, k
        end = min(end, far)
    if start > end or start < NEAR:
        return INF, 0, 1.0
    return start, axis, -1.0 if direction[axis] > 0 else 1.0


@kernel
def grain(x: float, y: float, z: float) -> float:
    """A number in 0..1 that looks random, the same for the same whole x, y and z."""
    value = math.sin(x * 12.9898 + y * 78.233 + z * 37.719) * 43758.5453
    return value - math.floor(value)
