"""Detecting in recordings, with what was found kept in the store."""

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from corsmal.dataset import Recording, View
from corsmal.detection import Detections, Detector, ViewDetections, detect_view
from corsmal.detection.parquet import read_parquet, write_parquet
from corsmal.errors import ArgumentError, FileError
from corsmal.estimation import read_view_detections
from corsmal.parameters import METHOD_VIEWS, PAIRS
from corsmal.selection import select_best_frame
from corsmal.store import Store, digest, file_fingerprint

if TYPE_CHECKING:
    from corsmal.dataset import Video

KEEP_EVERY_S = 10.0
"""A process that dies loses no more of its work than these."""

COARSEST = 16
"""The first frames to be inspected are so far apart: results are spread over the video from the start."""


@dataclass(frozen=True, eq=False)
class DetectionSet:
    """The detections of one recording, wherever they came from.

    Args:
        views: by view.
        key: ``detections_origin`` before they were read: two sets with the same key are the same.
        notes: one sentence for each view whose file could not be used, and for what was skipped in one.
    """

    views: Mapping[str, ViewDetections]
    key: str
    notes: tuple[str, ...] = ()

    @property
    def missing(self) -> tuple[str, ...]:
        """The method's views without detections."""
        return tuple(name for name in METHOD_VIEWS if name not in self.views)


def load_detections(recording: Recording, *, store: Store) -> DetectionSet:
    """The detections of a recording: the file beside the video, else what the store holds of the last detector run."""
    origin = detections_origin(recording, store=store)
    views: dict[str, ViewDetections] = {}
    notes: list[str] = []
    for name, view in recording.views.items():
        try:
            found = read_view_detections(view)
        except FileError as error:
            notes.append(str(error))
            found = None
        if found is None and (kept := _latest(view, store)) is not None:
            found = _read_kept(kept, store)
        if found is not None:
            views[name] = found
            notes += [f"{view.detections_path or name}: {problem}" for problem in found.problems]
    return DetectionSet(views, origin, tuple(notes))


def detections_origin(recording: Recording, *, store: Store) -> str:
    """A digest of the files that ``load_detections`` reads, without reading them: it changes when one of them does."""
    origins: list[object] = []
    for name, view in recording.views.items():
        paths = [view.video_path] if view.detections_path is None else [view.video_path, view.detections_path]
        kept = _latest(view, store)
        if kept is not None:
            paths.append(_kept_file(kept, store))
        origins += [name, kept, [file_fingerprint(path) if path.is_file() else None for path in paths]]
    return digest("origin of detections", *origins)


def needs_detection(recording: Recording, detector_digest: str, *, store: Store) -> bool:
    """Whether a view without a detections file has no detections, or those of one detector, maybe not all of them."""
    views = [recording.views[name] for name in METHOD_VIEWS if name in recording.views]
    open_views = [view for view in views if view.detections_path is None]
    return any(_latest(view, store) in (None, _key(view, detector_digest)) for view in open_views)


