"""Capacity and dimensions from the radii of a hull (paper 3.2, equations 6 to 8)."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from corsmal.geometry import Floats
from corsmal.parameters import ShapeParameters
from corsmal.shape.records import Dimensions, Hull
from corsmal.shape.steps import kept_steps, metres_of, step_ends

CUBIC_MM_PER_ML = 1000.0
SAME_MM = 1e-6
"""Differences of radii closer than this are equal: radii lie on a grid, so equal steps differ by rounding only."""

STEM_SHARE, STEM_HIGHEST = 0.3, 0.9
"""A stem is narrower than this share of the widest place, and lies below this share of the height."""


def measure_hull(hull: Hull, parameters: ShapeParameters | None = None) -> Dimensions:
    """Capacity, widths and height of a hull.

    Only converged circumferences count. The capacity is the volume of the conical frusta between neighbours among
    them (equation 6), less the wall where ``wall_mm`` gives one. Where the widths or the height are those of the
    profile's ``ends``, radii that differ from the next by more than ``max_difference_mm`` are dropped and the ends of
    the remaining profile are found by equations 7 and 8; with ``widest``, both widths are twice the largest radius;
    with ``whole`` the profile is taken as it is; for ``steps`` see ``corsmal.shape.steps``.

    Args:
        hull: the fitted hull.
        parameters: ``max_difference_mm``, ``width_rule``, ``height_rule`` and ``wall_mm`` are used, with ``steps`` also
            the radii that were tried; default: the paper's.

    Returns:
        Dimensions; ``ok`` is false, with a reason, where the hull failed, too few radii remain (two are needed for
        ``steps`` and ``extent`` together, else three), or the upper end does not lie above the lower one. With
        ``steps`` a width may be None by itself, see ``Dimensions.unmeasured``.
    """
    parameters = parameters or ShapeParameters.paper()
    if not hull.ok:
        return Dimensions(reason=hull.reason)
    converged = np.flatnonzero(hull.converged)
    has_steps = parameters.width_rule == "steps"
    if len(converged) < (2 if has_steps and parameters.height_rule == "extent" else 3):
        return Dimensions(reason=f"only {len(converged)} of {len(hull.converged)} circumferences fit the masks")
    kept, bottom, top = converged, 0, len(converged) - 1
    if parameters.width_rule == "ends" or (has_steps and parameters.height_rule == "ends"):
        kept = converged[smooth(hull.radii_mm[converged], max_difference_mm=parameters.max_difference_mm)]
        if len(kept) < 3:
            return Dimensions(
                kept=kept, reason=f"smoothing left {len(kept)} of {len(converged)} radii: d_max is too small"
            )
        bottom, top = profile_ends(hull.radii_mm[kept])
        if top <= bottom:
            return Dimensions(kept=kept, reason="the upper end of the profile was found below its lower end")
    ends = kept[[bottom, top]] if parameters.height_rule == "ends" else converged[[0, -1]]
    found = Dimensions(
        capacity_ml=capacity_ml(hull, wall_mm=parameters.wall_mm),
        height_mm=float(hull.heights_mm[ends[1]] - hull.heights_mm[ends[0]]),
        kept=kept,
        bottom=int(kept[bottom]),
        top=int(kept[top]),
    )
    if has_steps:
        return _with_step_widths(found, hull, converged, parameters)
    radii = hull.radii_mm[kept]
    widths = radii[[bottom, top]] if parameters.width_rule != "widest" else radii.max().repeat(2)
    return replace(found, width_bottom_mm=2 * float(widths[0]), width_top_mm=2 * float(widths[1]))


def _with_step_widths(
    found: Dimensions, hull: Hull, converged: NDArray[np.intp], parameters: ShapeParameters
) -> Dimensions:
    """The dimensions with the widths of the authors' program, and where it measures them."""
    radii_m = metres_of(hull.radii_mm[converged], parameters)
    places = kept_steps(radii_m, max_difference_m=parameters.max_difference_mm / 1000)
    kept = converged[places]
    bottom, top = (None if end is None else int(kept[end]) for end in step_ends(radii_m[places]))
    why = f"{len(kept)} radii are kept" if len(kept) < 2 else "no step between the kept radii is smaller than another"
    ends = {"width_bottom_mm": bottom, "width_top_mm": top}
    widths: dict[str, Any] = {name: end if end is None else 2 * float(hull.radii_mm[end]) for name, end in ends.items()}
    return replace(
        found,
        **widths,
        kept=kept,
        bottom=bottom,
        top=top,
        unmeasured={name: why for name, end in ends.items() if end is None},
    )


def capacity_ml(hull: Hull, *, wall_mm: float = 0.0) -> float:
    """What a container of a hull's outer shape holds, in mL, by the hull's converged circumferences.

    ``wall_mm`` is how much smaller the cavity's radius is. Where it is not 0, what lies below a stem's narrowest place
    is left out as well: no liquid gets there. A box's wall is thin: its capacity is its volume.
    """
    heights, radii = hull.heights_mm[hull.converged], hull.radii_mm[hull.converged]
    if hull.depth_mm is not None:
        return float(np.trapezoid(2 * radii * hull.depth_mm, heights)) / CUBIC_MM_PER_ML
    if wall_mm > 0 and len(radii):
        start = _bowl_start(radii)
        heights, radii = heights[start:], np.maximum(radii[start:] - wall_mm, 0.0)
    return frusta_volume_ml(heights, radii)


def _bowl_start(radii_mm: Floats) -> int:
    """Index of a stem's narrowest circumference, 0 where there is no stem."""
    foot = len(radii_mm) // 10
    narrowest = foot + int(np.argmin(radii_mm[foot:]))
    is_stem = radii_mm[narrowest] < STEM_SHARE * radii_mm.max() and narrowest < STEM_HIGHEST * len(radii_mm)
    return narrowest if is_stem else 0


def frusta_volume_ml(heights_mm: Floats, radii_mm: Floats) -> float:
    """Volume of the conical frusta between circumferences, (n,) ascending heights and radii (equation 6)."""
    lower, upper = radii_mm[:-1], radii_mm[1:]
    return float(np.pi / 3 * np.sum((upper**2 + upper * lower + lower**2) * np.diff(heights_mm)) / CUBIC_MM_PER_ML)


def smooth(radii_mm: Floats, *, max_difference_mm: float) -> NDArray[np.bool_]:
    """Which radii (n,) remain: one is dropped if the next differs from it by more than d_max. The last one stays."""
    differences = np.abs(np.diff(radii_mm, append=radii_mm[-1:]))
    return differences <= max_difference_mm + SAME_MM


def profile_ends(radii_mm: Floats) -> tuple[int, int]:
    """Where a smoothed profile (n',) begins and ends (equations 7 and 8).

    Outside the container the fitted radii change fast. Going up, the lower end is the first radius whose step to the
    next is smaller than the step before it; the upper end is the last whose step is smaller than the one after it.

    Returns:
        0-based positions of the lower and the upper end; the first and the last where the equations' sets are empty.
    """
    steps = np.abs(np.diff(radii_mm))
    slowing = np.flatnonzero(steps[:-1] > steps[1:] + SAME_MM)
    quickening = np.flatnonzero(steps[:-1] < steps[1:] - SAME_MM)
    bottom = int(slowing[0]) + 1 if len(slowing) else 0
    top = int(quickening[-1]) if len(quickening) else len(radii_mm) - 1
    return bottom, top
