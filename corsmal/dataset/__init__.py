"""A dataset folder on disk, as recordings with videos, calibrated cameras, sound and annotation.

What loads a large library is loaded when it is first asked for: ``Video`` (PyAV), ``Dataset`` and ``open_dataset``
(pandas).
"""

import importlib
from typing import TYPE_CHECKING

from corsmal.dataset.annotation import Annotation
from corsmal.dataset.audio import Audio
from corsmal.dataset.layout import Recording, View

if TYPE_CHECKING:
    from corsmal.dataset.opening import Dataset, open_dataset
    from corsmal.dataset.video import Video

__all__ = ["Annotation", "Audio", "Dataset", "Recording", "Video", "View", "open_dataset"]


def __getattr__(name: str) -> object:
    """A public name that is loaded late."""
    modules = {"Dataset": "opening", "open_dataset": "opening", "Video": "video"}
    if name not in modules:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"corsmal.dataset.{modules[name]}"), name)
