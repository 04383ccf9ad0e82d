"""The command line: ``python -m corsmal --help``."""

import sys
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
    from corsmal.detection import Detector

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False, help=__doc__)
train = typer.Typer(no_args_is_help=True, help="Train a network.")
app.add_typer(train, name="train")
evaluate = typer.Typer(no_args_is_help=True, help="Measure how good a stage is.")
app.add_typer(evaluate, name="evaluate")
console = Console(stderr=True)

Root = Annotated[Path, typer.Argument(help="Dataset folder.")]
Ids = Annotated[list[str] | None, typer.Argument(help="Recordings; all if none is named.")]
Weights = Annotated[Path | None, typer.Option(help="Weights of Mask R-CNN; default: COCO's, downloaded once.")]


@app.command()
def demo(
    folder: Annotated[Path, typer.Argument(help="Where to write the synthetic dataset.")],
    recordings: Annotated[int, typer.Option(help="Recordings of each of the fifteen containers.", min=1)] = 2,
    seed: Annotated[int, typer.Option(help="Another seed, another demo.", min=0)] = 0,
) -> None:
    """Write a synthetic dataset in the dataset's own layout, with its truth beside it."""
    from corsmal.demo.writing import write_demo  # noqa: PLC0415 - commands load what they need

    with progress_bar("recordings") as progress:
        write_demo(
            folder,
            seed=seed,
            recordings_per_container=recordings,
            progress=lambda state: progress(state.done, state.total),
        )


@app.command()
def detect(
    root: Root,
    ids: Ids = None,
    weights: Weights = None,
    demo_weights: Annotated[bool, typer.Option("--demo-weights", help="Use the demo's own small network.")] = False,
    every: Annotated[int, typer.Option(help="Search coarsely first: every so many frames.", min=1)] = 1,
) -> None:
    """Find the containers in recordings' frames and keep the detections in the store."""
    from corsmal.batch import detect_recording  # noqa: PLC0415
    from corsmal.dataset import open_dataset  # noqa: PLC0415
    from corsmal.store import Store  # noqa: PLC0415

    dataset, store = open_dataset(root), Store()
    recordings = [dataset[name] for name in ids] if ids else list(dataset)
    detector = make_detector(weights, is_demo=demo_weights)
    failed = 0
    for recording in recordings:
        try:
            with progress_bar(f"{recording.id}, frames") as progress:
                detect_recording(recording, detector, store=store, every=every, progress=progress)
        except CorsmalError as error:
            failed += 1
            complain(recording.id, error)
    if failed:
        console.print(f"{failed} of {len(recordings)} recordings failed.")
        raise typer.Exit(1)


@app.command()
def budget(
    root: Root,
    scatter: Annotated[Path | None, typer.Option(help="HTML file for View Scores against errors.")] = None,
) -> None:
    """Show which stage of the geometry loses what, on a demo whose containers were detected."""
    from corsmal.batch import load_detections  # noqa: PLC0415
    from corsmal.dataset import open_dataset  # noqa: PLC0415
    from corsmal.demo.budget import budget_table, geometry_budget, score_against_error  # noqa: PLC0415
    from corsmal.figures.scores import score_error_figure  # noqa: PLC0415
    from corsmal.files import writing  # noqa: PLC0415
    from corsmal.store import Store  # noqa: PLC0415

    dataset, store = open_dataset(root), Store()
    with progress_bar("recordings") as progress:
        rows = geometry_budget(
            dataset, lambda recording: load_detections(recording, store=store).views, progress=progress
        )
    typer.echo("MAPE in %, preset paper")
    typer.echo(budget_table(rows).round(1).to_string())
    scores = score_against_error(dataset)
    correlation = scores["rank"].corr(scores["error_rank"])
    typer.echo(f"View Score against error of a frame, rank correlation within recordings: {correlation:+.2f}")
    if scatter is not None:
        with writing(scatter, advice="choose another file") as part:
            score_error_figure(scores).write_html(part, include_plotlyjs=True, config={"showSendToCloud": False})


@train.command("detector")
def train_detector_command(
    folder: Annotated[Path, typer.Argument(help="Gets checkpoints, logs and weights; an earlier run there goes on.")],
    *,
    steps: Annotated[int, typer.Option(help="Optimiser steps, a second or less each on two cores.", min=1)] = 4000,
    batch: Annotated[int, typer.Option(help="Frames per step.", min=1)] = 8,
    rate: Annotated[float, typer.Option(help="Highest learning rate.", min=0)] = 1.5e-3,
    whole: Annotated[float, typer.Option(help="Share of the steps on whole frames.", min=0, max=1)] = 0.25,
    seed: Annotated[int, typer.Option(help="Of the scenes.", min=0)] = 0,
    init: Annotated[Path | None, typer.Option(help="Weights to begin with; default: random ones.")] = None,
) -> None:
    """Train the demo's detector on rendered frames."""
    from corsmal.demo.training import train_detector  # noqa: PLC0415
    from corsmal.demo.training_frames import DetectorTraining  # noqa: PLC0415

    settings = DetectorTraining(
        steps=steps, batch=batch, rate=rate, whole=whole, seed=seed, warm_up=min(200, max(1, steps // 20))
    )
    path = train_detector(folder, settings, init=init)
    console.print(Text(f"Weights: {path}"), soft_wrap=True)


@evaluate.command("detector")
def evaluate_detector_command(
    weights: Annotated[Path | None, typer.Argument(help="Weights; default: those that came along.")] = None,
    *,
    frames: Annotated[int, typer.Option(help="How many frames of the demo.", min=1)] = 200,
) -> None:
    """Measure the demo's detector on frames of the demo that it has not seen."""
    from corsmal.demo.detector_report import detector_report, detector_table  # noqa: PLC0415

    with progress_bar("frames") as progress:
        report = detector_report(make_detector(weights, is_demo=True), frames=frames, progress=progress)
    typer.echo(detector_table(report).round(3).to_string())
    worst = report[report["asked"]].fillna({"iou": 0.0}).sort_values("iou").head(10)
    typer.echo(f"\nThe worst frames:\n{worst.to_string(index=False)}")


def make_detector(weights: Path | None, *, is_demo: bool) -> "Detector":
    """The detector that the options ask for."""
    from corsmal.demo import DETECTOR_WEIGHTS  # noqa: PLC0415
    from corsmal.detection import MaskRCNNDetector, SmallDetector  # noqa: PLC0415

    return SmallDetector(weights or DETECTOR_WEIGHTS) if is_demo else MaskRCNNDetector(weights)


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


def main() -> None:
    """Run the command line; an error of the library is its sentence, not a traceback."""
    try:
        app()
    except CorsmalError as error:
        complain("Error", error)
        sys.exit(1)


if __name__ == "__main__":
    main()