def detect_recording(
    recording: Recording,
    detector: Detector,
    *,
    store: Store,
    every: int = 1,
    progress: Callable[[int, int], None] | None = None,
    kept: Callable[[], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> None:
    """Detect in the method's views and keep the results; frames that were inspected before are not inspected again.

    The frames are gone through from coarse to fine: every sixteenth or so, then those between. With ``every`` above 1
    that ends early, and only the frames beside each pair's best one so far are inspected more closely.

    Args:
        recording: views that lack a video, or have a detections file, are skipped.
        detector: such as ``MaskRCNNDetector``.
        store: where the results are kept.
        every: step of the search for the best frame; 1 inspects all frames.
        progress: called with the numbers of frames done and wanted, over all views.
        kept: called when more results can be read from the store.
        cancelled: checked between batches; true stops the work and keeps what was done.

    Raises:
        ArgumentError: ``every`` is not positive.
        FileError: a video cannot be opened, raised after the other views are done; or the results cannot be written.
    """
    if every < 1:
        raise ArgumentError(f"every must be at least 1, got {every}")
    works, broken = _openable(recording, detector, store)
    stop, keep = cancelled or (lambda: False), kept or (lambda: None)
    levels = (every - 1).bit_length()
    beside = 2 * len(PAIRS)
    total = sum(len(range(0, work.frame_count, every)) + levels * beside for work in works)
    done = 0

    def report(more: int) -> None:
        if progress is not None:
            progress(min(done + more, total), total)

    report(0)
    seen: set[int] = set()
    for step in _strides(every):
        for work in works:
            frames = [frame for frame in range(0, work.frame_count, step) if frame not in seen]
            work.inspect(frames, report, stop)
            done += len(frames)
        seen.update(range(0, max((work.frame_count for work in works), default=0), step))
        keep()
    for level in range(levels):
        frames = _beside_the_best(load_detections(recording, store=store), seen, -(-every // 2 ** (level + 1)))
        seen.update(frames)
        for work in works:
            work.inspect([frame for frame in frames if 0 <= frame < work.frame_count], report, stop)
            done += beside
        keep()
    if not stop():
        report(total)
    if broken is not None:
        raise broken


def _openable(recording: Recording, detector: Detector, store: Store) -> "tuple[list[_ViewWork], FileError | None]":
    """The views to detect in, and the error of one whose video cannot be opened."""
    works, broken = [], None
    for name in METHOD_VIEWS:
        view = recording.views.get(name)
        if view is None or view.detections_path is not None:
            continue
        try:
            works.append(_ViewWork(view, detector, store))
        except FileError as error:
            broken = error
    return works, broken


def _strides(every: int) -> list[int]:
    """Steps between frames, each half of the one before, from about ``COARSEST`` down to ``every``."""
    doublings = max(0, (COARSEST // every).bit_length() - 1)
    return [every * 2**power for power in range(doublings, -1, -1)]


def _beside_the_best(detections: DetectionSet, seen: set[int], step: int) -> list[int]:
    """The frames a step before and after the best frame of each pair.

    Only frames of this search count, not others in the store: a repeated search then takes the same steps and
    finds them kept.
    """
    views = {name: {frame: view[frame] for frame in seen.intersection(view)} for name, view in detections.views.items()}
    found = [select_best_frame(views, pair=pair).frame for pair in PAIRS]
    return sorted({frame + side for frame in found if frame is not None for side in (-step, step)})


class _ViewWork:
    """Detecting in one view, on top of what the store holds."""

    def __init__(self, view: View, detector: Detector, store: Store) -> None:
        self._view, self._detector, self._store = view, detector, store
        self._key = _key(view, detector.digest)
        self._found = _read_kept(self._key, store)
        with view.video() as video:
            self.frame_count = video.frame_count

    def inspect(self, frames: Iterable[int], report: Callable[[int], None], stop: Callable[[], bool]) -> None:
        """Detect in those frames that were not inspected yet, and keep the results every few seconds."""
        asked = list(frames)
        wanted = [frame for frame in asked if frame not in (self._found or {})]
        report(len(asked) - len(wanted))
        if wanted and not stop():
            with self._view.video() as video:
                while wanted and not stop():
                    found = self._detect(video, wanted, len(asked) - len(wanted), report, stop)
                    wanted = [frame for frame in wanted if frame not in found]
                    if any("cannot be read" in problem for problem in found.problems):
                        break
        if self._found is not None:
            self._store.save_json("latest", _latest_key(self._view), {"detections": self._key})

    def _detect(
        self, video: "Video", frames: list[int], done: int, report: Callable[[int], None], stop: Callable[[], bool]
    ) -> ViewDetections:
        """Detect for a few seconds, one batch of frames at least, and keep what was found."""
        end_s = time.monotonic() + KEEP_EVERY_S
        batches: list[int] = []

        def note(more: int, _total: int) -> None:
            batches.append(more)
            report(done + more)

        found = detect_view(
            video,
            self._detector,
            frames=frames,
            progress=note,
            cancelled=lambda: stop() or (bool(batches) and time.monotonic() > end_s),
        )
        # read again: another process may have kept frames of the same view in the meantime
        earlier: Mapping[int, Detections] = _read_kept(self._key, self._store) or self._found or {}
        problems = tuple(problem for problem in found.problems if "cannot be read" in problem)
        self._found = ViewDetections({**earlier, **found}, size=found.size, source=found.source, problems=problems)
        if not self._store.write(_kept_file(self._key, self._store), partial(write_parquet, self._found)):
            raise FileError(self._store.root, f"the detections could not be kept: {self._store.problems[-1]}")
        return found


def _key(view: View, detector_digest: str) -> str:
    """Where the store keeps what a detector found in a view."""
    return digest("detections", file_fingerprint(view.video_path), detector_digest)


def _kept_file(key: str, store: Store) -> Path:
    return store.file("detections", key, ".parquet")


def _read_kept(key: str, store: Store) -> ViewDetections | None:
    return store.read(_kept_file(key, store), read_parquet)


def _latest(view: View, store: Store) -> str | None:
    """The key of what the last detector found in a view; None where there is nothing."""
    key = (store.json("latest", _latest_key(view)) or {}).get("detections")
    return key if isinstance(key, str) and _kept_file(key, store).is_file() else None


def _latest_key(view: View) -> str:
    return digest("latest detections", file_fingerprint(view.video_path))
