"""Many recordings in several processes of this machine."""

import os
import time
from collections import Counter, deque
from collections.abc import Callable, Collection, Container, Generator, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import chain
from multiprocessing.connection import Connection, wait

from corsmal.engines.engine import Item, Outcome, Row, never
from corsmal.engines.workers import FAREWELL_S, THREADS, Worker, can_copy
from corsmal.errors import ArgumentError

ATTEMPTS_MAX = 2
"""A process may be killed for no fault of its recording, which is then begun once more."""

POLL_S = 0.1
"""Between two questions whether the work was cancelled."""

_AHEAD = -1


@dataclass(frozen=True)
class Processes:
    """The engine of several worker processes.

    Each has one recording at a time, so that memory does not grow with the number of recordings, and its share of the
    cores. One that dies (of too little memory, say) is replaced. The workers end with the work, or with this process.

    Args:
        count: how many.
        environment: variables of the workers, beside those of this process.
        gives_way: whether they let other programs go first, see ``GIVING_WAY``.
        stays: whether idle workers wait for the next call, so that it need not start any and load networks anew; work
            that is cancelled is then completed as far as it was begun. ``close`` ends them.
        forks: whether they begin as copies of this process, with the libraries and networks that it has loaded, where
            that is possible. For a program that does nothing else meanwhile, see ``Worker``.

    Raises:
        ArgumentError: fewer than one.
    """

    count: int
    environment: Mapping[str, str] = field(default_factory=dict)
    gives_way: bool = False
    stays: bool = False
    forks: bool = False
    _idle: "deque[Worker]" = field(default_factory=deque, init=False, repr=False, compare=False)
    _ahead: "dict[Worker, int]" = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if self.count < 1:
            raise ArgumentError(f"count must be at least 1, got {self.count}")

    def __str__(self) -> str:
        return f"processes: {self.count}"

    def start(self, task: Callable[[Item], Row], items: Sequence[Item]) -> None:
        """Start all workers ahead of their work; each does the task for one of the items first, in turn.

        Raises:
            CorsmalError: a process could not be started.
        """
        for number in range(self.count):
            worker = self._worker(self.count)
            self._ahead[worker] = _AHEAD
            worker.give(task, _AHEAD, items[number % len(items)])

    def __call__(
        self,
        task: Callable[[Item], Row],
        recordings: Sequence[Item],
        *,
        cancelled: Callable[[], bool] = never,
    ) -> Generator[Outcome]:
        """Yield an outcome for each recording, or anything else that can be pickled, as soon as there is one.

        The task must be importable in another process. ``cancelled`` is checked ten times a second; true drops
        unfinished work and ends the iterator.

        Raises:
            CorsmalError: a process could not be started.
        """
        doing = {worker: deque([index]) for worker, index in self._ahead.items()}
        self._ahead.clear()
        workers, waiting = list(doing), deque(range(len(recordings)))
        deaths: Counter[int] = Counter()
        count = self.count if self.stays else min(self.count, len(recordings))
        try:
            self._complete(workers, count)
            while waiting or set(chain.from_iterable(doing.values())) - {_AHEAD}:
                if cancelled():
                    waiting.clear()
                    if not self.stays:
                        return
                for worker in workers:
                    given = doing.setdefault(worker, deque())
                    # who stays has short tasks, the next of which is there when one is done; the last are shared out
                    while waiting and len(given) < (2 if self.stays and len(waiting) > count else 1):
                        given.append(waiting.popleft())
                        worker.give(task, given[-1], recordings[given[-1]])
                busy = [worker for worker, given in doing.items() if given]
                for worker in _answering(busy, None if cancelled is never else POLL_S):
                    index, outcome = doing[worker].popleft(), worker.answer()
                    if outcome is None:
                        waiting.extend(doing.pop(worker))
                        workers[workers.index(worker)] = self._worker(count)
                        deaths[index] += 1
                        if index != _AHEAD and deaths[index] < ATTEMPTS_MAX:
                            waiting.append(index)
                            continue
                        outcome = Outcome(index, problem=f"its process ended {ATTEMPTS_MAX} times, {worker.end()}")
                    if index != _AHEAD:
                        yield outcome
        finally:
            self._leave(workers, [worker for worker, given in doing.items() if given])

    def close(self) -> None:
        """End the workers that wait for the next call."""
        self._leave([], (), room=0)

    def _complete(self, workers: list[Worker], count: int) -> None:
        """Take idle workers and start others until there are enough."""
        with suppress(IndexError):
            while len(workers) < count:
                workers.append(self._idle.popleft())
        workers.extend(self._worker(count) for _ in range(count - len(workers)))

    def _leave(self, workers: Sequence[Worker], busy: Container[Worker], *, room: int | None = None) -> None:
        """End the workers, but for idle ones that stay."""
        room = self.count if room is None and self.stays else room or 0
        self._idle.extend(each for each in workers if self.stays and each not in busy)
        superfluous = [self._idle.popleft() for _ in range(len(self._idle) - room)]
        _end([*superfluous, *(worker for worker in workers if not self.stays or worker in busy)], busy)

    def _worker(self, count: int) -> Worker:
        threads = dict.fromkeys(THREADS, str(max(1, cores() // count)))
        environment = threads | os.environ | dict(self.environment)
        is_copy = self.forks and can_copy() and all(environment[name] == "1" for name in THREADS)
        worker = Worker(environment, is_copy=is_copy)
        if self.gives_way:
            worker.give_way()
        return worker


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _end(workers: Collection[Worker], busy: Container[Worker]) -> None:
    for worker in workers:
        worker.stop(is_busy=worker in busy)
    end_s = time.monotonic() + FAREWELL_S
    for worker in workers:
        worker.join(max(0.0, end_s - time.monotonic()))


def _answering(busy: Iterable[Worker], timeout_s: float | None) -> list[Worker]:
    """Wait for those that have an answer, or have died."""
    by_connection = {worker.connection: worker for worker in busy}
    return [by_connection[ready] for ready in wait(by_connection, timeout_s) if isinstance(ready, Connection)]
