"""One recording to one estimate: detections, best frame, hull, container mass, filling."""

from corsmal.estimation.detected import container_mask, counted_frames, file_detections, read_view_detections
from corsmal.estimation.estimate import estimate
from corsmal.estimation.fit import Fit, MaskSource, RecordingMasks, fit_frame, fit_masks
from corsmal.estimation.intervals import frame_intervals
from corsmal.estimation.means import TrainingMeans
from corsmal.estimation.records import Estimate
from corsmal.estimation.several import choose_frames
from corsmal.estimation.weighing import frontal_frame, mass_inputs, with_mass

__all__ = [
    "Estimate",
    "Fit",
    "MaskSource",
    "RecordingMasks",
    "TrainingMeans",
    "choose_frames",
    "container_mask",
    "counted_frames",
    "estimate",
    "file_detections",
    "fit_frame",
    "fit_masks",
    "frame_intervals",
    "frontal_frame",
    "mass_inputs",
    "read_view_detections",
    "with_mass",
]
