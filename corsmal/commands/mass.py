"""``train mass`` and ``evaluate mass``: the network for the container's mass."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from corsmal.commands import MatchViews, Offsets, Root, RunFolder, progress_bar, say, shape_preset, show, view_matching
from corsmal.errors import ArgumentError, FileError
from corsmal.parameters import SHAPE_PRESETS, NetworkPreset

if TYPE_CHECKING:
    from corsmal.dataset import Dataset, TrainedOn
    from corsmal.mass import MassRow
    from corsmal.parameters import ShapeParameters

SHAPES = ", ".join(SHAPE_PRESETS)


def train(
    root: Root,
    folder: RunFolder,
    *,
    preset: Annotated[
        NetworkPreset,
        typer.Option(
            help="paper: as published; released: the network and the masks of the authors' program; tuned: the network "
            "also sees the image's scale, and learns ln(1 + g)."
        ),
    ] = "paper",
    shape: Annotated[
        str | None,
        typer.Option(
            help=f"Parameters of the fits that give the dimensions, and of the frames: {SHAPES}; default: released for "
            "the preset released, else paper. Kept in the weights."
        ),
    ] = None,
    axis: Annotated[
        Literal["base", "whole", "top"] | None,
        typer.Option(
            help="How masks are restored; default: base for paper, top for released, whole for tuned. Kept in the "
            "weights."
        ),
    ] = None,
    padding: Annotated[
        int | None, typer.Option(help="Pixels around a mask's box; default: 15. Kept in the weights.", min=0)
    ] = None,
    epochs: Annotated[int, typer.Option(help="Maximum number of epochs; most runs stop earlier.", min=1)] = 5000,
    seed: Annotated[int, typer.Option(help="Random seed for split, initial weights and order.", min=0)] = 0,
    match: MatchViews = None,
    offset: Offsets = None,
) -> None:
    """Train the network for the container's mass on the annotated recordings of a dataset.

    Detections are needed: beside the videos, or from `detect`.
    """
    from corsmal.dataset import open_dataset
    from corsmal.mass import MassConfig, MassTraining, train_mass
    from corsmal.stages.training_facts import training_record

    network = MassConfig.of(preset)
    network = replace(network, axis=axis or network.axis, padding_px=network.padding_px if padding is None else padding)
    dataset = open_dataset(root).matched(view_matching(match, offset))
    parameters = shape_preset(shape or ("released" if preset == "released" else "paper"), option="--shape")
    rows = _rows(dataset, parameters)
    trained_on = training_record(dataset, [dataset[row.recording_id] for row in rows], shape=parameters)
    trained = train_mass(rows, folder, MassTraining(network=network, epochs=epochs, seed=seed), trained_on=trained_on)
    for reason, count in trained.dropped.items():
        say(f"Recordings not used: {count} ({reason})")
    say(f"Recordings trained on: {trained.rows}, validated on: {trained.validation_rows}; epochs: {trained.epochs}")
    say(f"Weights: {trained.path}")


def evaluate(
    root: Root,
    weights: Annotated[Path | None, typer.Argument(metavar="WEIGHTS", help="Default: the demo's weights.")] = None,
    *,
    shape: Annotated[
        str | None,
        typer.Option(help=f"Parameters of the fits: {SHAPES}; default: those that the network was trained with."),
    ] = None,
    protocol: Annotated[
        Literal["held-out", "in-sample"],
        typer.Option(help="held-out: only recordings that the network was not trained on; in-sample: all."),
    ] = "held-out",
    match: MatchViews = None,
    offset: Offsets = None,
) -> None:
    """Evaluate the network for the container's mass on the annotated recordings of a dataset.

    Detections are needed: beside the videos, or from `detect`.
    """
    from corsmal.dataset import open_dataset
    from corsmal.evaluation.protocols import STAMPS, TRAINED, UNKNOWN
    from corsmal.mass import MassPredictor
    from corsmal.mass.judging import judge_mass, mass_table
    from corsmal.stages.training_facts import trained_shape
    from corsmal.weights import find_weights

    predictor = MassPredictor(find_weights("mass", weights).path)
    dataset = open_dataset(root).matched(view_matching(match, offset))
    trained = trained_shape(predictor.trained_on)
    chosen = shape or (trained if trained in SHAPE_PRESETS else "paper")
    if trained is not None and chosen != trained:
        say(f"The network was trained on dimensions of the shape preset {trained}; these are of {chosen}.")
    rows = _rows(dataset, shape_preset(chosen, option="--shape"))
    judged = [row for row in rows if not _has_seen(predictor.trained_on, dataset, row)]
    if len(judged) < len(rows):
        why = TRAINED if predictor.trained_on else UNKNOWN
        verb = "are left out" if protocol == "held-out" else "are in-sample"
        say(f"{len(rows) - len(judged)} of {len(rows)} recordings {verb}: {why}.")
    say(STAMPS[protocol])
    if protocol == "in-sample":
        judged = rows
    if not judged:
        raise ArgumentError("no recording is left to judge; `--protocol in-sample` judges all of them")
    found = judge_mass(predictor, judged)
    show(f"Container mass ({protocol}): MAPE in %, challenge score s7 in %", mass_table(found))
    mean_g = sum(row.mass_g for row in rows) / len(rows)
    show(f"For comparison: always the dataset's mean, {mean_g:.1f} g", mass_table(found.assign(mass_g=mean_g)))


def _has_seen(trained_on: "TrainedOn | None", dataset: "Dataset", row: "MassRow") -> bool:
    return trained_on is None or trained_on.has_seen(dataset[row.recording_id])


def _rows(dataset: "Dataset", shape: "ShapeParameters") -> "list[MassRow]":
    """What the network sees of every recording with an annotated container mass.

    Raises:
        FileError: there is none.
    """
    from corsmal.stages.mass_rows import mass_rows
    from corsmal.store import Store

    with progress_bar("recordings") as progress:
        rows = list(mass_rows(list(dataset), store=Store(), shape=shape, progress=progress))
    if not rows:
        raise FileError(dataset.root, "has no recording with an annotated container mass")
    return rows
