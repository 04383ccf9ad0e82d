"""Where the truth lies beside a synthetic recording."""

from pathlib import Path
from typing import Literal

from corsmal.dataset.layout import Recording
from corsmal.errors import NotFoundError

MaskKind = Literal["visible", "amodal"]


def true_mask_path(recording: Recording, view: str, *, kind: MaskKind) -> Path:
    """The file of the container's true masks in one view, as detections, see ``true_masks``; it may be missing.

    Raises:
        NotFoundError: the recording is not synthetic.
    """
    if recording.truth_path is None:
        raise NotFoundError(f"recording {recording.id} has no truth: only synthetic recordings have one")
    return recording.truth_path.parent / kind / view / f"{recording.id}.parquet"
