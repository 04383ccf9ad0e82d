"""The fit of ``tuned``: a solid of revolution or a box, whichever explains the masks better."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from corsmal.geometry import Camera
from corsmal.parameters import ShapeParameters
from corsmal.shape.box import fit_box
from corsmal.shape.outlines import Axis, Mask, without_specks
from corsmal.shape.quality import predicted_error_pct
from corsmal.shape.records import Hull
from corsmal.shape.revolution import fit_revolution
from corsmal.shape.sections import agreement, silhouettes

EXPLAINED_MIN = 0.75
"""A solid that is seen where less of some view's mask is does not explain the views together."""


def fit_outlines(
    cameras: Sequence[Camera], masks: Sequence[Mask], centroid_m: NDArray[np.float64], parameters: ShapeParameters
) -> Hull:
    """Fit a solid of revolution, and a box where ``parameters`` want it, to the outlines of masks.

    Args are as in ``fit_hull``; the axis is first looked for at ``centroid_m`` (3,).

    Returns:
        The hull with its ``overlap``; a failed one, with a reason, where no solid explains the masks.
    """
    masks = [without_specks(mask) for mask in masks]
    found = fit_revolution(
        cameras,
        masks,
        Axis(centroid_m, np.array([0.0, 0.0, 1.0])),
        tilt_deg=parameters.tilt_deg,
        circumferences=parameters.circumferences,
    )
    if not found.ok:
        return found
    found, explained = _judged(found, cameras, masks)
    if parameters.boxes:
        box, box_explained = _judged(fit_box(cameras, masks, found, tilt_deg=parameters.tilt_deg), cameras, masks)
        gain = (box.overlap or 0.0) - (found.overlap or 0.0)
        if gain > 0:
            found, explained = box, box_explained
        found = replace(found, box_gain=gain)
    if explained < EXPLAINED_MIN:
        return Hull.failed(
            f"no solid explains the masks together ({100 * explained:.0f} % of one of them): they may show different "
            "objects",
            centroid_m=centroid_m,
        )
    return replace(found, error_pct=predicted_error_pct(found.evidence, is_box=found.depth_mm is not None))


def _judged(hull: Hull, cameras: Sequence[Camera], masks: Sequence[Mask]) -> tuple[Hull, float]:
    """The hull with its overlap, and the least share of a mask that its silhouette covers."""
    found = [agreement(solid, mask) for mask, solid in zip(masks, silhouettes(hull, cameras), strict=True)]
    overlap = float(np.mean([each.overlap for each in found]))
    explained = [each.explained for each in found]
    evidence = {
        **hull.evidence,
        "unexplained": 1 - float(np.mean(explained)),
        "beyond": float(np.mean([each.beyond for each in found])),
        "pair": float(len(found) == 2),
    }
    return replace(hull, overlap=overlap, evidence=evidence), min(explained)
