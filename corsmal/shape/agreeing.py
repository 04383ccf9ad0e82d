"""The views that a hull is fitted to: all of them, or those that agree."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from corsmal.geometry import Camera
from corsmal.parameters import ShapeParameters
from corsmal.shape.circumferences import check_masks, fit_cropped
from corsmal.shape.cropped import Cropped, Mask
from corsmal.shape.outline_fit import with_box
from corsmal.shape.records import Hull
from corsmal.shape.sections import cropped_agreement, cropped_silhouettes

AGREED = 0.75
"""A hull whose silhouettes overlap the masks so well, intersection over union, has no view to leave out."""
GAIN = 0.06
"""A view is left out where the overlap of all views, that view included, grows by more than that. A hand that hides a
side makes hulls that please two views a little better, and wrong; a mask of another object makes them much better."""
LONELY = 0.05
"""A hull for which all views but one count less explains that view only: any gain is enough to leave it out."""


def fit_agreeing(cameras: Sequence[Camera], masks: Sequence[Mask], parameters: ShapeParameters) -> Hull:
    """Fit a hull to the masks of several views, without one that contradicts the others.

    A mask of another object, or of the container and something else, bends a hull that has to please it. With three
    views or more, where the hull fails or explains the masks badly, each view is left out in turn, the last one first;
    those views are taken whose hull's silhouettes overlap the masks of *all* views best. With the method
    ``circumferences`` that is done only for a hull that failed.

    Args are as in ``fit_hull``.

    Returns:
        The hull; its ``view_weights`` are 0 for a view that was left out.
    """
    check_masks(cameras, masks)
    crops = [Cropped.of(mask) for mask in masks]
    best = fit_cropped(cameras, crops, parameters)
    if len(cameras) < 3 or (best.ok and parameters.method == "circumferences"):
        return best
    most = _overlap(best, cameras, crops) if best.ok else 0.0
    if most >= AGREED:
        return best
    if best.ok and np.count_nonzero(best.view_weights > LONELY) > 1:
        most += GAIN
    chosen: tuple[Hull, list[int]] | None = None
    for left_out in reversed(range(len(cameras))):
        kept = [index for index in range(len(cameras)) if index != left_out]
        tried = _fit(cameras, crops, replace(parameters, boxes=False), kept)
        if tried.ok and (overlap := _overlap(tried, cameras, crops)) > most:
            chosen, most = (tried, kept), overlap
    if chosen is None:
        return best
    found, kept = chosen
    if parameters.method == "circumferences" or not parameters.boxes:
        return found
    seeing, seen = [cameras[index] for index in kept], [crops[index] for index in kept]
    return with_box(found, seeing, seen, tilt_deg=parameters.tilt_deg)


def _fit(cameras: Sequence[Camera], masks: Sequence[Cropped], parameters: ShapeParameters, kept: Sequence[int]) -> Hull:
    """The hull of some views, with weights for all."""
    hull = fit_cropped([cameras[index] for index in kept], [masks[index] for index in kept], parameters)
    weights = np.zeros(len(cameras))
    weights[list(kept)] = hull.view_weights if len(hull.view_weights) else 1.0
    return replace(hull, view_weights=weights)


def _overlap(hull: Hull, cameras: Sequence[Camera], masks: Sequence[Cropped]) -> float:
    """Intersection over union of the silhouettes and the masks, mean of all views."""
    if hull.overlap is not None and (hull.view_weights > 0).sum() == len(cameras):
        return hull.overlap
    seen = cropped_silhouettes(hull, cameras)
    return float(np.mean([cropped_agreement(solid, mask).overlap for solid, mask in zip(seen, masks, strict=True)]))
