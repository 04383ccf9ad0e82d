"""Cross-validation: every recording predicted by networks that were not trained on it, one row each."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Literal, get_args

import pandas as pd

from corsmal.dataset import TrainedOn
from corsmal.errors import ArgumentError, check_choice
from corsmal.files import writing
from corsmal.filling.fused_prediction import FusedPredictor
from corsmal.filling.fused_training import FusedTraining, train_fused
from corsmal.filling.prediction import FillingPredictor
from corsmal.filling.recipe import FillingTraining
from corsmal.filling.records import LEVEL_NAMES, PREDICTION_COLUMNS, TYPE_NAMES, FillingPrediction
from corsmal.filling.samples import FillingSample
from corsmal.filling.training import part_of, train_filling
from corsmal.parameters import NetworkPreset

Validation = Literal["fold", "inner"]
"""What rule (1) chooses the epoch by: ``fold``: the recordings that are then predicted, as in the paper, which flatters
the scores; ``inner``: a seventh of the fold's training recordings, see ``train_filling``."""

COLUMNS = (*PREDICTION_COLUMNS, *(f"p_{name}" for name in (*TYPE_NAMES, *LEVEL_NAMES)))
"""Of the table of predictions; classes are numbers, ``p_`` columns the heads' probabilities."""


def cross_validate(
    folder: Path,
    samples: Sequence[FillingSample],
    *,
    folds: Mapping[str, int] | pd.Series,
    preset: NetworkPreset | FillingTraining | FusedTraining = "paper",
    seeds: Sequence[int] = (0,),
    validation: Validation = "fold",
    trained_on: TrainedOn | None = None,
    progress: Callable[[float], None] | None = None,
) -> pd.DataFrame:
    """Train once per seed and fold, and predict the fold's recordings; resumed where it was stopped.

    Args:
        folder: gets ``predictions.csv``, and a folder with the training and its weights for each seed and fold.
        samples: all recordings.
        folds: fold by recording id, such as ``spread_folds`` and ``folds_by_container`` return; it covers all samples.
        preset: ``paper``, ``released``, ``tuned``, or settings of your own; ``FusedTraining`` for fused networks.
        seeds: one whole cross-validation each.
        validation: what rule (1) uses; not used by settings that keep the last epoch.
        trained_on: all recordings of ``samples``; the weights of each fold keep their part of them.
        progress: called with the fraction that is done, 0..1.

    Returns:
        ``COLUMNS``, one row per seed and recording, in the order of seeds and samples.

    Raises:
        ArgumentError: a sample has no fold, all have the same one, or a fold's training recordings lack a class.
        FileError: the folder cannot be written, or holds another run, or a broken file.
    """
    check_choice("validation", validation, get_args(Validation))
    fold_of = {sample.recording_id: fold_number(folds, sample) for sample in samples}
    numbers = sorted(set(fold_of.values()))
    if len(numbers) < 2:
        raise ArgumentError(f"folds must be two or more, got {len(numbers)}")
    rows: dict[tuple[int, str], dict[str, object]] = {}
    runs = [(seed, fold) for seed in seeds for fold in numbers]
    for done, (seed, fold) in enumerate(runs):
        held = [sample for sample in samples if fold_of[sample.recording_id] == fold]
        others = [sample for sample in samples if fold_of[sample.recording_id] != fold]
        seen = [sample.recording_id for sample in (samples if validation == "fold" else others)]
        protocol = "paper" if validation == "fold" else "held-out"
        place = fold_folder(folder, seed, fold)
        record = None if trained_on is None else trained_on.part(seen, protocol=protocol, fold=fold)
        part = part_of(progress, done, len(runs))
        predict: Callable[[FillingSample], FillingPrediction]
        if isinstance(preset, FusedTraining):
            path = train_fused(place, others, training=preset, seed=seed, trained_on=record, progress=part)
            predict = FusedPredictor(path).predict_sample
        else:
            chosen_by = held if validation == "fold" else None
            path = train_filling(
                place, others, preset=preset, seed=seed, validation=chosen_by, trained_on=record, progress=part
            )
            predict = FillingPredictor(path).predict_sample
        for sample in held:
            rows[seed, sample.recording_id] = {**prediction_row(sample, predict(sample)), "fold": fold, "seed": seed}
    ordered = [rows[seed, sample.recording_id] for seed in seeds for sample in samples]
    return write_predictions(folder / "predictions.csv", ordered)


def fold_folder(folder: Path, seed: int, fold: int) -> Path:
    """Where a cross-validation trains the network of a seed and a fold."""
    return folder / f"seed{seed}" / f"fold{fold}"


def write_predictions(path: Path, rows: Sequence[Mapping[str, object]]) -> pd.DataFrame:
    """The rows as a table of ``COLUMNS``, which is written to ``path``."""
    table = pd.DataFrame(rows, columns=list(COLUMNS))
    with writing(path, advice="choose another folder") as part:
        table.to_csv(part, index=False)
    return table


def fold_number(folds: Mapping[str, int] | pd.Series, sample: FillingSample) -> int:
    """The fold of a sample.

    Raises:
        ArgumentError: it has none.
    """
    try:
        return int(folds[sample.recording_id])
    except (KeyError, TypeError, ValueError) as error:
        raise ArgumentError(f"folds must name a fold for every sample, got none for {sample.recording_id}") from error


def prediction_row(sample: FillingSample, prediction: FillingPrediction) -> dict[str, object]:
    """A row of the table of predictions but for its fold and seed."""
    return {
        "recording_id": sample.recording_id,
        "container_id": sample.container_id,
        "true_type": sample.filling_type,
        "true_level": sample.filling_level,
        "predicted_type": prediction.filling_type,
        "predicted_level": prediction.filling_level,
        **{f"p_{name}": value for name, value in prediction.probabilities.items()},
    }
