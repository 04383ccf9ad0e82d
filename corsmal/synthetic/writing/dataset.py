"""Writing a synthetic dataset: recordings appear whole, and a stopped call is finished by the next one."""

import json
import shutil
import uuid
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from corsmal.engines.engine import in_turn, never
from corsmal.errors import ArgumentError, CorsmalError, FileError, NotFoundError
from corsmal.synthetic.scene.cameras import DEMO_SIZE
from corsmal.synthetic.writing.pace import Pace
from corsmal.synthetic.writing.parts import ANNOTATION_FILE, PARTS, STAGING, move, part_files, writing
from corsmal.synthetic.writing.pieces import Piece, WritePiece, start_processes
from corsmal.synthetic.writing.plan import PlannedRecording, annotation_of, plan_recordings

FORMAT = 1
"""Raised when the same settings give other recordings than before."""

SETTINGS_FILE = Path("truth", "demo.json")


@dataclass(frozen=True)
class DemoProgress:
    """How far the making of a dataset has come.

    Args:
        done: recordings that are complete.
        total: recordings there will be.
        fraction: share of the work that is done, 0..1.
        left_s: how long the rest will take at the pace so far; None before there is a pace.
    """

    done: int
    total: int
    fraction: float
    left_s: float | None = None


def write_demo(
    root: str | Path,
    *,
    seed: int = 0,
    recordings_per_container: int = 2,
    containers: Sequence[int] | None = None,
    ids: Sequence[str] | None = None,
    training: bool = False,
    size: tuple[int, int] = DEMO_SIZE,
    frame_step: int = 1,
    compact: bool = False,
    progress: Callable[[DemoProgress], None] | None = None,
    cancelled: Callable[[], bool] = never,
    workers: int | None = None,
) -> tuple[str, ...]:
    """Make a synthetic dataset, or finish one.

    Recordings appear whole; the annotation lists those that are there. What a stopped call left is kept, and a call for
    a complete dataset returns at once. The processes give way to other programs.

    Args:
        root: its folder, made when it is not there.
        seed: the same seed gives the same recordings.
        recordings_per_container: at least 1.
        containers: numbers of the containers, 1 to 15; default: all, for training the nine of the real training set.
        ids: of those recordings that are wanted; default: all.
        training: make recordings to train networks on: looks, lights and cameras of a wider range, none the demo's.
        size: (width, height) of the videos in pixels, in the proportions 16 to 9.
        frame_step: keep every n-th frame of the videos, which then have fewer per second; the sound stays whole.
        compact: compress the videos well, and the sound without loss (FLAC), which takes time.
        progress: called in this thread after each piece of work.
        cancelled: called often; when it returns true, unfinished work is dropped and the call returns.
        workers: processes; None for one per core, at most four; 0 makes everything in this process.

    Returns:
        Ids of the recordings that are complete.

    Raises:
        ArgumentError: a number is out of its range.
        NotFoundError: there is no such container or recording.
        CorsmalError: a file cannot be written, the folder holds something else, or processes cannot be started.
    """
    root = Path(root)
    if (workers or 0) < 0 or frame_step < 1:
        raise ArgumentError(f"workers must be at least 0 and frame_step at least 1, got {workers} and {frame_step}")
    if min(size) < 16 or size[0] % 2 or size[1] % 2:
        raise ArgumentError(f"size must be two even numbers of at least 16 pixels, got {size}")
    plan = plan_recordings(
        seed=seed, recordings_per_container=recordings_per_container, containers=containers, training=training
    )
    settings = {
        "format": FORMAT,
        "seed": seed,
        "recordings_per_container": recordings_per_container,
        "containers": [planned.container_id for planned in plan[: len(plan) // recordings_per_container]],
        "size": list(size),
    }
    # a complete dataset of an earlier version, which knew nothing of these, stays what it is
    settings |= {"training": training} if training else {}
    settings |= {"frame_step": frame_step} if frame_step > 1 else {}
    settings |= {"compact": compact} if compact else {}
    wanted = _wanted(plan, ids)
    _claim(root, settings)
    making = _Making(root, wanted, frame_step, compact, progress or (lambda _progress: None))
    begun = root / STAGING / f"begun-{uuid.uuid4().hex}"
    task = WritePiece(root / STAGING, begun, size, frame_step, compact)
    try:
        if workers == 0 or not making.pieces:
            outcomes = in_turn(task, making.pieces, cancelled=cancelled)
        else:
            outcomes = start_processes(root, count=workers)(task, making.pieces, cancelled=cancelled)
        with closing(outcomes):
            for outcome in outcomes:
                if outcome.problem:
                    raise CorsmalError(outcome.problem)
                making.note(making.pieces[outcome.index])
    finally:
        shutil.rmtree(begun, ignore_errors=True)
    return making.complete


class _Making:
    """One call's work: the pieces that are left, and how far they are."""

    def __init__(
        self,
        root: Path,
        plan: Sequence[PlannedRecording],
        frame_step: int,
        compact: bool,
        progress: Callable[[DemoProgress], None],
    ) -> None:
        self._root, self._frame_step, self._compact, self._progress = root, frame_step, compact, progress
        self._staging, self._total = root / STAGING, len(plan)
        self._complete: dict[str, dict[str, float]] = {}
        self.pieces = [Piece(planned, part) for planned in plan for part in PARTS if self._is_absent(planned, part)]
        self._pace = Pace(len(plan), [piece.part for piece in self.pieces])
        self._finish(plan)

    @property
    def complete(self) -> tuple[str, ...]:
        """Ids of the complete recordings, in order."""
        return tuple(sorted(self._complete))

    def note(self, piece: Piece) -> None:
        """A piece was made."""
        self._pace.note(piece.part)
        self._finish([piece.planned])

    def _finish(self, candidates: Sequence[PlannedRecording]) -> None:
        """Put the recordings that are whole where they belong, and tell how far the work is."""
        finished = [planned for planned in candidates if not any(self._is_absent(planned, part) for part in PARTS)]
        for planned in finished:
            for file in (file for part in PARTS for file in self._files(planned, part)):
                move(file, self._staging, self._root)
            self._complete[planned.recording_id] = planned.annotation(frame_step=self._frame_step)
        if finished:
            with writing(self._root / ANNOTATION_FILE) as path:
                rows = [self._complete[name] for name in self.complete]
                path.write_text(json.dumps(annotation_of(rows)), encoding="utf-8")
        if len(self._complete) == self._total:
            shutil.rmtree(self._staging, ignore_errors=True)
        self._progress(DemoProgress(len(self._complete), self._total, self._pace.fraction, self._pace.left_s))

    def _files(self, planned: PlannedRecording, part: str) -> tuple[Path, ...]:
        return part_files(planned.recording_id, part, compact=self._compact)

    def _is_absent(self, planned: PlannedRecording, part: str) -> bool:
        """Whether a part is neither in place nor waiting to be put there."""
        folders = self._root, self._staging
        return not all(any((folder / file).is_file() for folder in folders) for file in self._files(planned, part))


def _wanted(plan: Sequence[PlannedRecording], ids: Sequence[str] | None) -> list[PlannedRecording]:
    absent = sorted(set(ids or ()) - {planned.recording_id for planned in plan})
    if absent:
        raise NotFoundError(
            f"the demo has no recording {absent[0]!r}: it has {len(plan)}, 000000 to {plan[-1].recording_id}"
        )
    return [planned for planned in plan if ids is None or planned.recording_id in ids]


def _claim(root: Path, settings: dict[str, object]) -> None:
    """Note the settings in a new folder, or make sure that the folder holds this dataset and nothing else."""
    path = root / SETTINGS_FILE
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError):
        found = None
    except (OSError, ValueError) as error:
        raise FileError(path, "cannot be read; delete the demo's folder and start again") from error
    if found is None and any((root / name).exists() for name in ("view1", "view2", "view3", "audio")):
        raise FileError(root, "holds recordings that are not the demo's; choose another folder for the demo")
    if found is None:
        with writing(path) as part:
            part.write_text(json.dumps(settings), encoding="utf-8")
    elif found != settings:
        raise FileError(root, "holds a demo made with other settings; delete it or choose another folder")
