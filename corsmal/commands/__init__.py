"""The commands of ``python -m corsmal``: their common arguments, and how they report."""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, Protocol

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

from corsmal.errors import ArgumentError, CorsmalError
from corsmal.notes import listening
from corsmal.parameters import (
    SELECTION_PRESETS,
    SHAPE_PRESETS,
    SelectionParameters,
    ShapeParameters,
    own_selection,
    read_pair,
)

if TYPE_CHECKING:
    import pandas as pd

    from corsmal.dataset import Dataset, Recording
    from corsmal.dataset.clock import Matching
    from corsmal.detection import Detector

console = Console(stderr=True)

RATE_WINDOW_S = 600.0
"""The rate is averaged over the last minutes: a recording may take one, and a stored result takes no time."""

LINES_EVERY_S = 30.0
"""A log gets a line about the progress this often."""

COMPLAINTS_MAX = 5
"""So many problems of a kind are printed; the disk that is full for one result is full for the others."""

Root = Annotated[Path, typer.Argument(metavar="ROOT", help="Folder of the dataset.")]
Ids = Annotated[list[str] | None, typer.Argument(metavar="ID", help="Recordings, such as 000618; default: all.")]
FeatureOptions = Annotated[
    list[Path] | None,
    typer.Option(
        "--features",
        help="Folder of feature arrays, ID.npy; default: log-mel features of the audio. Repeat it to name features of "
        "the video, rows of 512 numbers, too.",
    ),
]
RunFolder = Annotated[
    Path,
    typer.Argument(metavar="RUN", help="Folder for checkpoints, logs and weights; an interrupted run there resumes."),
]


DetectFirst = Annotated[
    str | None,
    typer.Option(
        "--detector",
        help="Detect first in recordings without detections: coco is Mask R-CNN, demo the demo's small network; other "
        "packages' detectors have names of their own.",
    ),
]
MatchViews = Annotated[
    Literal["time", "index"] | None,
    typer.Option("--match", help="Match the views' frames by their time stamps, or by number.", show_default="time"),
]
Offsets = Annotated[
    list[str] | None,
    typer.Option(
        "--offset",
        metavar="VIEW=SECONDS",
        help="How much later a view was filmed than its file says; for all recordings. Repeat it for several views.",
    ),
]
UsedMasks = Annotated[
    Literal["detected", "by-hand"] | None,
    typer.Option("--masks", help="Use masks by hand in the frames that have them.", show_default="detected"),
]
Without = Annotated[
    list[str] | None,
    typer.Option(
        "--without",
        metavar="FLAG",
        help="Leave out rows that raise this flag, or any; the README lists the flags. Repeat it for more.",
    ),
]
PRESET_HELP = f"Parameters of the fit: {', '.join(SHAPE_PRESETS)}."
SELECTION_HELP = f"Rules for the best frame: {', '.join(SELECTION_PRESETS)}; default: those of the preset of the fit."
PAIRS_HELP = "Pairs of views in the order in which they are tried, such as view3-view1,view3-view2."


class Report(Protocol):
    """Reports progress; ``progress_bar`` yields one."""

    def __call__(self, done: float, total: int, what: str = ..., /) -> None:
        """Show how much is done, and what is being done if that has changed."""


class _Rate(ProgressColumn):
    """The rate per minute."""

    def render(self, task: Task) -> Text:
        rate = 60 * (task.speed or 0)
        text = "" if not rate else f"{rate:.0f}/min" if rate >= 100 else f"{rate:.2g}/min"
        return Text(text, style="progress.data.speed")


class _Lines:
    """Says how far the work is, at most once in ``LINES_EVERY_S``, and when it is done."""

    def __init__(self, what: str) -> None:
        self._what, self._said_s, self._is_done = what, time.monotonic(), False

    def __call__(self, done: float, total: int, what: str = "", /) -> None:
        self._what = what or self._what
        was_done, self._is_done, now_s = self._is_done, done >= total, time.monotonic()
        if (self._is_done and not was_done) or now_s - self._said_s >= LINES_EVERY_S:
            self._said_s = now_s
            say(f"{self._what}: {done:g} of {total}")


