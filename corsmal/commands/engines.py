"""Where a command does its work: the options --engine, --workers and --scheduler, and the run itself."""

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
    Literal["local", "dask"], typer.Option("--engine", help="local: processes on this machine; dask: a Dask cluster.")
]
Workers = Annotated[
    int | None,
    typer.Option(help="Processes on this machine; default: as its cores and memory allow.", min=1),
]
Scheduler = Annotated[
    str | None, typer.Option(help="Address of a running Dask scheduler, tcp://…; default: a cluster on this machine.")
]

PROCESS_BYTES = 2_000_000_000
"""Peak memory of a process with a network."""

INTERRUPTED = 130
"""Exit status after Ctrl-C, as shells use it."""


def choose_engine(name: str, *, workers: int | None, scheduler: str | None, recordings: int, gpu: bool) -> "Engine":
    """The engine for the given options.

    Args:
        name: ``local`` or ``dask``.
        workers: number of processes on this machine; None: as many as its cores and memory allow.
        scheduler: address of a running cluster.
        recordings: their number; more processes would idle.
        gpu: whether the work is done on the GPU of this machine, which only one process may use.

    Raises:
        typer.BadParameter: the options exclude each other.
    """
    from corsmal.engines.dask_cluster import DaskCluster
    from corsmal.engines.engine import in_turn
    from corsmal.engines.processes import Processes

    if scheduler is not None and name != "dask":
        raise typer.BadParameter("needs --engine dask", param_hint="--scheduler")
    if scheduler is not None and workers is not None:
        raise typer.BadParameter("a running cluster determines its own number of workers", param_hint="--workers")
    if gpu and (workers or 1) > 1:
        raise typer.BadParameter("only one process can use the GPU of this machine", param_hint="--workers")
    count = min(1 if gpu else workers or _default_workers(), max(1, recordings))
    if name == "dask":
        return DaskCluster(scheduler, workers=count)
    return Processes(count) if count > 1 else in_turn


def run(task: "Task", recordings: "Sequence[Recording]", engine: "Engine") -> "list[Row]":
    """Run a task on recordings with a progress bar; Ctrl-C ends the program and keeps finished work.

    Raises:
        typer.Exit: Ctrl-C was pressed.
    """
    from corsmal.engines.engine import in_turn, run_batch
    from corsmal.engines.tasks import DetectTask

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
        say(f"Stopped after {finished} of {len(recordings)}. Finished work is kept; the same command resumes it.")
        raise typer.Exit(INTERRUPTED) from None


def has_gpu() -> bool:
    """Whether PyTorch sees a GPU."""
    import torch

    return torch.cuda.is_available()


def _default_workers() -> int:
    return max(1, min(os.cpu_count() or 1, _available_bytes() // PROCESS_BYTES))


def _available_bytes() -> int:
    """Free memory as reported by Linux; elsewhere enough for one process per core."""
    try:
        fields = dict(line.split(":", 1) for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines())
        return int(fields["MemAvailable"].split()[0]) * 1024
    except (OSError, ValueError, KeyError):
        return PROCESS_BYTES * (os.cpu_count() or 1)
