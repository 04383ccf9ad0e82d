"""Pieces of recordings that processes make, and the processes."""

import importlib.metadata
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from corsmal.digests import digest
from corsmal.engines.engine import Row
from corsmal.engines.processes import Processes, cores
from corsmal.errors import FileError
from corsmal.synthetic.writing.parts import ADVICE, STAGING, move, part_files
from corsmal.synthetic.writing.plan import PlannedRecording

Kernels = Literal["vessels", "limbs"]
KERNELS: tuple[Kernels, ...] = ("vessels", "limbs")
"""What takes seconds to compile, the slowest first."""

PROCESSES_MAX = 4


@dataclass(frozen=True)
class Piece:
    """A part of one recording."""

    planned: PlannedRecording
    part: str


@dataclass(frozen=True)
class WritePiece:
    """The task of making a piece.

    Args:
        folder: where its files are put when all of them are whole.
        begun: the call's own folder of the same disk, in which they are made; what is left in it is of no use.
        size: as in ``write_part``, like the others.
    """

    folder: Path
    begun: Path
    size: tuple[int, int]
    frame_step: int
    compact: bool = False

    def __call__(self, piece: Piece) -> Row:
        """Make the piece.

        Raises:
            FileError: a file cannot be written.
        """
        from corsmal.synthetic.writing.recording import write_part  # noqa: PLC0415 - loads the renderer

        name, part = piece.planned.recording_id, piece.part
        size, step = self.size, self.frame_step
        try:
            write_part(self.begun, name, piece.planned.scene(), part, size=size, frame_step=step, compact=self.compact)
        except OSError as error:  # such as that of the compiler, which keeps what it has compiled
            raise FileError(self.folder, f"cannot be written ({error.strerror}); {ADVICE}") from error
        for file in part_files(name, part, compact=self.compact):
            move(file, self.begun, self.folder)
        return {}


def start_processes(root: Path, *, count: int | None = None) -> Processes:
    """Start the processes of ``write_demo``: they compile, and share what they compiled.

    By default there is one per core, at most four.

    Raises:
        CorsmalError: a process could not be started.
    """
    # Numba looks only at a kernel's own file to tell whether it is out of date
    sources = [path.read_text(encoding="utf-8") for path in sorted(Path(__file__).parents[1].rglob("*.py"))]
    kernels = root / STAGING / f"kernels-{digest('kernels', importlib.metadata.version('numba'), sources)}"
    environment = {"NUMBA_CACHE_DIR": os.environ.get("NUMBA_CACHE_DIR") or str(kernels)}
    processes = Processes(count or min(PROCESSES_MAX, cores()), environment, gives_way=True)
    processes.start(_compile, KERNELS)
    return processes


def _compile(first: Kernels) -> Row:
    """Compile what draws, as far as no other process does."""
    from corsmal.synthetic.render.frame import compile_kernels  # noqa: PLC0415 - loads Numba

    compile_kernels(first)
    return {}
