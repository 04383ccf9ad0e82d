"""Features of a recording's videos, kept in the store."""

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset import Recording
from corsmal.detection import filter_detections
from corsmal.errors import NotFoundError
from corsmal.filling.clips import Box, ClipNetwork, square_around
from corsmal.filling.sight import VIEWS, WIDTH
from corsmal.parameters import METHOD_VIEWS, CentreRule, SelectionParameters
from corsmal.selection import FrameDetections
from corsmal.stages.detections import load_detections
from corsmal.store import Store, digest

KIND = "clips"
"""Where a store keeps the rows of a view."""

RULE: CentreRule = "none"
"""The centre rule of the detections that a crop follows: the container leaves the middle when it is handed over."""


def recording_sight(
    recording: Recording, network: ClipNetwork, *, store: Store, around_container: bool = False
) -> NDArray[np.float16]:
    """The rows of a recording's three views, (3, T, 512): view1, view2 and view3, to the end of the shortest.

    Args:
        recording: the recording.
        network: computes the rows.
        store: keeps the rows of each view, and gives detections.
        around_container: whether the network sees, in each view, the square around all boxes of the container, with a
            margin, and not the whole picture. A view without detections is seen whole.

    Returns:
        Half precision; a view that is missing is zero everywhere.

    Raises:
        NotFoundError: the recording has none of the views.
        FileError: a video cannot be read.
    """
    detections = load_detections(recording, store=store).views if around_container else {}
    found: dict[str, NDArray[np.float16]] = {}
    for name in sorted(METHOD_VIEWS):
        if name in recording.views:
            found[name] = _view_rows(recording, name, network, store=store, detections=detections.get(name, {}))
    if not found:
        raise NotFoundError(f"recording {recording.id} has no videos of the views that the network sees")
    rows = min(len(own) for own in found.values())
    sight = np.zeros((VIEWS, rows, WIDTH), np.float16)
    for index, name in enumerate(sorted(METHOD_VIEWS)):
        if name in found:
            sight[index] = found[name][:rows]
    return sight


def _view_rows(
    recording: Recording, name: str, network: ClipNetwork, *, store: Store, detections: FrameDetections
) -> NDArray[np.float16]:
    view = recording.views[name]
    with view.video() as video:
        crop = _container_square(detections, (video[0].shape[1], video[0].shape[0]))
        key = digest(KIND, network.digest, view.video_path, crop)
        kept = store.arrays(KIND, key)
        if kept is not None and "rows" in kept:
            return np.asarray(kept["rows"], dtype=np.float16)
        rows = network.rows(video, crop=crop).astype(np.float16)
    store.save_arrays(KIND, key, rows=rows)
    return rows


def _container_square(detections: FrameDetections, size: tuple[int, int]) -> Box | None:
    """The square around all boxes of the container in a view; None where it was not detected."""
    boxes = []
    for frame in detections.values():
        chosen = filter_detections(frame, centre_rule=RULE, parameters=SelectionParameters()).container
        if chosen is not None:
            boxes.append(frame.boxes[chosen])
    return square_around(np.stack(boxes), width=size[0], height=size[1]) if boxes else None
