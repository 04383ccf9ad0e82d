"""The commands of ``python -m corsmal``, and what they share."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.text import Text

from corsmal.errors import CorsmalError

if TYPE_CHECKING:
    from corsmal.dataset import Dataset, Recording
    from corsmal.detection import Detector

console = Console(stderr=True)

Root = Annotated[Path, typer.Argument(help="Dataset folder.")]
Ids = Annotated[list[str] | None, typer.Argument(help="Recordings; all if none is named.")]
Weights = Annotated[Path | None, typer.Option(help="Weights of Mask R-CNN; default: COCO's, downloaded once.")]
FeatureFolder = Annotated[
    Path | None, typer.Option("--features", help="Folder of ID.npy arrays to listen to; default: log-mel of the sound.")
]
RunFolder = Annotated[Path, typer.Argument(help="Gets checkpoints, logs and weights; an earlier run there goes on.")]


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[int, int], None]]:
    """A bar with the time left; yields what to call with the numbers done and wanted."""
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console) as progress:
        task = progress.add_task(what, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)


def complain(what: str, error: CorsmalError) -> None:
    """Print an error's sentence on one line; brackets in the names of files are no markup."""
    console.print(Text.assemble((f"{what}:", "red"), f" {error}"), soft_wrap=True)


def say(sentence: str) -> None:
    """Print a sentence on one line, beside the results."""
    console.print(Text(sentence), soft_wrap=True)


def chosen(dataset: "Dataset", ids: list[str] | None) -> "list[Recording]":
    """The recordings that are named, or all."""
    return [dataset[name] for name in ids] if ids else list(dataset)


def make_detector(weights: Path | None, *, is_demo: bool) -> "Detector":
    """The detector that the options ask for."""
    from corsmal.demo import DETECTOR_WEIGHTS  # noqa: PLC0415 - commands load what they need
    from corsmal.detection import MaskRCNNDetector, SmallDetector  # noqa: PLC0415

    return SmallDetector(weights or DETECTOR_WEIGHTS) if is_demo else MaskRCNNDetector(weights)
