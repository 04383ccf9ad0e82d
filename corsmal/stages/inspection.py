"""Detecting in frames of a recording's views, here or in other processes, with what was found kept in the store."""

import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import chain, zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from corsmal.dataset import View
from corsmal.dataset.clock import FrameClock
from corsmal.detection import Detections, Detector, ViewDetections, detect_view
from corsmal.stages.detections import keep_detections, kept_detections, show_detections_of
from corsmal.store import Store

if TYPE_CHECKING:
    from corsmal.dataset import Video

KEEP_EVERY_S = 10.0
"""A process that dies loses no more of its work than these."""

Piece = tuple[View, tuple[int, ...]]
"""Frames of a view that are inspected together."""


class Inspector(Protocol):
    """A detector in this process or in others."""

    @property
    def digest(self) -> str:
        """Of the detector, see ``Detector``."""

    @property
    def piece_frames(self) -> int:
        """How many frames a piece has at most."""

    def __call__(
        self, pieces: Sequence[Piece], *, cancelled: Callable[[], bool]
    ) -> Iterator[tuple[int, ViewDetections]]:
        """Yield the number of a piece and what was found in it, in any order; end early once ``cancelled`` is true."""


@dataclass(frozen=True)
class InProcess:
    """A detector in this process.

    Args:
        detector: the detector.
        piece_frames: the size of its batches.
    """

    detector: Detector
    piece_frames: int = 4

    @property
    def digest(self) -> str:
        """Of the detector."""
        return self.detector.digest

    def __call__(
        self, pieces: Sequence[Piece], *, cancelled: Callable[[], bool]
    ) -> Iterator[tuple[int, ViewDetections]]:
        """See ``Inspector``."""
        videos: dict[Path, Video] = {}
        with ExitStack() as opened:
            for index, (view, frames) in enumerate(pieces):
                if cancelled():
                    return
                if view.video_path not in videos:
                    videos[view.video_path] = opened.enter_context(view.video())
                yield index, detect_view(videos[view.video_path], self.detector, frames=frames)


class Inspection:
    """Inspecting some frames after the other in all views."""

    def __init__(
        self,
        works: "Sequence[ViewWork]",
        inspector: Inspector,
        *,
        progress: Callable[[int, int], None] | None,
        kept: Callable[[], None] | None,
        cancelled: Callable[[], bool] | None,
    ) -> None:
        self.works, self._inspector = works, inspector
        self._progress, self._kept, self._cancelled = progress, kept or (lambda: None), cancelled or (lambda: False)
        self._done = self._total = 0
        self.is_stopped = False

    def begin(self, total: int) -> None:
        """Say how many frames there are."""
        self._total = total
        self._report(0)

    def end(self) -> None:
        """Say that all is done, unless it was stopped."""
        if not self._is_cancelled():
            self._report(self._total)

    def inspect(self, *passes: Collection[int], counted: int | None = None) -> None:
        """Detect in those frames that were not inspected yet; keep the results after each pass, and every few seconds.

        Args:
            passes: frames of all views, those of the first pass first; no process waits for the end of a pass.
            counted: for how many frames of each view they count in what is reported; default: as many as it has.
        """
        if self._is_cancelled():
            return
        asked = [[_within(frames, work.frame_count) for frames in passes] for work in self.works]
        wanted = [work.missing(frames) for work, frames in zip(self.works, asked, strict=True)]
        pieces: list[tuple[ViewWork, tuple[int, ...]]] = []
        ends = []
        for missing in zip(*wanted, strict=True):
            pieces += _in_turn(list(zip(self.works, missing, strict=True)), self._inspector.piece_frames)
            ends.append(len(pieces))
        total = sum(map(len, chain.from_iterable(asked)))
        done = total - sum(len(piece) for _, piece in pieces)
        self._report(done)
        left, kept_s = set(range(len(pieces))), time.monotonic()
        try:
            todo = [(work.view, piece) for work, piece in pieces]
            for index, found in self._inspector(todo, cancelled=self._is_cancelled) if todo else ():
                work, piece = pieces[index]
                work.add(found)
                done += len(piece)
                self._report(done)
                left.discard(index)
                complete = min(left, default=len(pieces))
                if complete >= ends[0] or time.monotonic() - kept_s >= KEEP_EVERY_S:
                    self._keep()
                    kept_s = time.monotonic()
                    ends = [end for end in ends if end > complete]
        finally:
            self._keep()
        self._done += total if counted is None else counted * len(self.works)

    def _keep(self) -> None:
        have_kept = [work.keep() for work in self.works]
        if any(have_kept):
            self._kept()

    def _report(self, more: int) -> None:
        if self._progress is not None:
            self._progress(min(self._done + more, self._total), self._total)

    def _is_cancelled(self) -> bool:
        self.is_stopped = self.is_stopped or self._cancelled()
        return self.is_stopped


def _within(frames: Collection[int], frame_count: int) -> list[int]:
    return [frame for frame in sorted(frames) if 0 <= frame < frame_count]


def _in_turn(
    wanted: "Sequence[tuple[ViewWork, list[int]]]", piece_frames: int
) -> "list[tuple[ViewWork, tuple[int, ...]]]":
    """Pieces of the frames, of one view after the other: a frame counts only when a pair of views has it."""
    by_view = [
        [(work, tuple(frames[first : first + piece_frames])) for first in range(0, len(frames), piece_frames)]
        for work, frames in wanted
    ]
    return [piece for piece in chain.from_iterable(zip_longest(*by_view)) if piece is not None]


class ViewWork:
    """Detecting in one view, on top of what the store holds."""

    def __init__(self, view: View, detector_digest: str, store: Store, *, clock: FrameClock) -> None:
        self._clock = clock
        self.view, self._digest, self._store = view, detector_digest, store
        self._found = kept_detections(view, detector_digest, store=store)
        self._new: list[ViewDetections] = []
        with view.video() as video:
            self.frame_count = len(clock) if view.name in clock.frames else video.frame_count

    def missing(self, passes: Sequence[Sequence[int]]) -> list[list[int]]:
        """The view's own frames of those of the recording that were not inspected yet, each in its first pass."""
        seen, missing = set(self._found or ()), []
        for frames in passes:
            owns = dict.fromkeys(self._clock.own(self.view.name, frame) for frame in frames)
            missing.append([own for own in owns if own is not None and own not in seen])
            seen.update(missing[-1])
        return missing

    def add(self, found: ViewDetections) -> None:
        """Take what was found, to be kept."""
        self._new.append(found)

    def keep(self) -> bool:
        """Keep what was found, if anything, and let it be what the pages show."""
        is_more = bool(self._new)
        if is_more:
            # read again: another process may have kept frames of the same view in the meantime
            earlier: Mapping[int, Detections] = (
                kept_detections(self.view, self._digest, store=self._store) or self._found or {}
            )
            frames = dict(earlier)
            for found in self._new:
                frames.update(found)
            problems = [problem for found in self._new for problem in found.problems if "cannot be read" in problem]
            last = self._new[-1]
            self._found = ViewDetections(frames, size=last.size, source=last.source, problems=tuple(problems[:1]))
            keep_detections(self._found, self.view, self._digest, store=self._store)
            self._new = []
        if self._found is not None:
            show_detections_of(self._digest, self.view, store=self._store)
        return is_more
