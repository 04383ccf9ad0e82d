"""``train mass`` and ``evaluate mass``: the network for the container's mass."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from corsmal.commands import Root, RunFolder, progress_bar, say, show
from corsmal.errors import FileError

if TYPE_CHECKING:
    from corsmal.mass import MassRow


def train(
    root: Root,
    folder: RunFolder,
    *,
    preset: Annotated[
        Literal["paper", "tuned"],
        typer.Option(help="paper: as published; tuned: the network also sees the image's scale, and learns ln(1 + g)."),
    ] = "paper",
    epochs: Annotated[int, typer.Option(help="Maximum number of epochs; most runs stop earlier.", min=1)] = 5000,
    seed: Annotated[int, typer.Option(help="Random seed for split, initial weights and order.", min=0)] = 0,
) -> None:
    """Train the network for the container's mass on the annotated recordings of a dataset.

    Detections are needed: beside the videos, or from `detect`.
    """
    from corsmal.dataset import TrainedOn, open_dataset
    from corsmal.mass import MassConfig, MassTraining, train_mass

    network = MassConfig.paper() if preset == "paper" else MassConfig.tuned()
    rows, dataset = _rows(root), open_dataset(root)
    trained_on = replace(TrainedOn.of([dataset[row.recording_id] for row in rows]), facts={"shape": "paper"})
    trained = train_mass(rows, folder, MassTraining(network=network, epochs=epochs, seed=seed), trained_on=trained_on)
    for reason, count in trained.dropped.items():
        say(f"Recordings not used: {count} ({reason})")
    say(f"Recordings trained on: {trained.rows}, validated on: {trained.validation_rows}; epochs: {trained.epochs}")
    say(f"Weights: {trained.path}")


def evaluate(
    root: Root,
    weights: Annotated[Path | None, typer.Argument(metavar="WEIGHTS", help="Default: the demo's weights.")] = None,
) -> None:
    """Evaluate the network for the container's mass on the annotated recordings of a dataset.

    Detections are needed: beside the videos, or from `detect`.
    """
    from corsmal.mass import MassPredictor
    from corsmal.mass.judging import judge_mass, mass_table
    from corsmal.weights import find_weights

    predictor, rows = MassPredictor(find_weights("mass", weights).path), _rows(root)
    judged = judge_mass(predictor, rows)
    show("Container mass: MAPE in %, challenge score s7 in %", mass_table(judged))
    mean_g = sum(row.mass_g for row in rows) / len(rows)
    show(f"For comparison: always the mean, {mean_g:.1f} g", mass_table(judged.assign(mass_g=mean_g)))


def _rows(root: Path) -> "list[MassRow]":
    """What the network sees of every recording with an annotated container mass.

    Raises:
        FileError: there is none.
    """
    from corsmal.dataset import open_dataset
    from corsmal.stages.mass_rows import mass_rows
    from corsmal.store import Store

    with progress_bar("recordings") as progress:
        rows = list(mass_rows(list(open_dataset(root)), store=Store(), progress=progress))
    if not rows:
        raise FileError(root, "has no recording with an annotated container mass")
    return rows
