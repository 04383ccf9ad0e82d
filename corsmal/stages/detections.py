"""The detections of a recording: a file beside the video, or what the store holds of a detector."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from corsmal.dataset import Recording, View
from corsmal.dataset.clock import Matching
from corsmal.detection import ViewDetections
from corsmal.detection.parquet import read_parquet, write_parquet
from corsmal.errors import FileError
from corsmal.estimation import read_view_detections
from corsmal.estimation.detected import recording_frames
from corsmal.notes import Note, prefixed
from corsmal.parameters import METHOD_VIEWS
from corsmal.stages.by_hand import masks_origin, with_masks_by_hand
from corsmal.stages.version import READING_VERSION
from corsmal.store import Store, digest, file_fingerprint

POINTERS = ("latest", "latest-twin")
"""Kinds of the store: each names what the last detector found in a view. Where one is damaged, the other is read."""


@dataclass(frozen=True, eq=False)
class DetectionSet:
    """The detections of one recording, wherever they came from.

    Args:
        views: by view.
        key: ``detections_origin`` before they were read: two sets with the same key are the same.
        notes: one sentence for each view whose file could not be used, and for what was skipped in one.
        lost: views in which a detector had found something that the store kept and that cannot be read any more.
    """

    views: Mapping[str, ViewDetections]
    key: str
    notes: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()

    @property
    def missing(self) -> tuple[str, ...]:
        """The method's views without detections."""
        return tuple(name for name in METHOD_VIEWS if name not in self.views)


def load_detections(recording: Recording, *, store: Store) -> DetectionSet:
    """The detections of a recording: the file beside the video, else what the store holds of the last detector run.

    Where the recording's ``masks`` are ``by-hand``, those take the place of what was detected in their frames.
    """
    origin = detections_origin(recording, store=store)
    views: dict[str, ViewDetections] = {}
    notes: list[str] = []
    lost: list[str] = []
    for name, view in recording.views.items():
        try:
            found = read_view_detections(view)
        except FileError as error:
            notes.append(Note(str(error), flag="detections-incomplete"))
            found = None
        if found is None and (kept := _latest(view, store)) is not None:
            found = _read_kept(kept, store)
        if recording.masks == "by-hand":
            found, said = with_masks_by_hand(recording, view, found, store=store)
            notes += said
        if found is not None:
            views[name] = recording_frames(recording, name, found)
            notes += [prefixed(str(view.detections_path or name), problem) for problem in found.problems]
        elif _is_lost(view, store):
            lost.append(name)
            sentence = f"{name}: the detections that were kept cannot be read; run the detector again"
            notes.append(Note(sentence, flag="detections-incomplete"))
    return DetectionSet(views, origin, (*recording.clock().notes, *notes), tuple(lost))


def detections_origin(recording: Recording, *, store: Store) -> str:
    """A digest of the files that ``load_detections`` reads, without reading them: it changes when one of them does."""
    origins: list[object] = [] if recording.matching == Matching() else [recording.matching]
    for name, view in recording.views.items():
        paths = [view.video_path] if view.detections_path is None else [view.video_path, view.detections_path]
        kept = _latest(view, store)
        if kept is not None:
            paths.append(_kept_file(kept, store))
        origins += ["lost"] if kept is None and _is_lost(view, store) else []
        origins += [] if view.detections_path is None else [READING_VERSION]
        origins += [name, kept, [file_fingerprint(path) if path.is_file() else None for path in paths]]
    if recording.masks == "by-hand":
        origins += masks_origin(recording, store=store)
    return digest("origin of detections", *origins)


def has_detections(view: View, *, store: Store) -> bool:
    """Whether a view has a file of detections or some in the store; whether they can be read is for reading to say."""
    return view.detections_path is not None or _latest(view, store) is not None


def needs_detection(recording: Recording, detector_digest: str, *, store: Store) -> bool:
    """Whether a view without a detections file has no detections, or those of one detector, maybe not all of them."""
    views = [recording.views[name] for name in METHOD_VIEWS if name in recording.views]
    open_views = [view for view in views if view.detections_path is None]
    return any(_latest(view, store) in (None, _key(view, detector_digest)) for view in open_views)


def kept_detections(view: View, detector_digest: str, *, store: Store) -> ViewDetections | None:
    """What a detector found in a view so far; None where the store holds nothing."""
    return _read_kept(_key(view, detector_digest), store)


def keep_detections(found: ViewDetections, view: View, detector_digest: str, *, store: Store) -> None:
    """Keep what a detector found in a view, in the place of what it found before.

    Raises:
        FileError: the store cannot be written.
    """
    if not store.write(_kept_file(_key(view, detector_digest), store), partial(write_parquet, found)):
        raise FileError(store.root, f"the detections could not be kept: {store.problems[-1]}")


def show_detections_of(detector_digest: str, view: View, *, store: Store) -> None:
    """Let what this detector found in a view be what ``load_detections`` returns."""
    _point_to(_key(view, detector_digest), view, store)


def _key(view: View, detector_digest: str) -> str:
    """Where the store keeps what a detector found in a view."""
    return digest("detections", file_fingerprint(view.video_path), detector_digest)


def _kept_file(key: str, store: Store) -> Path:
    return store.file("detections", key, ".parquet")


def _read_kept(key: str, store: Store) -> ViewDetections | None:
    return store.read(_kept_file(key, store), partial(read_parquet, is_own=True))


def _point_to(key: str, view: View, store: Store) -> None:
    for kind in POINTERS:
        store.save_json(kind, _latest_key(view), {"detections": key})


def _latest(view: View, store: Store) -> str | None:
    """The key of what the last detector found in a view; None where there is nothing."""
    for kind in POINTERS:
        key = _pointed(kind, view, store)
        if key is not None and os.path.isfile(_kept_file(key, store)):
            if kind != POINTERS[0]:
                _point_to(key, view, store)
            return key
    return None


def _is_lost(view: View, store: Store) -> bool:
    """Whether there are remains of what the last detector found in a view, where ``_latest`` finds nothing."""
    for kind in POINTERS:
        key = _pointed(kind, view, store)
        path = store.file(kind, _latest_key(view), ".json") if key is None else _kept_file(key, store)
        if store.has_remains(path):
            return True
    return False


def _pointed(kind: str, view: View, store: Store) -> str | None:
    key = (store.json(kind, _latest_key(view)) or {}).get("detections")
    return key if isinstance(key, str) else None


def _latest_key(view: View) -> str:
    return digest("latest detections", file_fingerprint(view.video_path))
