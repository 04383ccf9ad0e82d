"""Results for other programs: detections as files of annotation tools, a recording for the Rerun viewer."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
