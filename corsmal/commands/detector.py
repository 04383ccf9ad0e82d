"""``detect``, ``train detector`` and ``evaluate detector``: containers in the frames of videos."""

from pathlib import Path
from typing import Annotated

import typer

from corsmal.commands import (
    Ids,
    MatchViews,
    Offsets,
    Root,
    RunFolder,
    chosen,
    complain,
    demo_detector,
    progress_bar,
    say,
    view_matching,
)
from corsmal.commands.engines import EngineName, Scheduler, Workers, choose_engine, run


def detect(
    root: Root,
    ids: Ids = None,
    *,
    weights: Annotated[
        Path | None, typer.Option(help="Weights of the network; default: COCO's, downloaded on first use (170 MB).")
    ] = None,
    demo_weights: Annotated[
        bool, typer.Option("--demo-weights", help="Use the demo's small network instead of Mask R-CNN.")
    ] = False,
    method: Annotated[
        str,
        typer.Option("--detector", help="coco: Mask R-CNN; demo: as --demo-weights; or a name of another package's."),
    ] = "coco",
    every: Annotated[
        int, typer.Option(help="Inspect every N-th frame, then those close to the best one; 1: all frames.", min=1)
    ] = 1,
    match: MatchViews = None,
    offset: Offsets = None,
    engine: EngineName = "local",
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Detect containers in the videos of recordings.

    Results are stored: an interrupted run resumes, and frames that were inspected are not inspected again.
    """
    from corsmal.dataset import open_dataset
    from corsmal.engines.tasks import DetectTask
    from corsmal.stages.settings import find_detector
    from corsmal.store import Store

    recordings, store = chosen(open_dataset(root).matched(view_matching(match, offset)), ids), Store()
    store.check_writable()
    chosen_engine = choose_engine(
        engine, workers=workers, scheduler=scheduler, recordings=len(recordings), detects=True
    )
    detector = find_detector("demo" if demo_weights else method, weights=weights, every=every)
    # opened before the work begins: weights that cannot be used are one sentence, not one for every recording
    task = DetectTask(store.root.resolve(), detector, detector.open(device="cpu").digest)
    failed = [row for row in run(task, recordings, chosen_engine) if row["status"] == "failed"]
    for row in failed:
        complain(row["recording_id"], row["notes"])
    if failed:
        say(f"{len(failed)} of {len(recordings)} recordings failed.")
        raise typer.Exit(1)


def train(
    folder: RunFolder,
    *,
    steps: Annotated[int, typer.Option(help="Optimiser steps; about one second each on two cores.", min=1)] = 4000,
    batch: Annotated[int, typer.Option(help="Frames per step.", min=1)] = 8,
    rate: Annotated[float, typer.Option(help="Highest learning rate.", min=0)] = 1.5e-3,
    whole: Annotated[
        float, typer.Option(help="Share of the steps on whole frames; the others see crops.", min=0, max=1)
    ] = 0.25,
    seed: Annotated[int, typer.Option(help="Random seed for the scenes.", min=0)] = 0,
    init: Annotated[Path | None, typer.Option(help="Weights to start from; default: random ones.")] = None,
) -> None:
    """Train the demo's detector on rendered frames."""
    from corsmal.synthetic import DetectorTraining, train_detector

    warm_up = min(200, max(1, steps // 20))
    training = DetectorTraining(steps=steps, batch=batch, rate=rate, whole=whole, seed=seed, warm_up=warm_up)
    say(f"Weights: {train_detector(folder, training, init=init)}")


def evaluate(
    weights: Annotated[Path | None, typer.Argument(metavar="WEIGHTS", help="Default: the bundled weights.")] = None,
    *,
    frames: Annotated[int, typer.Option(help="Number of rendered frames.", min=1)] = 200,
) -> None:
    """Evaluate the demo's detector on rendered frames that are in neither the demo nor the training."""
    from corsmal.synthetic import detector_report, detector_table

    with progress_bar("frames") as progress:
        report = detector_report(demo_detector(weights), frames=frames, progress=progress)
    typer.echo(detector_table(report).round(3).to_string())
    worst = report[report["visible"]].fillna({"iou": 0.0}).sort_values("iou").head(10)
    typer.echo(f"\nThe worst frames:\n{worst.to_string(index=False)}")
