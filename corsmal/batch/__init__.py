"""The stages of recordings, with what they computed kept in the store."""

from corsmal.batch.detecting import DetectionSet, detect_recording, load_detections
from corsmal.batch.estimating import Predictors, estimate_recordings, load_estimate
from corsmal.batch.fitting import load_fit
from corsmal.batch.weighing import mass_rows

__all__ = [
    "DetectionSet",
    "Predictors",
    "detect_recording",
    "estimate_recordings",
    "load_detections",
    "load_estimate",
    "load_fit",
    "mass_rows",
]
