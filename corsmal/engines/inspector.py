"""A detector in processes of its own, for somebody who waits for it and meanwhile uses this one."""

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property

from corsmal.detection import ViewDetections
from corsmal.engines.engine import Outcome, Row, never
from corsmal.engines.local import default_workers, has_gpu
from corsmal.engines.processes import Processes
from corsmal.engines.tasks import InspectTask
from corsmal.errors import CorsmalError
from corsmal.stages.inspection import Piece
from corsmal.stages.settings import DetectorSettings

WORKERS_MAX = 4
"""More processes would need memory and seconds to load a network for what takes seconds."""


class ProcessInspector:
    """A detector in as many processes as the machine has cores for, at most four; each has its share of the cores.

    A detector in a thread of a program that computes in Python waits for the interpreter at each of its thousands of
    operations, and one process with all cores' threads is slower than a process per core. Loading the network takes
    seconds: the processes wait for the next work, and end with this one.

    Args:
        settings: which detector.
        workers: how many processes; default: as above, one where there is a GPU.
    """

    piece_frames = 2
    """Work that is cancelled is completed as far as it was begun: not more than a few seconds of it."""

    def __init__(self, settings: DetectorSettings, *, workers: int | None = None) -> None:
        self._task = InspectTask(settings)
        self._workers = workers or (1 if has_gpu() else min(WORKERS_MAX, default_workers()))
        self._processes = Processes(self._workers, stays=True)
        self._frames_s: list[float] = []

    @cached_property
    def digest(self) -> str:
        """Of the detector; all processes open it.

        Raises:
            CorsmalError: it cannot be opened.
        """
        rows = [_row(outcome) for outcome in self._processes(self._task, [None] * self._workers)]
        return str(rows[0]["digest"])

    def __call__(
        self, pieces: Sequence[Piece], *, cancelled: Callable[[], bool] = never
    ) -> Iterator[tuple[int, ViewDetections]]:
        """See ``Inspector``.

        Raises:
            CorsmalError: a process could not be started, or the detector failed.
        """
        for outcome in self._processes(self._task, pieces, cancelled=cancelled):
            row = _row(outcome)
            self._frames_s.append(row["seconds"] / len(pieces[outcome.index][1]))
            yield outcome.index, row["found"]

    @property
    def frame_s(self) -> float | None:
        """Seconds per frame with all processes; None until each has inspected two pieces, the first is slower."""
        recent = self._frames_s[-8 * self._workers :]
        return min(recent) / self._workers if len(self._frames_s) >= 2 * self._workers else None

    def close(self) -> None:
        """End the processes."""
        self._processes.close()


def _row(outcome: Outcome) -> Row:
    if outcome.row is None:
        raise CorsmalError(outcome.problem)
    return outcome.row
