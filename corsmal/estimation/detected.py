"""The detections of a recording that were made elsewhere, and the container among those of a frame."""

from dataclasses import replace

import numpy as np

from corsmal.dataset import Recording, View
from corsmal.detection import Detections, ViewDetections, filter_detections, read_coco_results
from corsmal.errors import FileError
from corsmal.notes import Note, prefixed
from corsmal.parameters import CentreRule, SelectionParameters


def read_view_detections(view: View) -> ViewDetections | None:
    """Detections made elsewhere: the file that lies beside a view's video, None where there is none.

    Raises:
        FileError: the file or the video cannot be used.
    """
    if view.detections_path is None:
        return None
    with view.video() as video:
        size, frame_count = video.size[::-1], video.frame_count
    return read_coco_results(view.detections_path, size=size, frame_count=frame_count)


def file_detections(recording: Recording) -> tuple[dict[str, ViewDetections], tuple[str, ...]]:
    """Detections made elsewhere, for all views of a recording.

    Returns:
        Detections by view, and sentences on files that could not be used and on how the others were read.
    """
    found: dict[str, ViewDetections] = {}
    notes: list[str] = []
    for name, view in recording.views.items():
        try:
            detections = read_view_detections(view)
        except FileError as error:
            notes.append(Note(str(error), flag="detections-incomplete"))
            continue
        if detections is not None:
            found[name] = recording_frames(recording, name, detections)
            notes += [prefixed(str(view.detections_path), problem) for problem in detections.problems]
    return found, (*recording.clock().notes, *notes)


def recording_frames(recording: Recording, view: str, found: ViewDetections) -> ViewDetections:
    """A view's detections by the frames of the recording, where the views do not have the same frames."""
    by_frame = recording.clock().by_frame(view, found)
    return found if by_frame is found else replace(found, by_frame=by_frame)


def counted_frames(recording: Recording, selection: SelectionParameters) -> tuple[int, ...] | None:
    """The frames of a recording that count for selection; None: all."""
    if selection.interval_s is None:
        return None
    clock = recording.clock()
    return selection.counted_frames(fps=clock.fps, frames=len(clock))


def container_mask(detections: Detections, *, centre_rule: CentreRule, parameters: SelectionParameters) -> np.ndarray:
    """The (H, W) bool mask of the container among one frame's detections; all false where there is none."""
    container = filter_detections(detections, centre_rule=centre_rule, parameters=parameters).container
    return np.zeros(detections.size, dtype=bool) if container is None else detections.mask(container)
