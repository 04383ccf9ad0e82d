"""Whether a fit can be true: where the cameras stand, how large the container is, and whether the views meet."""

from collections.abc import Mapping, Sequence
from contextlib import suppress

import numpy as np

from corsmal.dataset import Recording
from corsmal.errors import CorsmalError
from corsmal.estimation.fit import Fit, MaskSource
from corsmal.geometry import Camera, Floats, triangulate
from corsmal.notes import prefixed
from corsmal.parameters import METHOD_VIEWS, CentreRule
from corsmal.shape.cropped import contour_centroid

CAMERA_M = (0.2, 5.0)
"""Between these distances from the container a camera is plausible."""

CAPACITY_ML = (10.0, 10_000.0)
SIZE_MM = (20.0, 400.0)
"""Between these a container's height and its larger width are plausible."""

MISS_MAX = 0.05
"""How far the container's triangulated centroid may fall from the centroids of its masks, of the image's width. Best
frames of the demo reach 0.03, where a hand hides half of the container from one view; exchanged cameras have up to
0.3."""


def implausible(fit: Fit, values: Mapping[str, float | None], source: MaskSource, *, centre_rule: CentreRule) -> str:
    """Why the fit of a pair of views cannot be true; empty where nothing speaks against it.

    Args:
        fit: a successful fit.
        values: capacity, widths and height that it stands for, by quantity, mL and mm; None: not measured.
        source: gives the cameras and the masks.
        centre_rule: with which the masks were chosen.
    """
    try:
        cameras = {name: source.camera(name) for name in fit.pair}
        masks = [source.mask(name, fit.frame or 0, centre_rule) for name in fit.pair]
    except CorsmalError:
        return ""
    centroids = [centroid for mask in masks if (centroid := contour_centroid(mask)) is not None]
    return (
        _place_reason(cameras, fit.hull.centroid_m)
        or _size_reason(values)
        or (_miss_reason(list(cameras.values()), centroids) if len(centroids) == len(masks) else "")
    )


def calibration_notes(recording: Recording) -> tuple[str, ...]:
    """How the calibrations of the method's views were read, where that was not as expected."""
    notes: list[str] = []
    for name in METHOD_VIEWS:
        view = recording.views.get(name)
        if view is not None and view.calibration_path is not None:
            with suppress(CorsmalError):
                notes += [prefixed(str(view.calibration_path), note) for note in view.calibration().notes]
    return tuple(notes)


def reprojection_miss(cameras: Sequence[Camera], centroids: Sequence[Floats]) -> float:
    """How far the point that several views show falls from where each shows it, the largest, of the image's width.

    Args:
        cameras: two or more.
        centroids: (2,) pixels, one per camera.

    Returns:
        Infinite where the rays meet behind a camera, or nowhere.
    """
    point_m = triangulate(cameras, centroids)
    if not np.isfinite(point_m).all():
        return np.inf
    distances = [
        float(np.linalg.norm(camera.project(point_m[None])[0] - centroid)) / camera.size[0]
        for camera, centroid in zip(cameras, centroids, strict=True)
    ]
    return max(distances) if np.isfinite(distances).all() else np.inf


def _place_reason(cameras: Mapping[str, Camera], centroid_m: Floats | None) -> str:
    if centroid_m is None:
        return ""
    low, high = CAMERA_M
    for name, camera in cameras.items():
        distance_m = float(np.linalg.norm(camera.centre_m - centroid_m))
        if not low <= distance_m <= high:
            return (
                f"not plausible: the camera of {name} would be {distance_m:.3g} m from the container, expected "
                f"{low:g} to {high:g} m (is its 'tvec' in metres?)"
            )
    return ""


def _size_reason(values: Mapping[str, float | None]) -> str:
    low, high = CAPACITY_ML
    capacity_ml = values["capacity_ml"]
    if capacity_ml is not None and not low <= capacity_ml <= high:
        return f"not plausible: a capacity of {capacity_ml:.3g} mL, expected {low:g} to {high:g} mL"
    low, high = SIZE_MM
    widths = [width for name in ("width_top_mm", "width_bottom_mm") if (width := values[name]) is not None]
    sizes = {} if values["height_mm"] is None else {"height": values["height_mm"]}
    sizes |= {"width": max(widths)} if widths else {}
    for name, size in sizes.items():
        if not low <= size <= high:
            return f"not plausible: a {name} of {size:.3g} mm, expected {low:g} to {high:g} mm"
    return ""


def _miss_reason(cameras: Sequence[Camera], centroids: Sequence[Floats]) -> str:
    miss = reprojection_miss(cameras, centroids)
    if miss <= MISS_MAX:
        return ""
    shown = f"by {100 * miss:.0f} % of the image's width" if np.isfinite(miss) else "behind a camera"
    return f"not plausible: the views do not meet (the container's centroid misses its masks {shown})"
