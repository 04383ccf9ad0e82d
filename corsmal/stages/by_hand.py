"""Masks by hand among a recording's detections, and as the truth of its mask stage."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from corsmal.by_hand import HandMask, MaskHistory
from corsmal.by_hand.record import SOURCE
from corsmal.dataset import Recording, View
from corsmal.detection import ViewDetections
from corsmal.errors import CorsmalError
from corsmal.estimation.detected import recording_frames
from corsmal.notes import Note
from corsmal.parameters import METHOD_VIEWS
from corsmal.store import Store

FLAG = "by-hand"
FRAMES_NAMED = 8


def with_masks_by_hand(
    recording: Recording, view: View, found: ViewDetections | None, *, store: Store
) -> tuple[ViewDetections | None, list[str]]:
    """A view's detections with masks by hand in the place of what was detected in their frames.

    Args:
        recording: the recording.
        view: one of its views.
        found: what was detected, by the view's own frames; None: nothing was.
        store: holds the masks.

    Returns:
        The detections, None where there are neither; and sentences on the masks that took a place, and on those that
        are not used because the video has changed.
    """
    history = MaskHistory(recording.id, view, store=store)
    try:
        masks, notes = history.masks(), [Note(sentence, flag=FLAG) for sentence in history.problems()]
    except CorsmalError as error:
        return found, [Note(str(error), flag=FLAG)]
    if not masks:
        return found, [*notes]
    size = found.size if found is not None else next(iter(masks.values())).size
    by_frame = {frame: mask.detections() for frame, mask in masks.items() if mask.size == size}
    notes.append(Note(f"{view.name}: masks by hand in {_named(by_frame)}", flag=FLAG))
    if found is None:
        return ViewDetections(by_frame, size=size, source=SOURCE), [*notes]
    source = f"{found.source}; {len(by_frame)} of {len({*found, *by_frame})} frames {SOURCE}"
    return replace(found, by_frame={**found.by_frame, **by_frame}, source=source), [*notes]


def masks_origin(recording: Recording, *, store: Store) -> tuple[Any, ...]:
    """What the masks by hand of a recording depend on, for a digest; empty where there are none."""
    found: list[Any] = []
    for name, view in recording.views.items():
        history = MaskHistory(recording.id, view, store=store)
        try:
            masks, problems = history.masks(), history.problems()
        except CorsmalError as error:
            masks, problems = {}, (str(error),)
        if masks or problems:
            found.append((name, [(frame, mask.counts, mask.label) for frame, mask in masks.items()], problems))
    return tuple(found)


def views_by_hand(recording: Recording, *, store: Store) -> dict[str, ViewDetections]:
    """The masks by hand of a recording by view and frame of the recording, nothing else: the truth of its masks.

    A view without one is left out, as is one whose masks cannot be read.
    """
    found = {}
    for name, masks in masks_by_view(recording, store=store).items():
        if masks and name in METHOD_VIEWS:
            by_frame = {frame: mask.detections() for frame, mask in masks.items()}
            view = ViewDetections(by_frame, size=next(iter(masks.values())).size, source=SOURCE)
            found[name] = recording_frames(recording, name, view)
    return found


def has_masks_by_hand(recording: Recording, *, store: Store) -> bool:
    """Whether two of the method's views have masks by hand in a common frame, so that they can be fitted."""
    frames = [set(view) for view in views_by_hand(recording, store=store).values()]
    return any(first & second for place, first in enumerate(frames) for second in frames[place + 1 :])


def masks_by_view(recording: Recording, *, store: Store) -> dict[str, dict[int, HandMask]]:
    """The accepted masks by hand of a recording's views, by the views' own frames; none of what cannot be read."""
    found = {}
    for name, view in recording.views.items():
        try:
            found[name] = MaskHistory(recording.id, view, store=store).masks()
        except CorsmalError:
            found[name] = {}
    return found


def amodal_by_hand(recording: Recording, view: str, frame: int, *, store: Store) -> NDArray[np.bool_] | None:
    """The whole outline, (H, W) bool, that was drawn in one of the recording's frames; None where none was."""
    own = recording.clock().own(view, frame)
    if own is None or view not in recording.views:
        return None
    try:
        mask = MaskHistory(recording.id, recording.views[view], store=store).masks().get(own)
    except CorsmalError:
        return None
    return None if mask is None else mask.amodal_mask


def _named(frames: Iterable[int]) -> str:
    """Frames for people."""
    found = list(frames)
    more = f" and {len(found) - FRAMES_NAMED} more" if len(found) > FRAMES_NAMED else ""
    return f"frame{'s' if len(found) != 1 else ''} {', '.join(map(str, found[:FRAMES_NAMED]))}{more}"
