"""What is filled into vessels, and what the kernels that draw vessels share."""

import math

from corsmal.synthetic.render.kernels import Floats, Pixel, Vector, kernel
from corsmal.synthetic.render.shading import Depth, Image, Mask, paint
from corsmal.synthetic.render.tracing import INF, at, grain

Layers = tuple[Image, Image, Depth, Mask, Mask]
"""The image, the image before the vessel, depth, visible and amodal mask."""
Walls = tuple[Floats, Floats, Floats]
"""Profiles (2, n) in metres of the outer wall, the cavity and the filling; the last may be a single point."""
Shade = tuple[Floats, Floats, Floats]
"""Pose (7, 3), finish (14,) and light (8,)."""


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
