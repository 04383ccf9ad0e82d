"""A process that makes parts of recordings: tasks come as lines of JSON, answers go back as lines of JSON.

Processes are started as ``python -m corsmal.synthetic.writing.worker`` and not by ``multiprocessing``, whose children
would run the main module of the program that asks (an app's script, say) once more. They share what they compile, and
begin with different kernels.
"""

import importlib.metadata
import json
import os
import queue
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from corsmal.digests import digest
from corsmal.errors import CorsmalError, FileError
from corsmal.synthetic.writing.parts import CACHE_VARIABLE, KERNELS

if TYPE_CHECKING:
    from corsmal.synthetic.writing.plan import PlannedRecording  # loads Numba, which only a process that draws needs

GIVING_WAY = 15
"""Niceness of what nobody waits for: without it a detector on the same cores is ten times slower."""

_POLL_S = 0.1
_PACKAGE_PARENT = Path(__file__).resolve().parents[3]


@dataclass(frozen=True)
class Task:
    """Parts of one recording that are to be made.

    Args:
        planned: the recording.
        parts: which of its parts.
        folder: where they are written.
        size: (width, height) of the videos in pixels.
        is_awaited: whether somebody waits for it; the process gives way to others for what nobody waits for.
    """

    planned: "PlannedRecording"
    parts: Sequence[str]
    folder: str
    size: tuple[int, int]
    is_awaited: bool = False

    def run(self) -> None:
        """Make the parts."""
        from corsmal.synthetic.writing.files import write_part  # noqa: PLC0415 - loads the renderer, which only a worker needs

        scene = self.planned.scene()
        for part in self.parts:
            write_part(Path(self.folder), self.planned.recording_id, scene, part, size=self.size)


class Worker:
    """A process that runs tasks one after the other; stopped by ``close``.

    Args:
        number: of the process: those with different numbers begin by compiling different kernels.
        folder: where processes keep what they compiled for each other.
    """

    def __init__(self, number: int, folder: Path) -> None:
        path = os.pathsep.join(filter(None, [str(_PACKAGE_PARENT), os.environ.get("PYTHONPATH")]))
        kept = os.environ.get(CACHE_VARIABLE) or str(folder / f"kernels-{_sources_digest()}")
        self._process = subprocess.Popen(
            [sys.executable, "-m", "corsmal.synthetic.writing.worker", KERNELS[number % len(KERNELS)]],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=os.environ | {"PYTHONPATH": path, CACHE_VARIABLE: kept},
            text=True,
        )

    def run(self, task: Task) -> None:
        """Have a task done.

        Raises:
            CorsmalError: what the task raised, or the process ended before it was done.
        """
        answer = ""
        if self._process.stdin is not None and self._process.stdout is not None:
            try:
                self._process.stdin.write(json.dumps(asdict(task)) + "\n")
                self._process.stdin.flush()
                answer = self._process.stdout.readline()
            except (OSError, ValueError):
                answer = ""
        if not answer:
            raise CorsmalError("the process that makes the demo ended early; start the demo again to go on")
        problem = json.loads(answer)
        if problem.get("path"):
            raise FileError(problem["path"], problem["problem"])
        if problem:
            raise CorsmalError(problem["problem"])

    def close(self) -> None:
        """Stop the process; an unfinished task leaves no file behind that would be taken for a whole one."""
        self._process.terminate()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None and not pipe.closed:
                try:
                    pipe.close()
                except OSError:
                    continue
        self._process.wait()


_started_ahead: deque[Worker] = deque()


def usual_processes() -> int:
    """How many processes make a demo: one per core, at most four."""
    return min(4, os.cpu_count() or 1)


def start_ahead(folder: Path) -> None:
    """Start the processes of the next ``run_tasks``: they compile while the caller loads what it needs itself.

    Args:
        folder: where they keep what they compiled.
    """
    _started_ahead.extend(Worker(number, folder) for number in range(usual_processes()))


