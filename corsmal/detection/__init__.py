"""Detections: the record of what was found in a view, where it comes from, and which of it counts.

A view's detections come from a COCO results file (``read_coco_results``) or from a detector run over its video
(``detect_view``). PyTorch is imported when a detector is first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