@contextmanager
def progress_bar(what: str) -> Iterator[Report]:
    """A bar with the rate and the time left; where it cannot move, as in a log, a line now and then."""
    if not console.is_terminal:
        yield _Lines(what)
        return
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
    """Print an error on one line; brackets in file names are not taken for markup."""
    console.print(Text.assemble((f"{what}:", "red"), f" {error}"), soft_wrap=True)


def complain_of(problems: Sequence[tuple[str, str]], *, others_in: str) -> None:
    """Print some of the problems, and how many others there are.

    Args:
        problems: of what, and a sentence.
        others_in: where the others are.
    """
    for what, problem in problems[:COMPLAINTS_MAX]:
        complain(what, problem)
    if len(problems) > COMPLAINTS_MAX:
        complain(others_in, f"{len(problems) - COMPLAINTS_MAX} more such problems")


@contextmanager
def complaints_of_the_store() -> Iterator[None]:
    """Print at the end what the store could not read or write meanwhile, here or in other processes."""
    with listening() as said:
        try:
            yield
        finally:
            complain_of([("Cache", sentence) for sentence in dict.fromkeys(said)], others_in="Cache")


def say(sentence: str) -> None:
    """Print a message on one line of the standard error stream, apart from the results."""
    console.print(Text(sentence), soft_wrap=True)


def show(title: str, table: "pd.DataFrame") -> None:
    """Print a table with its title; rows that have no names are not numbered."""
    import pandas as pd

    has_names = not isinstance(table.index, pd.RangeIndex)
    typer.echo(f"{title}\n{table.round(1).to_string(index=has_names, na_rep='–')}\n")


def shape_preset(name: str, *, option: str = "--preset") -> ShapeParameters:
    """The parameters of the fit that an option names.

    Raises:
        typer.BadParameter: there is no such preset.
    """
    if name not in SHAPE_PRESETS:
        raise typer.BadParameter(f"available presets: {', '.join(SHAPE_PRESETS)}", param_hint=option)
    return SHAPE_PRESETS[name]


def view_matching(match: Literal["time", "index"] | None, offsets: list[str] | None) -> "Matching":
    """What the options ``--match`` and ``--offset`` say.

    Raises:
        typer.BadParameter: an offset is not like ``view1=0.4``.
        ArgumentError: see ``Matching``.
    """
    from corsmal.dataset.clock import Matching

    found = []
    for offset in offsets or ():
        view, _, seconds = offset.partition("=")
        try:
            found.append((view.strip(), float(seconds)))
        except ValueError:
            raise typer.BadParameter(f"{offset!r} is not like view1=0.4", param_hint="--offset") from None
    return Matching(match or "time", tuple(found))


def selection_preset(name: str | None, *, preset: str) -> SelectionParameters:
    """The rules for the best frame that ``--selection`` names, by default those of a preset of the fit.

    Raises:
        typer.BadParameter: there is no such preset.
    """
    name = name or own_selection(preset)
    if name not in SELECTION_PRESETS:
        raise typer.BadParameter(f"available presets: {', '.join(SELECTION_PRESETS)}", param_hint="--selection")
    return SELECTION_PRESETS[name]


def with_pairs(shape: ShapeParameters, pairs: str | None) -> ShapeParameters:
    """The parameters of the fit with the pairs that ``--pairs`` names, if any.

    Raises:
        typer.BadParameter: they are no pairs of the method's views.
    """
    if pairs is None:
        return shape
    try:
        return replace(shape, pairs=tuple(map(read_pair, pairs.split(","))))
    except ArgumentError as error:
        raise typer.BadParameter(str(error), param_hint="--pairs") from None


def chosen(dataset: "Dataset", ids: list[str] | None) -> "list[Recording]":
    """The named recordings, or all."""
    return [dataset[name] for name in ids] if ids else list(dataset)


def demo_detector(weights: Path | None = None) -> "Detector":
    """The demo's detector, with its own weights unless others are named."""
    from corsmal.detection import SmallDetector
    from corsmal.weights import find_weights

    return SmallDetector(find_weights("detector", weights).path)
