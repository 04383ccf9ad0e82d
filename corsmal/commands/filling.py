"""``train filling`` and ``evaluate filling``: the network for filling type and level."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from corsmal.commands import FeatureOptions, Root, RunFolder, complain, progress_bar, say, show
from corsmal.errors import CorsmalError, FileError
from corsmal.parameters import FillingPreset

if TYPE_CHECKING:
    from corsmal.dataset import Dataset, TrainedOn
    from corsmal.filling import FillingSample, FillingTraining, FusedTraining
    from corsmal.filling.config import FrontEnd

PresetOption = Annotated[
    FillingPreset,
    typer.Option(
        help="paper: one network, trained as published; released: as in the authors' program; tuned: eight networks, "
        "averaged; fused: networks of sound and of sight with a gate, from --features of both."
    ),
]
Epochs = Annotated[
    int | None,
    typer.Option(
        help="Number of epochs; default: 150 for paper, 100 for released, 30 for tuned, each sense's own for fused.",
        min=1,
    ),
]


def train(
    root: Root,
    folder: RunFolder,
    *,
    features: FeatureOptions = None,
    preset: PresetOption = "paper",
    epochs: Epochs = None,
    retrain: Annotated[
        bool,
        typer.Option("--retrain", help="Then train on all recordings for the number of epochs that proved best."),
    ] = False,
    seed: Annotated[int, typer.Option(help="Random seed for initial weights, order and crops.", min=0)] = 0,
) -> None:
    """Train the network for filling type and level on the annotated recordings of a dataset.

    With the presets paper and released a seventh of them is held out, by which the best epoch is chosen; with released,
    recording 000377 of the published set is left out.
    """
    from corsmal.dataset import open_dataset
    from corsmal.filling import FillingTraining, train_either
    from corsmal.filling.training import missing_classes

    if retrain and preset == "fused":
        raise typer.BadParameter("the preset fused chooses no epoch", param_hint="--retrain")
    training = _training(preset, epochs)
    dataset = open_dataset(root)
    samples = _samples(dataset, features, preset=preset)
    trained_on = _record(dataset, samples, features)
    if absent := missing_classes(samples):
        say(f"No recording holds {', '.join(absent)}: the network will not name it.")
    with _training_bar() as progress:
        if isinstance(training, FillingTraining):
            training = replace(training, retrain=retrain)
        path = train_either(folder, samples, training=training, seed=seed, trained_on=trained_on, progress=progress)
    say(f"Weights: {path}")


def evaluate(
    root: Root,
    folder: RunFolder,
    *,
    features: FeatureOptions = None,
    preset: PresetOption = "paper",
    epochs: Epochs = None,
    folds: Annotated[
        Literal["spread", "containers"],
        typer.Option(
            help="spread: seven folds, each with every filling type and level; containers: three folds of unseen "
            "containers (1, 4, 7; 2, 5, 8; 3, 6, 9)."
        ),
    ] = "spread",
    seeds: Annotated[int, typer.Option(help="Number of cross-validations, with the seeds 0, 1, …", min=1)] = 1,
) -> None:
    """Cross-validate the network for filling type and level on the annotated recordings of a dataset."""
    from corsmal.dataset import open_dataset
    from corsmal.evaluation import (
        calibration_table,
        condition_table,
        filling_confusion_tables,
        filling_container_table,
        pooled_table,
    )
    from corsmal.filling import cross_validate, folds_by_container, spread_folds
    from corsmal.filling.senses import predictions_by_condition

    dataset = open_dataset(root)
    samples = _samples(dataset, features, preset=preset)
    known = dataset.table.loc[[sample.recording_id for sample in samples]]
    split = spread_folds(known) if folds == "spread" else folds_by_container(known)
    training = _training(preset, epochs)
    with _training_bar() as progress:
        predictions = cross_validate(
            folder,
            samples,
            folds=split,
            preset=training,
            seeds=range(seeds),
            trained_on=_record(dataset, samples, features),
            progress=progress,
        )
    show("Weighted F1 in %, all folds pooled", pooled_table(predictions))
    tables = {"as trained": predictions}
    if preset == "fused":
        tables |= predictions_by_condition(folder, samples, folds=split, seeds=range(seeds))
        show("Weighted F1 in %: as trained, without calibration, a sense left out, both noisy", condition_table(tables))
    title = "Expected calibration error of the level, and what is wrong among the surest 100, 90, 80, 70 %, in %"
    show(title, calibration_table(tables))
    show("MPF1 in % by container", filling_container_table(predictions))
    for quantity in ("filling_level", "filling_type"):
        for kind, table in filling_confusion_tables(predictions, quantity).items():
            if table.to_numpy().any():
                show(f"{quantity.replace('_', ' ')}, {kind}: rows are true, columns predicted", table)


def _training(preset: FillingPreset, epochs: int | None) -> "FillingTraining | FusedTraining":
    from corsmal.filling import FillingTraining, FusedTraining

    if preset == "fused":
        fused = FusedTraining()
        return fused if epochs is None else fused.lasting(epochs)
    training = FillingTraining.of(preset)
    return training if epochs is None else replace(training, epochs=epochs)


def _record(dataset: "Dataset", samples: "list[FillingSample]", features: list[Path] | None) -> "TrainedOn":
    """What the weights keep about their training."""
    from corsmal.digests import digest
    from corsmal.filling.sight import FeatureFolders
    from corsmal.stages.training_facts import training_record

    is_sound = FeatureFolders.of(features or []).sound is None
    arrays = {} if is_sound else {sample.recording_id: digest(sample.features) for sample in samples}
    return training_record(dataset, [dataset[sample.recording_id] for sample in samples], features=arrays)


def _samples(dataset: "Dataset", features: list[Path] | None, *, preset: FillingPreset) -> "list[FillingSample]":
    """The annotated recordings with the features of the preset.

    A recording without those of its sound, or with a sound that the preset cannot use, is reported and skipped.

    Raises:
        FileError: no recording has both.
    """
    from corsmal.filling import filling_samples
    from corsmal.filling.features import training_features
    from corsmal.filling.sight import FeatureFolders, sight_features
    from corsmal.store import Store

    folders, store = FeatureFolders.of(features or []), Store()
    front_end: FrontEnd = "released" if preset == "released" else "paper"
    found, seen = {}, {}
    with progress_bar("features") as progress:
        for done, recording in enumerate(dataset, start=1):
            try:
                given = training_features(recording, front_end=front_end, folder=folders.sound, store=store)
                found[recording.id] = given.values
                if folders.sight is not None:
                    seen[recording.id] = sight_features(folders.sight, recording.id)
            except CorsmalError as error:
                complain(recording.id, error)
            progress(done, len(dataset))
    samples = filling_samples(dataset.table, found, sight=seen)
    if not samples:
        source = "audio" if folders.sound is None else f"an array in {folders.sound}"
        raise FileError(dataset.root, f"has no recording with both {source} and an annotated filling")
    return samples


@contextmanager
def _training_bar() -> Iterator[Callable[[float], None]]:
    with progress_bar("training, %") as progress:
        yield lambda fraction: progress(round(100 * fraction), 100)
