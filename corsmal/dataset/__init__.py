"""A dataset folder on disk, as recordings with videos, calibrated cameras, sound and annotation."""

from typing import TYPE_CHECKING

from corsmal.dataset.annotation import Annotation
from corsmal.dataset.audio import Audio
from corsmal.dataset.layout import Recording, View
from corsmal.dataset.opening import Dataset, open_dataset

if TYPE_CHECKING:
    from corsmal.dataset.video import Video

__all__ = ["Annotation", "Audio", "Dataset", "Recording", "Video", "View", "open_dataset"]


def __getattr__(name: str) -> object:
    """``Video`` is loaded when it is first asked for: listing a dataset needs no video library."""
    if name != "Video":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from corsmal.dataset.video import Video  # noqa: PLC0415 - see above

    return Video
