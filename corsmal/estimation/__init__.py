"""One recording to one estimate: detections, best frame, hull, container mass, filling."""

from corsmal.estimation.detected import container_mask, file_detections, read_view_detections
from corsmal.estimation.estimate import estimate, mass_inputs
from corsmal.estimation.fit import Fit, FitSource, MaskSource, RecordingMasks, fit_frame, fit_masks
from corsmal.estimation.means import TrainingMeans
from corsmal.estimation.records import Estimate, Status
from corsmal.estimation.several import Combined, Interval, choose_frames, combine_fits

__all__ = [
    "Combined",
    "Estimate",
    "Fit",
    "FitSource",
    "Interval",
    "MaskSource",
    "RecordingMasks",
    "Status",
    "TrainingMeans",
    "choose_frames",
    "combine_fits",
    "container_mask",
    "estimate",
    "file_detections",
    "fit_frame",
    "fit_masks",
    "mass_inputs",
    "read_view_detections",
]
