"""Making the demo: a dataset of synthetic recordings on disk, finished by the next call where one was stopped."""

import json
import os
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from corsmal.errors import ArgumentError, FileError
from corsmal.synthetic.scene.containers import CONTAINER_IDS
from corsmal.synthetic.writing.parts import ANNOTATION_FILE, DEMO_SIZE, PARTS, STAGING, part_files, writing
from corsmal.synthetic.writing.plan import PlannedRecording, annotation_of, demo_plan
from corsmal.synthetic.writing.worker import Task, run_tasks, usual_processes

FORMAT = 1
"""Raised when the same settings give other recordings than before."""

SETTINGS_FILE = Path("truth", "demo.json")
_FIRST_SPLIT = (("view3",), ("sound",), ("view1",), ("view2",))
"""Who waits for the first recording waits for all of it: several processes share it."""


@dataclass(frozen=True)
class DemoProgress:
    """How far the making of a demo has come.

    Args:
        done: recordings that are complete.
        total: recordings there will be.
        fraction: share of the work that is done, 0..1.
    """

    done: int
    total: int
    fraction: float


def write_demo(
    root: str | Path,
    *,
    seed: int = 0,
    recordings_per_container: int = 2,
    containers: Sequence[int] = CONTAINER_IDS,
    size: tuple[int, int] = DEMO_SIZE,
    progress: Callable[[DemoProgress], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
    workers: int | None = None,
) -> tuple[str, ...]:
    """Make a demo dataset, or finish one.

    Recordings appear whole, the first one first; the annotation lists those that are there. What a stopped call left
    is kept, and a call for a complete demo returns at once.

    Args:
        root: its folder, made when it is not there.
        seed: the same seed gives the same recordings.
        recordings_per_container: at least 1.
        containers: numbers of the containers, 1 to 15.
        size: (width, height) of the videos in pixels, in the proportions 16 to 9.
        progress: called in this thread after each piece of work.
        cancelled: asked often; when it says true, the call stops and returns.
        workers: processes; None for one per core, at most four; 0 makes everything in this process.

    Returns:
        Ids of the recordings that are complete.

    Raises:
        ArgumentError: a number is out of its range.
        FileError: a file cannot be written, or the folder holds something else.
    """
    root = Path(root)
    if workers is not None and workers < 0:
        raise ArgumentError(f"workers must not be negative, got {workers}")
    if min(size) < 16 or size[0] % 2 or size[1] % 2:
        raise ArgumentError(f"size must be two even numbers of at least 16 pixels, got {size}")
    plan = demo_plan(seed=seed, recordings_per_container=recordings_per_container, containers=containers)
    settings = {
        "format": FORMAT,
        "seed": seed,
        "recordings_per_container": recordings_per_container,
        "containers": list(containers),
        "size": list(size),
    }
    _claim(root, settings)
    making = _Making(root, plan, size, progress or (lambda _progress: None))
    making.finish_recordings()
    count = usual_processes() if workers is None else workers
    run_tasks(making.tasks, processes=count, note=making.note, cancelled=cancelled or (lambda: False))
    return making.complete


class _Making:
    """One call's work: the tasks that are left, and how far they are.

    Args:
        root: the demo's folder.
        plan: its recordings.
        size: of the videos.
        progress: whom to tell.
    """

    def __init__(
        self,
        root: Path,
        plan: Sequence[PlannedRecording],
        size: tuple[int, int],
        progress: Callable[[DemoProgress], None],
    ) -> None:
        self._root, self._plan, self._progress = root, plan, progress
        self._staging = root / STAGING
        self._complete: dict[str, PlannedRecording] = {}
        self.tasks = [
            Task(planned, absent, str(self._staging), size, is_awaited=index == 0)
            for index, planned in enumerate(plan)
            for parts in (_FIRST_SPLIT if index == 0 else (PARTS,))
            if (absent := self._absent(planned, parts))
        ]
        self._parts_left = sum(len(task.parts) for task in self.tasks)

    @property
    def complete(self) -> tuple[str, ...]:
        """Ids of the complete recordings, in order."""
        return tuple(sorted(self._complete))

    def finish_recordings(self) -> None:
        """Put what is whole where it belongs, and tell how far the work is."""
        is_new = False
        for planned in self._plan:
            name = planned.recording_id
            if name not in self._complete and not self._absent(planned, PARTS):
                for part in PARTS:
                    self._publish(name, part)
                self._complete[name] = planned
                is_new = True
        if is_new:
            rows = [(name, self._complete[name].scene()) for name in self.complete]
            with writing(self._root / ANNOTATION_FILE) as path:
                path.write_text(json.dumps(annotation_of(rows)), encoding="utf-8")
        if len(self._complete) == len(self._plan):
            shutil.rmtree(self._staging, ignore_errors=True)
        fraction = 1 - self._parts_left / (len(PARTS) * len(self._plan))
        self._progress(DemoProgress(len(self._complete), len(self._plan), fraction))

    def note(self, task: Task) -> None:
        """A task was done."""
        self._parts_left -= len(task.parts)
        self.finish_recordings()

    def _absent(self, planned: PlannedRecording, parts: Sequence[str]) -> tuple[str, ...]:
        """The parts that are neither in place nor waiting to be put there."""
        name = planned.recording_id
        return tuple(
            part
            for part in parts
            if any(
                not (self._root / file).is_file() and not (self._staging / file).is_file()
                for file in part_files(name, part)
            )
        )

    def _publish(self, name: str, part: str) -> None:
        for file in part_files(name, part):
            staged, path = self._staging / file, self._root / file
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
                if staged.is_file():
                    os.replace(staged, path)
            except FileNotFoundError:
                # another process that makes the same demo was faster
                continue
            except OSError as error:
                raise FileError(path, f"cannot be written ({error.strerror}); choose another folder") from error


def _claim(root: Path, settings: dict[str, object]) -> None:
    """Note the settings in a new folder, or make sure that the folder holds this demo and nothing else."""
    path = root / SETTINGS_FILE
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError):
        found = None
    except (OSError, ValueError) as error:
        raise FileError(path, "cannot be read; delete the demo's folder and start again") from error
    if found is not None and found != settings:
        raise FileError(root, "holds a demo made with other settings; delete it or choose another folder")
    if found is not None:
        return
    if any((root / name).exists() for name in ("view1", "view2", "view3", "audio")):
        raise FileError(root, "holds recordings that are not the demo's; choose another folder for the demo")
    with writing(path) as part:
        part.write_text(json.dumps(settings), encoding="utf-8")
