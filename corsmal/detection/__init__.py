"""Detections: the record of what was found in a view, where it comes from, and which of it counts.

A view's detections come from a COCO results file (``read_coco_results``) or from a detector run over its video
(``detect_view``). PyTorch is imported only when ``MaskRCNNDetector`` or ``SmallDetector`` is asked for.
"""

import importlib
from typing import TYPE_CHECKING, Any

from corsmal.detection.coco import read_coco_results, write_coco_results
from corsmal.detection.filtering import Filtered, filter_detections
from corsmal.detection.job import Detector, VideoFrames, detect_view
from corsmal.detection.record import Detections
from corsmal.detection.view import ViewDetections

if TYPE_CHECKING:
    from corsmal.detection.maskrcnn import MaskRCNNDetector
    from corsmal.detection.small import SmallDetector

__all__ = [
    "Detections",
    "Detector",
    "Filtered",
    "MaskRCNNDetector",
    "SmallDetector",
    "VideoFrames",
    "ViewDetections",
    "detect_view",
    "filter_detections",
    "read_coco_results",
    "write_coco_results",
]


def __getattr__(name: str) -> Any:
    modules = {"MaskRCNNDetector": "maskrcnn", "SmallDetector": "small"}
    if name in modules:
        return getattr(importlib.import_module(f"corsmal.detection.{modules[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
