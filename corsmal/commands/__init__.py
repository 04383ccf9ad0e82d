"""The commands of ``python -m corsmal``, and what they share."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Protocol

import typer
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from corsmal.errors import CorsmalError

if TYPE_CHECKING:
    from corsmal.dataset import Dataset, Recording
    from corsmal.detection import Detector

console = Console(stderr=True)

RATE_WINDOW_S = 600.0
"""The rate is that of the last minutes: a recording may take one of them, and those done before take none."""

Root = Annotated[Path, typer.Argument(help="Dataset folder.")]
Ids = Annotated[list[str] | None, typer.Argument(help="Recordings; all if none is named.")]
Weights = Annotated[Path | None, typer.Option(help="Weights of Mask R-CNN; default: COCO's, downloaded once.")]
FeatureFolder = Annotated[
    Path | None, typer.Option("--features", help="Folder of ID.npy arrays to listen to; default: log-mel of the sound.")
]
RunFolder = Annotated[Path, typer.Argument(help="Gets checkpoints, logs and weights; an earlier run there goes on.")]


class Report(Protocol):
    """What ``progress_bar`` yields."""

    def __call__(self, done: float, total: int, what: str = ..., /) -> None:
        """Say how far the work is, and what it is at if that has changed."""


class _Rate(ProgressColumn):
    """How many of them a minute."""

    def render(self, task: Task) -> Text:
        return Text("" if not task.speed else f"{60 * task.speed:.3g}/min", style="progress.data.speed")


@contextmanager
def progress_bar(what: str) -> Iterator[Report]:
    """A bar with the rate and the time left."""
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        _Rate(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, speed_estimate_period=RATE_WINDOW_S) as progress:
        task = progress.add_task(what, total=None)
        yield lambda done, total, what=what, /: progress.update(task, completed=done, total=total, description=what)


def complain(what: str, error: CorsmalError | str) -> None:
    """Print an error's sentence on one line; brackets in the names of files are no markup."""
    console.print(Text.assemble((f"{what}:", "red"), f" {error}"), soft_wrap=True)


def say(sentence: str) -> None:
    """Print a sentence on one line, beside the results."""
    console.print(Text(sentence), soft_wrap=True)


def chosen(dataset: "Dataset", ids: list[str] | None) -> "list[Recording]":
    """The recordings that are named, or all."""
    return [dataset[name] for name in ids] if ids else list(dataset)


def demo_detector(weights: Path | None = None) -> "Detector":
    """The demo's detector, with its own weights unless others are named."""
    from corsmal.detection import SmallDetector  # noqa: PLC0415 - commands load what they need
    from corsmal.weights import find_weights  # noqa: PLC0415

    return SmallDetector(find_weights("detector", weights).path)
