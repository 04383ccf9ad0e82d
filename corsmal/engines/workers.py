"""Who does the work of an engine: a process, or a thread of this one."""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from multiprocessing import Pipe
from pathlib import Path
from typing import Any

from corsmal.engines.engine import Item, Outcome, Row, attempt
from corsmal.errors import CorsmalError

FAREWELL_S = 3.0
"""How long processes that are stopped may take to remove unfinished files."""

GIVING_WAY = 15
"""Niceness of work that is not awaited: without it a detector on the same cores is ten times slower."""

THREADS = ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "OPENCV_FOR_THREADS_NUM")
"""The variables that limit threads: of PyTorch, NumPy and Arrow; of Numba; of OpenCV."""

_PACKAGE_PARENT = str(Path(__file__).resolve().parents[2])


class Worker:
    """One process, which does one task after the other.

    Args:
        environment: its variables.

    Raises:
        CorsmalError: it could not be started.
    """

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
        """Have a task done for an item; ``answer`` has what became of it."""
        with suppress(OSError):  # a process that has died is found out by the answer that it does not give
            self.connection.send((attempt, task, index, item))

    def give_way(self) -> None:
        """Let other programs go first."""
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
        """Have it end: at once, if it is busy."""
        self.connection.close()  # which an idle process takes for the end
        if is_busy:
            self._process.terminate()

    def join(self, timeout_s: float) -> None:
        """Wait until it has ended; after that time it is killed."""
        try:
            self._process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stdin is not None:
            self._process.stdin.close()


class Here:
    """A thread of this process, which does one task after the other: one process less imports libraries and networks.

    It cannot be ended while it works: for tasks of a second or so. Whatever ends its process ends the others, too.

    Args:
        threads: of PyTorch, Numba and OpenCV while it works, where the environment does not say another number.
    """

    def __init__(self, threads: int) -> None:
        self.connection, self._theirs = Pipe()
        self._threads = threads
        self._thread = threading.Thread(target=self._serve, name="corsmal-here", daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        with suppress(EOFError, OSError), self._theirs:
            while True:
                function, *arguments = self._theirs.recv()
                with _limited(self._threads):
                    self._theirs.send(function(*arguments))

    def give(self, task: Callable[[Item], Row], index: int, item: Item) -> None:
        """Have a task done for an item; ``answer`` has what became of it."""
        self.connection.send((attempt, task, index, item))

    def give_way(self) -> None:
        """Nothing: this process was not started for the work."""

    def answer(self) -> Outcome | None:
        """What became of the item."""
        outcome: Outcome = self.connection.recv()
        return outcome

    def end(self) -> str:
        """How it ended, for people: it does not by itself."""
        return "in this process"

    def stop(self, *, is_busy: bool) -> None:
        """Have it end after its task."""
        del is_busy
        self.connection.close()

    def join(self, timeout_s: float) -> None:
        """Wait until it has ended."""
        self._thread.join(timeout_s)


@contextmanager
def _limited(threads: int) -> Iterator[None]:
    """Let the libraries use so many threads in this one, as workers of an engine do."""
    import cv2  # noqa: PLC0415 - the libraries of every estimate
    import numba  # noqa: PLC0415
    import torch  # noqa: PLC0415

    # PyTorch first and last: Numba, when it starts its threads, sets the number of OpenMP's in this one, PyTorch's, too
    before = torch.get_num_threads(), numba.get_num_threads(), cv2.getNumThreads()

    def limit(numbers: Iterable[int]) -> None:
        of_torch, of_numba, of_cv2 = numbers
        numba.set_num_threads(of_numba)
        cv2.setNumThreads(of_cv2)
        torch.set_num_threads(of_torch)

    limit(number if name in os.environ else threads for name, number in zip(THREADS, before, strict=True))
    try:
        yield
    finally:
        limit(before)
