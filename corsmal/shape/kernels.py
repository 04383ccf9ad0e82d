"""The compiled loops of the fit."""

import math

import numba
import numpy as np


@numba.njit(nogil=True, cache=True)
def first_fitting_radius(  # type: ignore[no-untyped-def]  # noqa: PLR0917 - compiled code takes no keywords
    masks, corners, sizes, hubs, spokes, radii_m, all_views, truncated
):  # pragma: no cover - compiled
    """Index of the first radius whose circumference fits, per height; ``len(radii_m)`` where none does.

    Args: masks V cropped (h, w) bool; corners (V, 2) the crops' top-left pixels; sizes (V, 2) width and height of the
    images; hubs (V, L, 3) the projected centres and spokes (V, N, 3) the projected unit radii, homogeneous pixels;
    radii_m (R,); all_views: whether every view must agree, or one is enough; truncated: the rule for pixels.

    A circumference that does not fit mostly fails where its larger neighbour failed, so that point is tried first: one
    look-up then settles most of them. The answer is the same in any order.
    """
    n_views, n_heights, n_radii = len(masks), hubs.shape[1], len(radii_m)
    needed = n_views if all_views else 1
    first = np.full(n_heights, n_radii)
    suspects = np.zeros(n_views, dtype=np.int64)
    for h in range(n_heights):
        for r in range(n_radii):
            fitting = 0
            for v in range(n_views):
                outside = _point_outside(
                    masks[v], corners[v], sizes[v], hubs[v, h], spokes[v], radii_m[r], truncated, suspects[v]
                )
                if outside < 0:
                    fitting += 1
                else:
                    suspects[v] = outside
            if fitting >= needed:
                first[h] = r
                break
    return first


@numba.njit(nogil=True, cache=True)
def _point_outside(  # type: ignore[no-untyped-def]  # noqa: PLR0917 - compiled code takes no keywords
    mask, corner, size, hub, spokes, radius_m, truncated, suspect
):  # pragma: no cover - compiled
    """Index of a point of one circumference that is off the mask, -1 where all are on it; ``suspect`` is tried first.

    Args: as above, of one view and one circumference.
    """
    for k in range(len(spokes)):
        p = (suspect + k) % len(spokes)
        depth = hub[2] + radius_m * spokes[p, 2]
        if depth <= 0:
            return p
        x, y = (hub[0] + radius_m * spokes[p, 0]) / depth, (hub[1] + radius_m * spokes[p, 1]) / depth
        if truncated:
            column, row = _truncated(x, size[0]) - corner[0], _truncated(y, size[1]) - corner[1]
        else:
            column, row = math.floor(x + 0.5) - corner[0], math.floor(y + 0.5) - corner[1]
        if row < 0 or column < 0 or row >= mask.shape[0] or column >= mask.shape[1] or not mask[row, column]:
            return p
    return -1


@numba.njit(nogil=True, cache=True)
def _truncated(place, length):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """A coordinate of a side of ``length`` pixels, by the rule ``truncated``."""
    if place >= length:
        return length - 1
    pixel = int(place)
    return pixel if pixel >= 0 else pixel + length
