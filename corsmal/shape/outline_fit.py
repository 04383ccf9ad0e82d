"""The fit of ``tuned``: a solid of revolution or a box, whichever explains the masks better."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from corsmal.geometry import Camera
from corsmal.parameters import ShapeParameters
from corsmal.shape.box import fit_box
from corsmal.shape.cropped import Cropped
from corsmal.shape.outlines import Axis
from corsmal.shape.quality import predicted_error_pct
from corsmal.shape.records import Hull
from corsmal.shape.revolution import fit_revolution
from corsmal.shape.sections import cropped_agreement, cropped_silhouettes

EXPLAINED_MIN = 0.75
"""A solid that is seen where less of some view's mask is does not explain the views together."""


def fit_outlines(
    cameras: Sequence[Camera], masks: Sequence[Cropped], centroid_m: NDArray[np.float64], parameters: ShapeParameters
) -> Hull:
    """Fit a solid of revolution, and a box where ``parameters`` want it, to the outlines of masks.

    Args are as in ``fit_hull``; the axis is first looked for at ``centroid_m`` (3,).

    Returns:
        The hull with its ``overlap``; a failed one, with a reason, where no solid explains the masks.
    """
    clean = [mask.without_specks for mask in masks]
    found = fit_revolution(
        cameras,
        clean,
        Axis(centroid_m, np.array([0.0, 0.0, 1.0])),
        tilt_deg=parameters.tilt_deg,
        circumferences=parameters.circumferences,
    )
    if not found.ok:
        return found
    found = _judged(found, cameras, clean)
    return with_box(found, cameras, masks, tilt_deg=parameters.tilt_deg) if parameters.boxes else _explaining(found)


def with_box(found: Hull, cameras: Sequence[Camera], masks: Sequence[Cropped], *, tilt_deg: float) -> Hull:
    """A box where it explains masks better than a solid of revolution that was fitted to them, else that solid.

    Args:
        found: what ``fit_outlines`` found without boxes.
        cameras: two or more.
        masks: one per camera.
        tilt_deg: how far the axis is expected to lean.

    Returns:
        The hull with its ``box_gain``; a failed one, with a reason, where it does not explain the masks.
    """
    clean = [mask.without_specks for mask in masks]
    box = _judged(fit_box(cameras, clean, found, tilt_deg=tilt_deg), cameras, clean)
    gain = (box.overlap or 0.0) - (found.overlap or 0.0)
    return _explaining(replace(box if gain > 0 else found, box_gain=gain))


def _explaining(hull: Hull) -> Hull:
    """The hull with its predicted error, or a failed one where some mask shows something else."""
    explained = hull.evidence["explained"]
    if explained < EXPLAINED_MIN:
        return Hull.failed(
            f"no solid explains the masks together ({100 * explained:.0f} % of one of them): they may show different "
            "objects",
            centroid_m=hull.centroid_m,
        )
    return replace(hull, error_pct=predicted_error_pct(hull.evidence, is_box=hull.depth_mm is not None))


def _judged(hull: Hull, cameras: Sequence[Camera], masks: Sequence[Cropped]) -> Hull:
    """The hull with its overlap, and what is seen of how it explains the masks."""
    seen = cropped_silhouettes(hull, cameras)
    found = [cropped_agreement(solid, mask) for solid, mask in zip(seen, masks, strict=True)]
    explained = [each.explained for each in found]
    evidence = {
        **hull.evidence,
        "explained": min(explained),
        "unexplained": 1 - float(np.mean(explained)),
        "beyond": float(np.mean([each.beyond for each in found])),
        "pair": float(len(found) == 2),
    }
    return replace(hull, overlap=float(np.mean([each.overlap for each in found])), evidence=evidence)
