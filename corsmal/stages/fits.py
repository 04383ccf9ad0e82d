"""Hulls of single frames, kept in the store."""

from typing import Any

import numpy as np

from corsmal.dataset import Recording
from corsmal.estimation import Fit, MaskSource, RecordingMasks, fit_masks
from corsmal.parameters import METHOD_VIEWS, CentreRule, Pair, SelectionParameters, ShapeParameters
from corsmal.shape import Hull, measure_hull
from corsmal.stages.detections import DetectionSet
from corsmal.stages.version import METHOD_VERSION, READING_VERSION
from corsmal.store import Store, digest, file_fingerprint

ARRAYS = ("heights_mm", "radii_mm", "converged", "centroid_m", "direction", "view_weights")
NUMBERS = ("depth_mm", "yaw", "overlap", "box_gain", "error_pct")
"""What is kept of a hull; a number that it does not have is kept as NaN."""


def load_fit(
    recording: Recording,
    detections: DetectionSet,
    *,
    pair: Pair,
    frame: int,
    centre_rule: CentreRule,
    shape: ShapeParameters,
    selection: SelectionParameters | None = None,
    store: Store,
    source: MaskSource | None = None,
) -> Fit:
    """The hull of one pair in one frame, from the store if it was fitted before.

    Args are as in ``fit_masks``; ``source`` holds cameras and masks where the caller has them already.
    """
    calibrations, selection = calibration_fingerprints(recording), selection or SelectionParameters()
    key = digest(
        "fit",
        METHOD_VERSION,
        detections.key,
        [calibrations.get(name) for name in (METHOD_VIEWS if shape.all_views else pair)],
        pair,
        frame,
        centre_rule,
        selection,
        shape,
        *([] if recording.is_synthetic else [READING_VERSION]),
    )
    kept = store.arrays("fits", key)
    if kept is not None and set(ARRAYS) | set(NUMBERS) <= set(kept):
        parts: dict[str, Any] = {name: kept[name] for name in ARRAYS}
        parts |= {name: float(kept[name]) for name in NUMBERS if np.isfinite(kept[name])}
        hull = Hull(**parts)
        return Fit(pair, frame, hull, measure_hull(hull, shape))
    source = source or RecordingMasks(recording, detections.views, selection)
    fit = fit_masks(source, pair=pair, frame=frame, centre_rule=centre_rule, shape=shape)
    hull = fit.hull
    if hull.ok and hull.centroid_m is not None:
        numbers = {name: getattr(hull, name) for name in NUMBERS}
        store.save_arrays(
            "fits",
            key,
            **{name: np.asarray(getattr(hull, name)) for name in ARRAYS},
            **{name: np.array(np.nan if value is None else value) for name, value in numbers.items()},
        )
    return fit


def calibration_fingerprints(recording: Recording) -> dict[str, str]:
    """Of the calibration files that there are, by view."""
    paths = {name: view.calibration_path for name, view in recording.views.items()}
    return {name: file_fingerprint(path) for name, path in paths.items() if path is not None}
