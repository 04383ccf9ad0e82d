"""One recording's stages with the store behind them: detections, fits, estimates, what was known when."""

from corsmal.stages.detections import DetectionSet, detect_recording, load_detections
from corsmal.stages.estimates import Predictors, load_estimate
from corsmal.stages.fits import load_fit
from corsmal.stages.mass_rows import mass_rows
from corsmal.stages.moments import Moment, kept_estimate, known_when, moments_s
from corsmal.stages.true_masks import true_masks, true_views

__all__ = [
    "DetectionSet",
    "Moment",
    "Predictors",
    "detect_recording",
    "kept_estimate",
    "known_when",
    "load_detections",
    "load_estimate",
    "load_fit",
    "mass_rows",
    "moments_s",
    "true_masks",
    "true_views",
]
