"""One recording's stages with the store behind them: detections, fits, estimates."""

from corsmal.stages.detections import DetectionSet, detect_recording, load_detections
from corsmal.stages.estimates import Predictors, load_estimate
from corsmal.stages.fits import load_fit
from corsmal.stages.mass_rows import mass_rows
from corsmal.stages.true_masks import true_masks, true_views

__all__ = [
    "DetectionSet",
    "Predictors",
    "detect_recording",
    "load_detections",
    "load_estimate",
    "load_fit",
    "mass_rows",
    "true_masks",
    "true_views",
]
