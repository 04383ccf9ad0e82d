"""One recording to one estimate: detections, best frame, hull, container mass, filling."""

from corsmal.estimation.detected import container_mask, file_detections, read_view_detections
from corsmal.estimation.estimate import MEANS, Estimate, Status, estimate, mass_inputs, training_means
from corsmal.estimation.fit import QUANTITIES, Fit, fit_frame

__all__ = [
    "MEANS",
    "QUANTITIES",
    "Estimate",
    "Fit",
    "Status",
    "container_mask",
    "estimate",
    "file_detections",
    "fit_frame",
    "mass_inputs",
    "read_view_detections",
    "training_means",
]
