"""Many recordings in several processes of this machine."""

import multiprocessing
import os
import signal
from collections import Counter, deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import NoReturn

from corsmal.dataset import Recording
from corsmal.engines.engine import Outcome, Task, attempt
from corsmal.errors import ArgumentError

ATTEMPTS_MAX = 2
"""A process may be killed for no fault of its recording, which is then begun once more."""

FAREWELL_S = 5.0
"""How long a process that is stopped may take to leave no unfinished file behind."""


@dataclass(frozen=True)
class Processes:
    """The engine of several processes.

    Each has one recording at a time, so that memory does not grow with the number of recordings. One that dies (of too
    little memory, say) is replaced.

    Args:
        count: how many processes.

    Raises:
        ArgumentError: fewer than one.
    """

    count: int

    def __post_init__(self) -> None:
        if self.count < 1:
            raise ArgumentError(f"count must be at least 1, got {self.count}")

    def __call__(self, task: Task, recordings: Sequence[Recording]) -> Iterator[Outcome]:
        """Yield an outcome for each recording as soon as there is one."""
        count = min(self.count, len(recordings))
        threads = max(1, (os.cpu_count() or 1) // max(1, count))
        waiting = deque(range(len(recordings)))
        deaths: Counter[int] = Counter()
        workers: list[_Worker] = []
        doing: dict[_Worker, int] = {}
        try:
            workers += [_Worker(threads) for _ in range(count)]
            while waiting or doing:
                for worker in workers:
                    if waiting and worker not in doing:
                        doing[worker] = waiting.popleft()
                        worker.give(task, doing[worker], recordings[doing[worker]])
                for worker in _answering(doing):
                    index, outcome = doing.pop(worker), worker.answer()
                    if outcome is None:
                        workers[workers.index(worker)] = _Worker(threads)
                        deaths[index] += 1
                        if deaths[index] < ATTEMPTS_MAX:
                            waiting.append(index)
                            continue
                        outcome = Outcome(index, problem=f"its process ended {ATTEMPTS_MAX} times, {worker.end()}")
                    yield outcome
        finally:
            for worker in workers:
                worker.stop(is_busy=worker in doing)
            for worker in workers:
                worker.join()


class _Worker:
    """One process, which does one task after the other."""

    def __init__(self, threads: int) -> None:
        # spawned, not forked: PyTorch's threads and CUDA do not survive a fork
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, threads), daemon=True)
        self._process.start()
        theirs.close()

    def give(self, task: Task, index: int, recording: Recording) -> None:
        with suppress(OSError):  # a process that has died is found out by the answer that it does not give
            self.connection.send((task, index, recording))

    def answer(self) -> Outcome | None:
        """What became of the recording; None where the process died over it."""
        try:
            outcome: Outcome = self.connection.recv()
        except (EOFError, OSError):
            self.join()
            return None
        return outcome

    def end(self) -> str:
        """How the process ended, for people."""
        code = self._process.exitcode or 0
        killed = " (too little memory?)" if code == -signal.SIGKILL else ""
        return f"by signal {-code}{killed}" if code < 0 else f"with exit status {code}"

    def stop(self, *, is_busy: bool) -> None:
        self.connection.close()  # which an idle process takes for the end
        if is_busy:
            self._process.terminate()

    def join(self) -> None:
        self._process.join(FAREWELL_S)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def _answering(busy: Iterable[_Worker]) -> list[_Worker]:
    """Wait for those that have an answer, or have died."""
    by_connection = {worker.connection: worker for worker in busy}
    return [by_connection[connection] for connection in wait(by_connection) if isinstance(connection, Connection)]


def _serve(connection: Connection, threads: int) -> None:
    """What a process does: tasks until the one that asks hangs up, be it because it was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the keyboard reaches the whole group: the one that asks decides
    signal.signal(signal.SIGTERM, _leave)
    os.environ.setdefault("OMP_NUM_THREADS", str(threads))  # PyTorch, loaded by the task, takes all cores otherwise
    with suppress(EOFError, OSError):
        while True:
            connection.send(attempt(*connection.recv()))


def _leave(*_signal: object) -> NoReturn:
    raise SystemExit
