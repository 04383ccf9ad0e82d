"""Fitting a solid of revolution to the container's masks (paper 3.2, after LoDE)."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from corsmal.errors import ArgumentError
from corsmal.geometry import Camera, Floats, parallax_deg, triangulate
from corsmal.parameters import PixelRule, ShapeParameters
from corsmal.shape.cropped import Cropped, Mask
from corsmal.shape.outline_fit import fit_outlines
from corsmal.shape.records import Hull
from corsmal.shape.sections import unit_circle

PARALLAX_MIN_DEG = 1.0
"""Below this angle between the rays a pixel's error moves the centroid by more than a decimetre at arm's length."""

AXIS_REACH_M = 0.5
AXIS_STEP_M = 0.0005


def fit_hull(cameras: Sequence[Camera], masks: Sequence[Mask], parameters: ShapeParameters | None = None) -> Hull:
    """Fit a solid of revolution to one mask per camera.

    The centroids of the masks' largest contours are triangulated; the vertical axis passes through that point. At each
    height the radius shrinks from r_max until the circumference's points fall on the mask of any view (the paper's
    change) or of all views (LoDE's rule). With the method ``outlines`` that axis is only where the search begins, see
    ``corsmal.shape.outline_fit``.

    Args:
        cameras: two or more calibrated cameras.
        masks: per camera an (H, W) bool mask of the container, of the camera's size.
        parameters: default: the paper's.

    Returns:
        The hull; ``ok`` is false, with a reason, where a mask is empty or has no area, the rays are nearly parallel,
        the axis meets no mask, or no solid explains the masks.

    Raises:
        ArgumentError: fewer than two views, unequal numbers, or a mask that is not bool or not of its camera's size.

    Example:
        >>> hull = fit_hull([camera_3, camera_1], [mask_3, mask_1], ShapeParameters.paper())  # doctest: +SKIP
        >>> hull.radii_mm.shape  # doctest: +SKIP
        (145,)
    """
    parameters = parameters or ShapeParameters.paper()
    check_masks(cameras, masks)
    return fit_cropped(cameras, [Cropped.of(mask) for mask in masks], parameters)


def fit_cropped(cameras: Sequence[Camera], masks: Sequence[Cropped], parameters: ShapeParameters) -> Hull:
    """As ``fit_hull``, of masks without the empty pixels around them."""
    centroids = []
    for number, mask in enumerate(masks, start=1):
        if mask.centroid is None:
            return Hull.failed(f"mask {number} of {len(masks)} {'has no area' if mask.count else 'is empty'}")
        centroids.append(mask.centroid)
    centroid_m = triangulate(cameras, centroids, has_unit_rows=parameters.triangulation == "unit rows")
    if not np.isfinite(centroid_m).all() or parallax_deg(cameras, centroid_m) < PARALLAX_MIN_DEG:
        return Hull.failed("the views' rays through the mask centroids are nearly parallel")
    if not np.isfinite(np.vstack([camera.project(centroid_m[None]) for camera in cameras])).all():
        return Hull.failed("the masks' centroids meet behind a camera: they show different objects")
    if parameters.method == "outlines":
        return fit_outlines(cameras, masks, centroid_m, parameters)
    return _fit_circumferences(cameras, masks, centroid_m, parameters)


def _fit_circumferences(
    cameras: Sequence[Camera],
    masks: Sequence[Cropped],
    centroid_m: Floats,
    parameters: ShapeParameters,
) -> Hull:
    """The hull about the vertical axis through the centroid, circumference by circumference."""
    heights_m = _heights(cameras, masks, centroid_m, parameters)
    if heights_m is None:
        return Hull.failed("the vertical axis through the centroid meets no mask", centroid_m=centroid_m)
    radii_mm = np.linspace(parameters.radius_max_mm, parameters.radius_min_mm, parameters.radii)
    projections = np.array([camera.projection for camera in cameras])
    sizes = np.array([camera.size for camera in cameras], dtype=np.int64)
    axis = np.column_stack([np.tile(centroid_m[:2], (len(heights_m), 1)), heights_m, np.ones(len(heights_m))])
    hubs = axis @ projections.transpose(0, 2, 1)
    circle = unit_circle(parameters.points, angle_rule=parameters.angle_rule)
    spokes = circle @ projections[:, :, :2].transpose(0, 2, 1)
    is_truncated = parameters.pixel_rule == "truncated"
    if is_truncated and _leaves_images(hubs, radii_mm[0] / 1000 * spokes, sizes):
        problem = "circumferences lie more than a picture's size beyond its left or upper border"
        return Hull.failed(problem, centroid_m=centroid_m)
    from corsmal.shape.kernels import first_fitting_radius  # noqa: PLC0415 - Numba takes long to import

    first = first_fitting_radius(
        tuple(mask.pixels for mask in masks),
        np.array([(mask.left, mask.top) for mask in masks], dtype=np.int64),
        sizes,
        hubs,
        spokes,
        radii_mm / 1000,
        parameters.fit_rule == "all",
        is_truncated,
    )
    converged = first < parameters.radii
    fitted_mm = radii_mm[np.minimum(first, parameters.radii - 1)]
    return Hull(heights_m * 1000, fitted_mm, converged, centroid_m)


def _leaves_images(hubs: Floats, spokes: Floats, sizes: NDArray[np.int64]) -> bool:
    """Whether a pixel of (V, L, 3) centres with (V, N, 3) spokes cannot be counted from the opposite border either.

    Truncated, x / depth is below −width where x + (width + 1) · depth is not positive: that is linear in the points.
    """
    beyond = [places[..., :2] + (sizes[:, None] + 1) * places[..., 2:] for places in (hubs, spokes)]
    return bool((beyond[0].min(axis=1) + beyond[1].min(axis=1) <= 0).any())


def check_masks(cameras: Sequence[Camera], masks: Sequence[Mask]) -> None:
    """Refuse masks that do not belong to the cameras, and fewer than two; see ``fit_hull``."""
    if len(cameras) != len(masks) or len(cameras) < 2:
        raise ArgumentError(f"a hull needs one mask for each of two or more cameras, got {len(cameras)}, {len(masks)}")
    for camera, mask in zip(cameras, masks, strict=True):
        if mask.dtype != np.bool_ or mask.shape != camera.size[::-1]:
            raise ArgumentError(
                f"a mask must be bool of its camera's shape {camera.size[::-1]}, got {mask.dtype} {mask.shape}"
            )


def _heights(
    cameras: Sequence[Camera], masks: Sequence[Cropped], centroid_m: Floats, parameters: ShapeParameters
) -> Floats | None:
    height_range = parameters.height_range
    low_m, high_m = height_range.low_mm / 1000, height_range.high_mm / 1000
    if height_range.reference == "centroid":
        low_m, high_m = low_m + centroid_m[2], high_m + centroid_m[2]
    elif height_range.reference == "masks":
        extent = _axis_extent(cameras, masks, centroid_m)
        if extent is None:
            return None
        low_m, high_m = low_m + extent[0], high_m + extent[1]
    if low_m >= high_m:
        return None
    return np.linspace(low_m, high_m, parameters.circumferences)


def _axis_extent(cameras: Sequence[Camera], masks: Sequence[Cropped], centroid_m: Floats) -> tuple[float, float] | None:
    """Lowest and highest world z (m) at which the vertical through the centroid projects into any mask."""
    heights = centroid_m[2] + np.arange(-AXIS_REACH_M, AXIS_REACH_M + AXIS_STEP_M, AXIS_STEP_M)
    axis = np.column_stack([np.tile(centroid_m[:2], (len(heights), 1)), heights])
    inside = np.zeros(len(heights), dtype=bool)
    for camera, mask in zip(cameras, masks, strict=True):
        inside |= on_mask(mask.in_picture(), camera.project(axis))
    hits = heights[inside]
    return (float(hits[0]), float(hits[-1])) if len(hits) else None


def on_mask(mask: Mask, pixels: Floats, *, pixel_rule: PixelRule = "rounded") -> NDArray[np.bool_]:
    """Which of (n, 2) places ``(x, y)`` in an image fall on a mask, by a rule; those that are not finite do not."""
    size = np.array(mask.shape[::-1])
    if pixel_rule == "truncated":
        rounded = np.minimum(np.trunc(np.where(np.isfinite(pixels), pixels, -np.inf)), size - 1)
        rounded = np.where(rounded < 0, rounded + size, rounded)
    else:
        rounded = np.floor(np.where(np.isfinite(pixels), pixels, -1.0) + 0.5)
    inside: NDArray[np.bool_] = np.all((rounded >= 0) & (rounded < size), axis=1)
    column, row = np.where(inside[:, None], rounded, 0).astype(np.intp).T
    return inside & mask[row, column]
