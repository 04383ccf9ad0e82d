"""A process that does the work of an engine."""

import gc
import os
import signal
import subprocess
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from multiprocessing import Pipe, get_context, parent_process
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any
from weakref import WeakSet

from corsmal.engines.engine import Outcome, Row, attempt
from corsmal.engines.lifeline import end_with
from corsmal.engines.worker import serve
from corsmal.errors import CorsmalError

FAREWELL_S = 3.0
"""How long processes that are stopped may take to remove unfinished files."""

GIVING_WAY = 15
"""Niceness of work that is not awaited: without it a detector on the same cores is ten times slower."""

THREADS = ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "OPENCV_FOR_THREADS_NUM")
"""The variables that limit threads: of PyTorch, NumPy and Arrow; of Numba; of OpenCV."""

_LIMITS = {"torch": ("get_num_threads", "set_num_threads"), "cv2": ("getNumThreads", "setNumThreads")}
_PACKAGE_PARENT = str(Path(__file__).resolve().parents[2])

_parents_ends: WeakSet[Connection] = WeakSet()
"""Of the connections to all workers that are in use; a copy of this process has copies of them."""


def can_copy() -> bool:
    """Whether this process can be copied: on Linux, if no other thread of Python may hold a lock at that moment."""
    return sys.platform == "linux" and threading.active_count() == 1


class Worker:
    """One process, which does one task after the other.

    Args:
        environment: its variables.
        is_copy: whether it begins as a copy of this process, with all libraries and networks that are loaded. Only
            where ``can_copy`` says so, and for a worker of one thread.

    Raises:
        CorsmalError: it could not be started.
    """

    def __init__(self, environment: Mapping[str, str], *, is_copy: bool = False) -> None:
        self.connection, theirs = Pipe()
        _parents_ends.add(self.connection)
        try:
            self._process: _Copy | _Program = (_Copy if is_copy else _Program)(theirs, environment)
        except OSError as error:
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
        code = self._process.exit_status
        killed = " (too little memory?)" if code == -signal.SIGKILL else ""
        return f"by signal {-code}{killed}" if code < 0 else f"with exit status {code}"

    def stop(self, *, is_busy: bool) -> None:
        """Have it end: at once, if it is busy."""
        self.connection.close()  # which an idle process takes for the end
        if is_busy:
            self._process.terminate()

    def join(self, timeout_s: float) -> None:
        """Wait until it has ended; after that time it is killed."""
        self._process.join(timeout_s)


class _Program:
    """A process that is started by itself."""

    def __init__(self, connection: Connection, environment: Mapping[str, str]) -> None:
        path = os.pathsep.join(filter(None, [_PACKAGE_PARENT, environment.get("PYTHONPATH")]))
        # not by multiprocessing, whose children would run this program's main module, an app's script, say
        self._process = subprocess.Popen(
            [sys.executable, "-m", "corsmal.engines.worker", str(connection.fileno())],
            stdin=subprocess.PIPE,
            pass_fds=[connection.fileno()],
            env={**environment, "PYTHONPATH": path},
            process_group=0,  # the keyboard reaches only this process, which decides
        )
        self.pid, self.terminate = self._process.pid, self._process.terminate

    @property
    def exit_status(self) -> int:
        """A signal's number, negative, where one ended the process."""
        return int(self._process.returncode)

    def join(self, timeout_s: float) -> None:
        try:
            self._process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stdin is not None:
            self._process.stdin.close()


class _Copy:
    """A process that begins as a copy of this one."""

    def __init__(self, connection: Connection, environment: Mapping[str, str]) -> None:
        self._process = get_context("fork").Process(target=_serve_as_copy, args=(connection, environment), daemon=True)
        gc.collect()  # what has threads cannot be disposed of in the copy, which lacks them,
        gc.freeze()  # and what is not garbage yet stays; the next copy's garbage is found at once
        with _one_thread(), warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # Python 3.12: of other threads, which are idle
            self._process.start()
        self.pid, self.terminate = self._process.pid or 0, self._process.terminate

    @property
    def exit_status(self) -> int:
        """As of a program."""
        return self._process.exitcode or 0

    def join(self, timeout_s: float) -> None:
        self._process.join(timeout_s)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def _serve_as_copy(connection: Connection, environment: Mapping[str, str]) -> None:
    os.setpgid(0, 0)  # as for a program
    for end in _parents_ends:
        end.close()
    parent = parent_process()
    if parent is None:  # which cannot be: this process is its child
        return
    end_with(parent.sentinel)  # the other end is open in later copies, too, which end first
    os.environ.update(environment)
    serve(connection)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Have PyTorch and OpenCV, if loaded, end their other threads, for which a copy of them would wait."""
    before = {}
    for name, (count, limit) in _LIMITS.items():
        if name in sys.modules:
            set_number = getattr(sys.modules[name], limit)
            before[set_number] = getattr(sys.modules[name], count)()
            set_number(1)
    try:
        yield
    finally:
        for set_number, number in before.items():
            set_number(number)
