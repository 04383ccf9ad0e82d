"""Where the work of a command is done: options, and the engine that they ask for."""

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from corsmal.commands import progress_bar, say

if TYPE_CHECKING:
    from collections.abc import Sequence

    from corsmal.dataset import Recording
    from corsmal.engines.engine import Engine, Row, Task

EngineName = Annotated[
    Literal["local", "dask"], typer.Option("--engine", help="local: this machine's processes; dask: a cluster.")
]
Workers = Annotated[
    int | None, typer.Option(help="Processes on this machine; default: as many as it has cores and memory for.", min=1)
]
Scheduler = Annotated[
    str | None, typer.Option(help="Address of a running Dask cluster, tcp://…; default: a cluster of this machine.")
]

PROCESS_BYTES = 2_000_000_000
"""What a process with a network may need at its peak."""

INTERRUPTED = 130
"""The exit status of a program that the keyboard stopped."""


def choose_engine(name: str, *, workers: int | None, scheduler: str | None, recordings: int, gpu: bool) -> "Engine":
    """The engine that the options ask for.

    Args:
        name: ``local`` or ``dask``.
        workers: processes on this machine; None: as many as there are cores and memory for.
        scheduler: of a running cluster.
        recordings: how many there are: more processes are of no use.
        gpu: whether this machine's GPU does the work, which one process alone may use.

    Raises:
        typer.BadParameter: options that exclude each other.
    """
    from corsmal.engines.dask_cluster import DaskCluster  # noqa: PLC0415 - commands load what they need
    from corsmal.engines.engine import in_turn  # noqa: PLC0415 - commands load what they need
    from corsmal.engines.processes import Processes  # noqa: PLC0415 - commands load what they need

    if scheduler is not None and name != "dask":
        raise typer.BadParameter("a scheduler belongs to --engine dask", param_hint="--scheduler")
    if scheduler is not None and workers is not None:
        raise typer.BadParameter("a running cluster has the workers that it has", param_hint="--workers")
    if gpu and (workers or 1) > 1:
        raise typer.BadParameter("one process alone uses the GPU of this machine", param_hint="--workers")
    count = min(1 if gpu else workers or _default_workers(), max(1, recordings))
    if name == "dask":
        return DaskCluster(scheduler, workers=count)
    return Processes(count) if count > 1 else in_turn


def run(task: "Task", recordings: "Sequence[Recording]", engine: "Engine") -> "list[Row]":
    """The batch's rows, under a bar; the keyboard ends the program and keeps what was done.

    Raises:
        typer.Exit: the keyboard stopped it.
    """
    from corsmal.engines.engine import in_turn, run_batch  # noqa: PLC0415 - commands load what they need
    from corsmal.engines.tasks import DetectTask  # noqa: PLC0415 - commands load what they need

    finished = 0

    def report(done: int, total: int) -> None:
        nonlocal finished
        finished = done
        progress(done, total)

    def report_frames(name: str, done: int, total: int) -> None:
        progress(finished + done / max(1, total), len(recordings), f"recordings ({name}: {done} of {total} frames)")

    if engine is in_turn and isinstance(task, DetectTask):
        task = replace(task, frames=report_frames)
    try:
        with progress_bar("recordings") as progress:
            return run_batch(task, recordings, engine=engine, progress=report)
    except KeyboardInterrupt:
        say(f"Stopped after {finished} of {len(recordings)}; what was done is kept, the same command goes on.")
        raise typer.Exit(INTERRUPTED) from None


def has_gpu() -> bool:
    """Whether PyTorch sees a GPU."""
    import torch  # noqa: PLC0415 - takes seconds

    return torch.cuda.is_available()


def _default_workers() -> int:
    return max(1, min(os.cpu_count() or 1, _available_bytes() // PROCESS_BYTES))


def _available_bytes() -> int:
    """Memory that is free, as Linux tells; elsewhere enough for a process per core."""
    try:
        fields = dict(line.split(":", 1) for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines())
        return int(fields["MemAvailable"].split()[0]) * 1024
    except (OSError, ValueError, KeyError):
        return PROCESS_BYTES * (os.cpu_count() or 1)
