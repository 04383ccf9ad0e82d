"""Drawing limbs."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from corsmal.geometry import Floats
from corsmal.synthetic.render.kernels import Pixel, kernel
from corsmal.synthetic.render.shading import Depth, Image, Rays, brightness, light_values, paint
from corsmal.synthetic.render.tracing import at, limb_entry
from corsmal.synthetic.scene.limbs import Limb
from corsmal.synthetic.scene.looks import Light

_CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
STRIPE_M = 0.022
"""Width of the rings of striped limbs."""


@dataclass(frozen=True, eq=False)
class PackedLimbs:
    """Limbs as arrays, one row each; they serve every camera.

    Args:
        ends_m: (n, 2, 3) centres of the two spheres.
        radii_m: (n, 2) their radii.
        to_local: (n, 3, 3) map from the world to the limb's frame: along z, and as thick as it is wide.
        length_m: (n,) distance of the centres.
        colours: (n, 6) colour and stripe.
    """

    ends_m: Floats
    radii_m: Floats
    to_local: Floats
    length_m: Floats
    colours: Floats


def pack_limbs(limbs: list[Limb]) -> PackedLimbs:
    """Arrays of at least one limb."""
    ends = np.array([(limb.start_m, limb.end_m) for limb in limbs], dtype=np.float64)
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    axis = np.where(length[:, None] > 1e-9, along / np.maximum(length, 1e-9)[:, None], (0.0, 0.0, 1.0))
    flat = np.array([limb.flat_axis for limb in limbs], dtype=np.float64)
    flat -= axis * (flat * axis).sum(axis=1, keepdims=True)
    norm = np.linalg.norm(flat, axis=1, keepdims=True)
    spare = np.cross(axis, np.where(np.abs(axis[:, :1]) < 0.9, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    flat = np.where(norm > 1e-3, flat / np.maximum(norm, 1e-3), spare / np.linalg.norm(spare, axis=1, keepdims=True))
    thin = np.array([limb.flat for limb in limbs])[:, None]
    return PackedLimbs(
        ends_m=ends,
        radii_m=np.array([(limb.radius_start_m, limb.radius_end_m) for limb in limbs]),
        to_local=np.stack([np.cross(flat, axis), flat / thin, axis], axis=1),
        length_m=length,
        colours=np.array([(*limb.colour, *(limb.stripe or limb.colour)) for limb in limbs], dtype=np.float64),
    )


def draw_limbs(image: Image, depth: Depth, limbs: PackedLimbs, *, rays: Rays, light: Light) -> None:
    """Draw limbs into an image where they are nearer than what is there.

    ``image`` (H, W, 3) RGB and ``depth`` (H, W), metres, are changed.
    """
    to_camera = rays.centre_m - limbs.ends_m[:, 0]
    table = np.concatenate(
        [
            limbs.to_local.reshape(-1, 9),
            np.einsum("nij,nj->ni", limbs.to_local, to_camera),
            (limbs.to_local @ rays.matrix).reshape(-1, 9),
            limbs.length_m[:, None],
            limbs.radii_m,
            limbs.colours,
        ],
        axis=1,
    )
    corners = (limbs.ends_m[:, :, None] + _CORNERS * limbs.radii_m[:, :, None, None]).reshape(-1, 16, 3)
    # from near to far, so that little is shaded that something else then hides
    order = np.argsort((to_camera**2).sum(axis=1))
    _draw(image, depth, table[order], rays.windows(corners)[order], light_values(light))


@kernel
def _draw(image: Image, depth: Depth, table: Floats, windows: NDArray[np.int64], light: Floats) -> None:
    for index in range(len(table)):
        p = table[index]
        origin, length, radii = (p[9], p[10], p[11]), p[21], (p[22], p[23])
        step = (p[12], p[15], p[18])
        x0, x1, y0, y1 = windows[index]
        for y in range(y0, y1):
            begin = (p[13] * y + p[14], p[16] * y + p[17], p[19] * y + p[20])
            for x in range(x0, x1):
                direction = at(begin, step, x)
                t, normal = limb_entry(origin, direction, length, radii)
                if t < depth[y, x]:
                    depth[y, x] = t
                    _shade(image, (y, x), p, (normal[0], normal[1], normal[2], origin[2] + t * direction[2]), light)


@kernel
def _shade(image: Image, pixel: Pixel, p: Floats, surface: tuple[float, float, float, float], light: Floats) -> None:
    """Paint a pixel, ``surface`` being the normal and z in the limb's frame."""
    nx, ny, nz, z = surface
    normal = (
        p[0] * nx + p[3] * ny + p[6] * nz,
        p[1] * nx + p[4] * ny + p[7] * nz,
        p[2] * nx + p[5] * ny + p[8] * nz,
    )
    value = brightness(normal, light)
    first = 27 if math.floor(z / STRIPE_M) % 2 else 24
    paint(image, pixel, (p[first], p[first + 1], p[first + 2]), value, light)
