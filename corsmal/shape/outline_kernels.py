"""The compiled loops that read a mask's outline in the plane through the axis."""

import numba
import numpy as np


@numba.njit(nogil=True, cache=True, error_model="numpy")
def ends_of_rows(  # type: ignore[no-untyped-def]  # noqa: PLR0917 - compiled code takes no keywords
    plane, first_mm, low_mm, pixels_from_mm, border_px, last_px
):  # pragma: no cover - compiled
    """Where each row of the plane first and last crosses one half, (2, rows) mm, between columns too.

    NaN where it never does, or where the picture ends, not the container.

    Args: plane (rows, columns) the mask, between 0 and 1, one millimetre apart; first_mm of the first column; low_mm of
    the first row; pixels_from_mm (3, 3) homogeneous pixels of places in the plane; border_px and last_px (2,) the
    coordinates of pixels that are inside of the picture.
    """
    rows, columns = plane.shape
    ends = np.full((2, rows), np.nan)
    for row in range(rows):
        for end in range(2):
            step = -1 if end == 0 else 1
            column = 0 if end == 0 else columns - 1
            while 0 <= column < columns and plane[row, column] < 0.5:
                column -= step
            if not 0 <= column < columns:
                break
            inside, outside = (
                np.float64(plane[row, column]),
                np.float64(plane[row, min(max(column + step, 0), columns - 1)]),
            )
            share = (inside - 0.5) / max(inside - outside, 1e-6) if inside > outside else 0.5
            place = first_mm + (column + step * share)
            x, y = place, low_mm + row
            depth = pixels_from_mm[2, 0] * x + pixels_from_mm[2, 1] * y + pixels_from_mm[2, 2]
            is_inside = True
            for axis in range(2):
                at = pixels_from_mm[axis, 0] * x + pixels_from_mm[axis, 1] * y + pixels_from_mm[axis, 2]
                is_inside &= border_px <= at / depth <= last_px[axis]
            if is_inside:
                ends[end, row] = place
    return ends


@numba.njit(nogil=True, cache=True, error_model="numpy")
def middle_of_missing(  # type: ignore[no-untyped-def]  # noqa: PLR0917 - compiled code takes no keywords
    reach_mm, first_mm, heights_mm, radii_mm, overhangs_mm, shares, sign
):  # pragma: no cover - compiled
    """How far beyond the silhouettes of circles a mask reaches, (n,) mm, see ``FacingView.missing_mm``.

    Args: reach_mm (columns,) where the mask ends, one millimetre apart; first_mm of the first column; heights_mm,
    radii_mm and overhangs_mm (n,) of the circles and how far their silhouettes reach beyond them in the middle; shares
    (m,) of the radius; sign: 1 upwards, -1 downwards.
    """
    middles, ordered = np.full(len(heights_mm), np.nan), np.empty(len(shares))
    for row in range(len(heights_mm)):
        seen = 0
        for share in shares:
            column = int(np.rint(radii_mm[row] * share - first_mm))
            if 0 <= column < len(reach_mm) and not np.isnan(reach_mm[column]):
                expected = heights_mm[row] + overhangs_mm[row] * np.sqrt(1 - share**2)
                missing, place = sign * (reach_mm[column] - expected), seen
                while place > 0 and ordered[place - 1] > missing:
                    ordered[place] = ordered[place - 1]
                    place -= 1
                ordered[place] = missing
                seen += 1
        if seen:
            middles[row] = ordered[(seen - 1) // 2]
    return middles