def run_tasks(
    tasks: Sequence[Task], *, processes: int, note: Callable[[Task], None], cancelled: Callable[[], bool]
) -> None:
    """Do tasks, in their order as far as several processes can.

    Args:
        tasks: what is to be done.
        processes: how many; 0 does everything in this process.
        note: called in this thread after each task.
        cancelled: asked often; when it says true, nothing more is begun and what is unfinished is dropped.

    Raises:
        CorsmalError: a task failed, or a process could not be started.
    """
    if processes == 0:
        for task in tasks:
            if cancelled():
                return
            task.run()
            note(task)
    elif tasks:
        _run_in_processes(tasks, min(processes, len(tasks)), note, cancelled)


def _run_in_processes(
    tasks: Sequence[Task], processes: int, note: Callable[[Task], None], cancelled: Callable[[], bool]
) -> None:
    """Each process is led by a thread that waits for its answers."""
    waiting: queue.SimpleQueue[Task] = queue.SimpleQueue()
    answers: queue.SimpleQueue[Task | CorsmalError] = queue.SimpleQueue()
    for task in tasks:
        waiting.put(task)
    workers: list[Worker] = []
    try:
        for number in range(processes):
            workers.append(_worker(number, Path(tasks[0].folder)))
            threading.Thread(target=_lead, args=(workers[-1], waiting, answers), daemon=True).start()
        for _ in tasks:
            answer = _next(answers, cancelled)
            if answer is None:
                return
            if isinstance(answer, CorsmalError):
                raise answer
            note(answer)
    except OSError as error:
        raise CorsmalError(f"no process could be started to make the demo ({error}); free some memory") from error
    finally:
        for worker in workers:
            worker.close()


def _worker(number: int, folder: Path) -> Worker:
    """One that was started ahead, as long as there are any."""
    try:
        return _started_ahead.popleft()
    except IndexError:
        return Worker(number, folder)


def _lead(
    worker: Worker, waiting: "queue.SimpleQueue[Task]", answers: "queue.SimpleQueue[Task | CorsmalError]"
) -> None:
    """Give a worker one task after the other; stop at the first that fails, as all do once it is closed."""
    while True:
        try:
            task = waiting.get_nowait()
            worker.run(task)
        except queue.Empty:
            return
        except CorsmalError as error:
            answers.put(error)
            return
        answers.put(task)


def _next(
    answers: "queue.SimpleQueue[Task | CorsmalError]", cancelled: Callable[[], bool]
) -> Task | CorsmalError | None:
    """The next answer, or None when the call is cancelled."""
    while not cancelled():
        try:
            return answers.get(timeout=_POLL_S)
        except queue.Empty:
            continue
    return None


def _sources_digest() -> str:
    """Of all that compiled kernels depend on; Numba itself looks at one file at a time."""
    sources = sorted(Path(__file__).parents[1].rglob("*.py"))
    return digest(
        "kernels", importlib.metadata.version("numba"), [path.read_text(encoding="utf-8") for path in sources]
    )


def main() -> None:
    """Compile, then run the tasks that come in until there are no more."""
    # an interrupt from the keyboard reaches the whole group: the process that asked decides
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    from corsmal.synthetic.render.frame import compile_kernels  # noqa: PLC0415
    from corsmal.synthetic.writing.plan import PlannedRecording  # noqa: PLC0415 - as above

    compile_kernels(*sys.argv[1:])
    gives_way = False
    for line in sys.stdin:
        content = json.loads(line)
        if not content["is_awaited"] and not gives_way and hasattr(os, "nice"):
            os.nice(GIVING_WAY)
            gives_way = True
        planned = PlannedRecording(**content["planned"] | {"filling": tuple(content["planned"]["filling"])})
        answer = {}
        try:
            Task(planned, content["parts"], content["folder"], tuple(content["size"])).run()
        except FileError as error:
            answer = {"path": str(error.path), "problem": error.problem}
        except CorsmalError as error:
            answer = {"problem": str(error)}
        sys.stdout.write(json.dumps(answer) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
