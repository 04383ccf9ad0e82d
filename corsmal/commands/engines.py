"""Where a command does its work: the options --engine, --workers and --scheduler, and the run itself."""

from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from corsmal.commands import Report, progress_bar, say

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

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

INTERRUPTED = 130
"""Exit status after Ctrl-C, as shells use it."""


def choose_engine(
    name: str,
    *,
    workers: int | None,
    scheduler: str | None,
    recordings: int,
    detects: bool = False,
) -> "Engine":
    """The engine for the options ``--engine``, ``--workers`` and ``--scheduler``.

    There are no more processes than recordings, and only one that runs a detector on a GPU.

    Raises:
        typer.BadParameter: the options exclude each other.
    """
    from corsmal.engines import local
    from corsmal.engines.dask_cluster import DaskCluster

    if scheduler is not None and name != "dask":
        raise typer.BadParameter("needs --engine dask", param_hint="--scheduler")
    if scheduler is not None and workers is not None:
        raise typer.BadParameter("a running cluster determines its own number of workers", param_hint="--workers")
    if name == "dask":
        return DaskCluster(scheduler, workers=min(workers or local.default_workers(), max(1, recordings)))
    if detects and (workers or 1) > 1 and local.has_gpu():
        raise typer.BadParameter("only one process can use the GPU of this machine", param_hint="--workers")
    return local.local_engine(recordings, workers=workers, detects=detects, forks=True)


@contextmanager
def resumable_progress(total: int) -> "Iterator[Report]":
    """A progress bar of recordings; Ctrl-C ends the program and says that finished work is kept.

    Raises:
        typer.Exit: Ctrl-C was pressed.
    """
    finished = 0.0
    with progress_bar("recordings") as progress:

        def report(done: float, wanted: int, what: str = "recordings", /) -> None:
            nonlocal finished
            finished = done
            progress(done, wanted, what)

        try:
            yield report
        except KeyboardInterrupt:
            say(f"Stopped after {int(finished)} of {total}. Finished work is kept; the same command resumes it.")
            raise typer.Exit(INTERRUPTED) from None


def run(task: "Task", recordings: "Sequence[Recording]", engine: "Engine") -> "list[Row]":
    """Run a task on recordings with a progress bar.

    Raises:
        typer.Exit: Ctrl-C was pressed.
    """
    from corsmal.engines.engine import in_turn, run_batch
    from corsmal.engines.tasks import DetectTask

    finished = 0
    with resumable_progress(len(recordings)) as progress:

        def report(done: int, total: int) -> None:
            nonlocal finished
            finished = done
            progress(done, total)

        def report_frames(name: str, done: int, total: int) -> None:
            progress(finished + done / max(1, total), len(recordings), f"recordings ({name}: {done} of {total} frames)")

        if engine is in_turn and isinstance(task, DetectTask):
            task = replace(task, frames=report_frames)
        return run_batch(task, recordings, engine=engine, progress=report)
