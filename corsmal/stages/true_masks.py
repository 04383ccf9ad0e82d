"""The true masks of synthetic recordings, as if a perfect detector had found them."""

from corsmal.dataset import Recording
from corsmal.dataset.truth import MaskKind, true_mask_path
from corsmal.detection import ViewDetections
from corsmal.detection.parquet import read_parquet
from corsmal.errors import CorsmalError, FileError, NotFoundError
from corsmal.files import check_plain_file
from corsmal.parameters import METHOD_VIEWS
from corsmal.store import BYTES_MAX


def true_views(recording: Recording) -> dict[str, ViewDetections]:
    """The visible masks in the method's views, by view.

    Raises:
        NotFoundError: the recording is not synthetic, or masks are missing.
        FileError: a file is broken.
    """
    return {view: true_masks(recording, view) for view in METHOD_VIEWS if view in recording.views}


def true_masks(recording: Recording, view: str, *, kind: MaskKind = "visible") -> ViewDetections:
    """The container's masks in one view, frame by frame, with score 1; a frame without the container has none.

    ``visible`` masks hold the visible pixels, ``amodal`` ones the whole silhouette.

    Raises:
        NotFoundError: the recording is not synthetic, or this view has no such masks.
        FileError: the file is broken.
    """
    path = true_mask_path(recording, view, kind=kind)
    try:
        check_plain_file(path, bytes_max=BYTES_MAX)
        return read_parquet(path)
    except FileNotFoundError as error:
        raise NotFoundError(f"{path}: the true masks are missing; make the recording again") from error
    except (CorsmalError, OSError, ValueError, LookupError, TypeError) as error:
        raise FileError(path, "is broken; delete it and make the recording again") from error
