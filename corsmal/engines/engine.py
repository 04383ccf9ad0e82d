"""The same work on many recordings, one after the other or elsewhere: what the engines have in common."""

from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from corsmal.dataset import Recording
from corsmal.errors import CorsmalError
from corsmal.notes import listening, repeat

Item = TypeVar("Item")
Row = dict[str, Any]
Task = Callable[[Recording], Row]
"""What is done with a recording. For an engine that works elsewhere it can be pickled, and costs little to send."""


@dataclass(frozen=True)
class Outcome:
    """What became of one recording.

    Args:
        index: of the recording among those that were given.
        row: the result; None where there is none.
        problem: why there is none, one sentence.
        said: what the store said meanwhile, such as that a kept result cannot be read.
    """

    index: int
    row: Row | None = None
    problem: str = ""
    said: tuple[str, ...] = ()


class Engine(Protocol):
    """Does a task for recordings, in whatever order suits it; stops at once when its iterator is closed."""

    def __call__(
        self, task: Task, recordings: Sequence[Recording], /, *, cancelled: Callable[[], bool] = ...
    ) -> Iterator[Outcome]:
        """Yield an outcome for each recording as soon as there is one; end early once ``cancelled`` is true."""


def never() -> bool:
    """Not cancelled."""
    return False


def attempt(task: Callable[[Item], Row], index: int, recording: Item) -> Outcome:
    """Do the task for one recording; whatever it raises is the problem of this recording only."""
    row, problem = None, ""
    with listening() as said:
        try:
            row = task(recording)
        except CorsmalError as error:
            problem = str(error)
        except Exception as error:  # noqa: BLE001 - one unforeseen recording must not end an evening's run
            problem = f"stopped unexpectedly: {error!r}"
    return Outcome(index, row, problem, tuple(said))


def in_turn(
    task: Callable[[Item], Row], recordings: Sequence[Item], *, cancelled: Callable[[], bool] = never
) -> Generator[Outcome]:
    """The engine of this process."""
    for index, recording in enumerate(recordings):
        if cancelled():
            return
        yield attempt(task, index, recording)


def completed_rows(
    task: Task,
    recordings: Sequence[Recording],
    *,
    engine: Engine = in_turn,
    progress: Callable[[int, int], None] | None = None,
    cancelled: Callable[[], bool] = never,
) -> Iterator[Row]:
    """The recordings' rows in the order in which they are done.

    Args:
        task: what is done with each, such as an ``EstimateTask``; what it keeps in the store lasts however this ends.
        recordings: the recordings.
        engine: where it is done: ``in_turn``, ``Processes`` or ``DaskCluster``.
        progress: called with the numbers of recordings done and wanted.
        cancelled: checked while the engine works; true ends the rows, and what has only been begun is dropped.

    Yields:
        Rows; a recording that could not be done is a failed row whose notes say why.

    Raises:
        CorsmalError: the engine itself failed, such as a cluster that does not answer.
    """
    if progress is not None:
        progress(0, len(recordings))
    for done, outcome in enumerate(engine(task, recordings, cancelled=cancelled), start=1):
        repeat(outcome.said)
        if cancelled():
            return
        name = recordings[outcome.index].id
        yield outcome.row or {"recording_id": name, "status": "failed", "notes": outcome.problem}
        if progress is not None:
            progress(done, len(recordings))


def run_batch(
    task: Task,
    recordings: Sequence[Recording],
    *,
    engine: Engine = in_turn,
    progress: Callable[[int, int], None] | None = None,
) -> list[Row]:
    """A row for every recording, in the recordings' order; the arguments are those of ``completed_rows``."""
    by_id = {row["recording_id"]: row for row in completed_rows(task, recordings, engine=engine, progress=progress)}
    return [by_id[recording.id] for recording in recordings]
