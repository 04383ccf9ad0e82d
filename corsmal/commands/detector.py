"""Commands that learn from datasets: networks, and a wall."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from corsmal.commands import FeatureFolder, Root, RunFolder, progress_bar, say

app = typer.Typer(no_args_is_help=True, help="Train a network, or learn the containers' wall.")


@app.command("detector")
def detector(
    folder: RunFolder,
    *,
    steps: Annotated[int, typer.Option(help="Optimiser steps, a second or less each on two cores.", min=1)] = 4000,
    batch: Annotated[int, typer.Option(help="Frames per step.", min=1)] = 8,
    rate: Annotated[float, typer.Option(help="Highest learning rate.", min=0)] = 1.5e-3,
    whole: Annotated[float, typer.Option(help="Share of the steps on whole frames.", min=0, max=1)] = 0.25,
    seed: Annotated[int, typer.Option(help="Of the scenes.", min=0)] = 0,
    init: Annotated[Path | None, typer.Option(help="Weights to begin with; default: random ones.")] = None,
) -> None:
    """Train the demo's detector on rendered frames."""
    from corsmal.synthetic.training.detector import train_detector  # noqa: PLC0415 - commands load what they need
    from corsmal.synthetic.training.frames import DetectorTraining  # noqa: PLC0415

    settings = DetectorTraining(
        steps=steps, batch=batch, rate=rate, whole=whole, seed=seed, warm_up=min(200, max(1, steps // 20))
    )
    say(f"Weights: {train_detector(folder, settings, init=init)}")


@app.command("filling")
def filling(
    root: Root,
    folder: RunFolder,
    *,
    features: FeatureFolder = None,
    preset: Annotated[Literal["paper", "tuned"], typer.Option(help="What is trained, and how.")] = "tuned",
    seed: Annotated[int, typer.Option(help="Of weights, order and crops.", min=0)] = 0,
) -> None:
    """Train the network for filling type and level on a dataset's sound, or on arrays."""
    from corsmal.commands.filling import dataset_samples  # noqa: PLC0415
    from corsmal.filling import FillingTraining, train_filling  # noqa: PLC0415

    settings = FillingTraining.of(preset)
    samples = dataset_samples(root, features)
    with progress_bar("training, %") as progress:
        path = train_filling(
            folder, samples, preset=settings, seed=seed, progress=lambda share: progress(round(100 * share), 100)
        )
    say(f"Weights: {path}")


@app.command("mass")
def mass(
    root: Root,
    folder: RunFolder,
    *,
    preset: Annotated[Literal["paper", "tuned"], typer.Option(help="What is trained, and how.")] = "paper",
    seed: Annotated[int, typer.Option(help="Of the split, the weights and the order.", min=0)] = 0,
) -> None:
    """Train the network for the container's mass on a dataset whose containers were detected."""
    from corsmal.dataset import open_dataset  # noqa: PLC0415
    from corsmal.mass import MassConfig, MassTraining, train_mass  # noqa: PLC0415
    from corsmal.stages.mass_rows import mass_rows  # noqa: PLC0415
    from corsmal.store import Store  # noqa: PLC0415

    settings = MassTraining(network=MassConfig.paper() if preset == "paper" else MassConfig.tuned(), seed=seed)
    with progress_bar("recordings") as progress:
        rows = list(mass_rows(list(open_dataset(root)), store=Store(), progress=progress))
    trained = train_mass(rows, folder, settings)
    dropped = "".join(f"; {count} left out: {reason}" for reason, count in trained.dropped.items())
    say(f"Weights: {trained.path} ({trained.rows} rows, {trained.epochs} epochs{dropped})")


@app.command("wall")
def wall(root: Root) -> None:
    """Learn from annotated capacities how thick the walls are that the preset tuned leaves out."""
    from corsmal.dataset import open_dataset  # noqa: PLC0415
    from corsmal.runs.wall import learn_wall  # noqa: PLC0415
    from corsmal.store import Store  # noqa: PLC0415

    with progress_bar("recordings") as progress:
        learnt = learn_wall(list(open_dataset(root)), store=Store(), progress=progress)
    typer.echo("Capacity, mean error in % of each container: no wall, the preset's, and the wall of all others")
    typer.echo(learnt.table.round(1).to_string(index=False))
    say(f"Wall: {learnt.wall_mm:.1f} mm; estimate with it: --preset tuned --wall {learnt.wall_mm:.1f}")
