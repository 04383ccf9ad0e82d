"""Fitting a solid of revolution to the container's masks (paper 3.2, after LoDE)."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.errors import ArgumentError
from corsmal.geometry import Camera, Floats, parallax_deg, triangulate
from corsmal.parameters import HeightRange, ShapeParameters
from corsmal.shape.outline_fit import fit_outlines
from corsmal.shape.outlines import Mask
from corsmal.shape.records import Hull

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
        >>> hull.radii_mm.shape
        (145,)
    """
    parameters = parameters or ShapeParameters.paper()
    _check(cameras, masks)
    boxes = [cv2.boundingRect(mask.view(np.uint8)) for mask in masks]
    crops = [mask[y : y + height, x : x + width] for mask, (x, y, width, height) in zip(masks, boxes, strict=True)]
    corners = np.array([box[:2] for box in boxes], dtype=np.float64)
    centroids = []
    for number, (crop, corner) in enumerate(zip(crops, corners, strict=True), start=1):
        centroid = contour_centroid(crop)
        if centroid is None:
            problem = "is empty" if crop.size == 0 else "has no area"
            return Hull.failed(f"mask {number} of {len(masks)} {problem}")
        centroids.append(centroid + corner)
    centroid_m = triangulate(cameras, centroids)
    if not np.isfinite(centroid_m).all() or parallax_deg(cameras, centroid_m) < PARALLAX_MIN_DEG:
        return Hull.failed("the views' rays through the mask centroids are nearly parallel")
    if not np.isfinite(np.vstack([camera.project(centroid_m[None]) for camera in cameras])).all():
        return Hull.failed("the masks' centroids meet behind a camera: they show different objects")
    if parameters.method == "outlines":
        return fit_outlines(cameras, masks, centroid_m, parameters)
    heights_m = _heights(cameras, masks, centroid_m, height_range=parameters.height_range, n=parameters.circumferences)
    if heights_m is None:
        return Hull.failed("the vertical axis through the centroid meets no mask", centroid_m=centroid_m)
    radii_mm = np.linspace(parameters.radius_max_mm, parameters.radius_min_mm, parameters.radii)
    projections = np.array([camera.projection for camera in cameras])
    axis = np.column_stack([np.tile(centroid_m[:2], (len(heights_m), 1)), heights_m, np.ones(len(heights_m))])
    from corsmal.shape.kernels import first_fitting_radius  # noqa: PLC0415 - Numba takes long to import

    first = first_fitting_radius(
        tuple(np.array(crop, order="C") for crop in crops),
        corners.astype(np.int64),
        axis @ projections.transpose(0, 2, 1),
        _unit_circle(parameters.points) @ projections[:, :, :2].transpose(0, 2, 1),
        radii_mm / 1000,
        parameters.fit_rule == "all",
    )
    converged = first < parameters.radii
    fitted_mm = radii_mm[np.minimum(first, parameters.radii - 1)]
    return Hull(heights_m * 1000, fitted_mm, converged, centroid_m)


def contour_centroid(mask: Mask) -> Floats | None:
    """Centroid of a mask's largest contour by image moments.

    Args:
        mask: (H, W) bool.

    Returns:
        (2,) pixels ``(x, y)``; None where no contour encloses an area.
    """
    if mask.size == 0:
        return None
    contours, _ = cv2.findContours(np.ascontiguousarray(mask, np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    moments = cv2.moments(max(contours, key=cv2.contourArea)) if contours else {"m00": 0}
    if moments["m00"] == 0:
        return None
    return np.array([moments["m10"], moments["m01"]]) / moments["m00"]


def _check(cameras: Sequence[Camera], masks: Sequence[Mask]) -> None:
    if len(cameras) != len(masks) or len(cameras) < 2:
        raise ArgumentError(f"a hull needs one mask for each of two or more cameras, got {len(cameras)}, {len(masks)}")
    for camera, mask in zip(cameras, masks, strict=True):
        if mask.dtype != np.bool_ or mask.shape != camera.size[::-1]:
            raise ArgumentError(
                f"a mask must be bool of its camera's shape {camera.size[::-1]}, got {mask.dtype} {mask.shape}"
            )


def _unit_circle(points: int) -> Floats:
    angles = np.arange(points) * (2 * np.pi / points)
    return np.column_stack([np.cos(angles), np.sin(angles)])


def _heights(
    cameras: Sequence[Camera], masks: Sequence[Mask], centroid_m: Floats, *, height_range: HeightRange, n: int
) -> Floats | None:
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
    return np.linspace(low_m, high_m, n)


def _axis_extent(cameras: Sequence[Camera], masks: Sequence[Mask], centroid_m: Floats) -> tuple[float, float] | None:
    """Lowest and highest world z (m) at which the vertical through the centroid projects into any mask."""
    heights = centroid_m[2] + np.arange(-AXIS_REACH_M, AXIS_REACH_M + AXIS_STEP_M, AXIS_STEP_M)
    axis = np.column_stack([np.tile(centroid_m[:2], (len(heights), 1)), heights])
    inside = np.zeros(len(heights), dtype=bool)
    for camera, mask in zip(cameras, masks, strict=True):
        inside |= on_mask(mask, camera.project(axis))
    hits = heights[inside]
    return (float(hits[0]), float(hits[-1])) if len(hits) else None


def on_mask(mask: Mask, pixels: Floats) -> NDArray[np.bool_]:
    """Which of (n, 2) pixels ``(x, y)``, rounded, fall on a mask; those outside the image or not finite do not."""
    rounded = np.floor(np.where(np.isfinite(pixels), pixels, -1.0) + 0.5)
    inside: NDArray[np.bool_] = np.all((rounded >= 0) & (rounded < mask.shape[::-1]), axis=1)
    column, row = np.where(inside[:, None], rounded, 0).astype(np.intp).T
    return inside & mask[row, column]
