"""Many recordings in several processes of this machine."""

import os
import signal
import subprocess
import sys
import time
from collections import Counter, deque
from collections.abc import Callable, Collection, Container, Generator, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import chain
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

from corsmal.engines.engine import Item, Outcome, Row, attempt, never
from corsmal.errors import ArgumentError, CorsmalError

ATTEMPTS_MAX = 2
"""A process may be killed for no fault of its recording, which is then begun once more."""

FAREWELL_S = 3.0
"""How long processes that are stopped may take to remove unfinished files."""

GIVING_WAY = 15
"""Niceness of work that is not awaited: without it a detector on the same cores is ten times slower."""

POLL_S = 0.1
"""Between two questions whether the work was cancelled."""

THREADS = ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "OPENCV_FOR_THREADS_NUM")
"""The variables that limit threads: of PyTorch, NumPy and Arrow; of Numba; of OpenCV."""

_AHEAD = -1
_PACKAGE_PARENT = str(Path(__file__).resolve().parents[2])


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

    Raises:
        ArgumentError: fewer than one.
    """

    count: int
    environment: Mapping[str, str] = field(default_factory=dict)
    gives_way: bool = False
    stays: bool = False
    _idle: "deque[_Worker]" = field(default_factory=deque, init=False, repr=False, compare=False)
    _ahead: "dict[_Worker, int]" = field(default_factory=dict, init=False, repr=False, compare=False)

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

    def _complete(self, workers: "list[_Worker]", count: int) -> None:
        """Take idle workers and start others until there are enough."""
        with suppress(IndexError):
            while len(workers) < count:
                workers.append(self._idle.popleft())
        workers += [self._worker(count) for _ in range(count - len(workers))]

    def _leave(self, workers: "Sequence[_Worker]", busy: "Container[_Worker]", *, room: int | None = None) -> None:
        """End the workers, but for idle ones that stay."""
        room = self.count if room is None and self.stays else room or 0
        self._idle.extend(worker for worker in workers if self.stays and worker not in busy)
        superfluous = [self._idle.popleft() for _ in range(len(self._idle) - room)]
        _end([*superfluous, *(worker for worker in workers if not self.stays or worker in busy)], busy)

    def _worker(self, count: int) -> "_Worker":
        threads = dict.fromkeys(THREADS, str(max(1, cores() // count)))
        worker = _Worker(threads | os.environ | dict(self.environment))
        if self.gives_way:
            worker.give_way()
        return worker


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class _Worker:
    """One process, which does one task after the other."""

    def __init__(self, environment: Mapping[str, str]) -> None:
        self.connection, theirs = Pipe()
        path = os.pathsep.join(filter(None, [_PACKAGE_PARENT, environment.get("PYTHONPATH")]))
        try:
            # not by multiprocessing, whose children would run this program's main module, an app's script, say
            self._process = subprocess.Popen(
                [sys.executable, "-m", "corsmal.engines.worker", str(theirs.fileno())],
                stdin=subprocess.PIPE,
                pass_fds=[theirs.fileno()],
                env={**environment, "PYTHONPATH": path},
                process_group=0,  # the keyboard reaches only this process, which decides
            )
        except OSError as error:
            self.connection.close()
            raise CorsmalError(f"no process could be started ({error.strerror}); free some memory") from error
        finally:
            theirs.close()

    def give(self, task: Callable[[Any], Row], index: int, item: object) -> None:
        with suppress(OSError):  # a process that has died is found out by the answer that it does not give
            self.connection.send((attempt, task, index, item))

    def give_way(self) -> None:
        with suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, self._process.pid, GIVING_WAY)

    def answer(self) -> Outcome | None:
        """What became of the recording; None where the process died over it."""
        try:
            outcome: Outcome = self.connection.recv()
        except (EOFError, OSError):
            self.join(FAREWELL_S)
            return None
        return outcome

    def end(self) -> str:
        """How the process ended, for people."""
        code = self._process.returncode
        killed = " (too little memory?)" if code == -signal.SIGKILL else ""
        return f"by signal {-code}{killed}" if code < 0 else f"with exit status {code}"

    def stop(self, *, is_busy: bool) -> None:
        self.connection.close()  # which an idle process takes for the end
        if is_busy:
            self._process.terminate()

    def join(self, timeout_s: float) -> None:
        try:
            self._process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stdin is not None:
            self._process.stdin.close()


def _end(workers: Collection[_Worker], busy: Container[_Worker]) -> None:
    for worker in workers:
        worker.stop(is_busy=worker in busy)
    end_s = time.monotonic() + FAREWELL_S
    for worker in workers:
        worker.join(max(0.0, end_s - time.monotonic()))


def _answering(busy: Iterable[_Worker], timeout_s: float | None) -> list[_Worker]:
    """Wait for those that have an answer, or have died."""
    by_connection = {worker.connection: worker for worker in busy}
    return [by_connection[ready] for ready in wait(by_connection, timeout_s) if isinstance(ready, Connection)]
