"""Hulls of single frames, kept in the store."""

import numpy as np

from corsmal.batch.detecting import DetectionSet
from corsmal.dataset import Recording
from corsmal.estimation import Fit, fit_frame
from corsmal.parameters import CentreRule, SelectionParameters, ShapeParameters
from corsmal.selection import Pair
from corsmal.shape import Hull, measure_hull
from corsmal.store import Store, digest, file_fingerprint


def load_fit(
    recording: Recording,
    detections: DetectionSet,
    *,
    pair: Pair,
    frame: int,
    centre_rule: CentreRule,
    shape: ShapeParameters,
    store: Store,
) -> Fit:
    """The hull of one pair in one frame, from the store if it was fitted before."""
    calibrations = calibration_fingerprints(recording)
    key = digest(
        "fit",
        detections.key,
        [calibrations.get(name) for name in pair],
        pair,
        frame,
        centre_rule,
        SelectionParameters(),
        shape,
    )
    kept = store.arrays("fits", key)
    if kept is not None and {"heights_mm", "radii_mm", "converged", "centroid_m"} <= set(kept):
        hull = Hull(kept["heights_mm"], kept["radii_mm"], kept["converged"], kept["centroid_m"])
        return Fit(pair, frame, hull, measure_hull(hull, shape))
    fit = fit_frame(recording, detections.views, pair=pair, frame=frame, centre_rule=centre_rule, shape=shape)
    hull = fit.hull
    if hull.ok and hull.centroid_m is not None:
        store.save_arrays(
            "fits",
            key,
            heights_mm=hull.heights_mm,
            radii_mm=hull.radii_mm,
            converged=np.asarray(hull.converged),
            centroid_m=hull.centroid_m,
        )
    return fit


def calibration_fingerprints(recording: Recording) -> dict[str, str]:
    """Of the calibration files that there are, by view."""
    paths = {name: view.calibration_path for name, view in recording.views.items()}
    return {name: file_fingerprint(path) for name, path in paths.items() if path is not None}
