"""A dataset folder on disk, as recordings with videos, calibrated cameras, sound and annotation.

What loads a large library is loaded when it is first used: ``Video`` (PyAV), ``Dataset`` and ``open_dataset``
(pandas).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
