"""How far a run is, stage by stage, and how long the rest will take."""

import time
from collections import Counter, deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, get_args

from corsmal.dataset import Recording
from corsmal.errors import CorsmalError
from corsmal.stages.detections import detections_origin, needs_detection
from corsmal.stages.estimates import Predictors, kept_row
from corsmal.store import Store

Work = Literal["read", "detect", "estimate"]
"""What is to be done with a recording: its row is read from the store, it is estimated, or detected in before that."""

RECENT = 8
"""The pace is that of the last recordings, this number for each worker."""

FRAMES_LEAST = 6
"""The number of frames after which a detector's pace is known; the first one is slower."""


@dataclass(frozen=True)
class RunProgress:
    """How far a run is.

    Args:
        done: recordings that have their row.
        total: recordings that are wanted.
        stages: by ``Work``, how many recordings are done and wanted; only what there is to do.
        left_s: how long the rest will take; None as long as some kind of work has not been timed.
        is_at_most: whether ``left_s`` also counts that the workers had to start, and the rest will be quicker.
        frames: of the recording in which is being detected, how many are inspected and wanted; None where that is not
            known, such as in other processes.
    """

    done: int
    total: int
    stages: Mapping[Work, tuple[int, int]]
    left_s: float | None
    is_at_most: bool = False
    frames: tuple[int, int] | None = None

    @property
    def fraction(self) -> float:
        """Of all recordings, 0 to 1, with what is done of the one in which is being detected."""
        inspected, wanted = self.frames or (0, 0)
        return (self.done + inspected / max(1, wanted)) / max(1, self.total)


def planned_work(recording: Recording, predictors: Predictors, detector_digest: str, *, store: Store) -> Work:
    """What a run will have to do with a recording.

    Args:
        recording: the recording.
        predictors: what it is estimated with.
        detector_digest: of the detector that precedes the estimate; empty for none.
        store: has what was done before.
    """
    try:
        if detector_digest and needs_detection(recording, detector_digest, store=store):
            return "detect"
        origin = detections_origin(recording, store=store)
        return "estimate" if kept_row(recording, predictors, origin, store=store) is None else "read"
    except CorsmalError:
        return "estimate"


class RunPace:
    """Times a run's recordings by the kind of work that they need.

    Rows that are read come at once, and a detector takes longer than all the rest: one pace for all of them would
    promise far too little or too much. The time between two rows counts for the kind of the second. With several
    workers that is right on the average over as many rows as there are workers; nothing is said before these are there.
    The first row of each worker, which had to start and to read networks, counts only until there are others.

    Args:
        work: by recording, what is to be done.
        workers: how many recordings are worked on at the same time.
        clock: seconds, without those in which other work went first.
        watch: called with how far the run is, at first and whenever that changes.
    """

    def __init__(
        self,
        work: Mapping[str, Work],
        *,
        workers: int = 1,
        clock: Callable[[], float] = time.monotonic,
        watch: Callable[[RunProgress], None] | None = None,
    ) -> None:
        self._work, self._workers, self._clock, self._watch = dict(work), workers, clock, watch
        counts = Counter(self._work.values())
        kinds: list[Work] = [kind for kind in get_args(Work) if counts[kind]]
        self._wanted: dict[Work, int] = {kind: counts[kind] for kind in kinds}
        self._done: dict[Work, int] = dict.fromkeys(kinds, 0)
        self._times_s: dict[Work, deque[float]] = {kind: deque(maxlen=RECENT * workers) for kind in kinds}
        self._first_s: dict[Work, list[float]] = {kind: [] for kind in kinds}
        self._last_s = clock()
        self._frames: tuple[int, int] | None = None
        self._told()

    def finished(self, recording: str) -> RunProgress:
        """A recording has its row."""
        kind = self._work.pop(recording, None)
        now_s = self._clock()
        if kind is not None:
            self._done[kind] += 1
            is_first = kind != "read" and sum(map(len, self._first_s.values())) < self._workers
            (self._first_s if is_first else self._times_s)[kind].append(now_s - self._last_s)
        self._last_s, self._frames = now_s, None
        return self._told()

    def inspected(self, frames: int, wanted: int) -> RunProgress:
        """So many frames are inspected of the recording in which is being detected."""
        self._frames = frames, wanted
        return self._told()

    def _told(self) -> RunProgress:
        progress = self.progress
        if self._watch is not None:
            self._watch(progress)
        return progress

    @property
    def progress(self) -> RunProgress:
        """How far the run is."""
        stages = {kind: (self._done[kind], wanted) for kind, wanted in self._wanted.items()}
        left_s, is_at_most = self._left_s()
        done, total = sum(self._done.values()), sum(self._wanted.values())
        return RunProgress(done, total, stages, left_s, is_at_most, self._frames)

    def _left_s(self) -> tuple[float | None, bool]:
        """How long the rest will take, and whether that is known only from rows for which a worker had to start."""
        left_s, is_at_most = 0.0, False
        for kind, wanted in self._wanted.items():
            left, times_s = wanted - self._done[kind], [*self._times_s[kind]]
            enough = 1 if kind == "read" else min(self._workers, wanted)
            if left and len(times_s) < enough:
                times_s, is_at_most = times_s + self._first_s[kind], True
            times_s = times_s if len(times_s) >= enough else []
            if kind == "detect" and left and self._frames and self._frames[0] >= FRAMES_LEAST:
                spent_s = self._clock() - self._last_s
                whole_s = spent_s * self._frames[1] / self._frames[0]
                left_s += max(0.0, whole_s - spent_s)
                left, times_s = left - 1, times_s or [whole_s]
            if left and not times_s:
                return None, False
            left_s += left * sum(times_s) / max(1, len(times_s))
        return left_s, is_at_most
