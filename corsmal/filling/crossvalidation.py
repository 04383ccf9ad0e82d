"""Cross-validation: every recording predicted by networks that were not trained on it, one row each."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Literal, get_args

import pandas as pd

from corsmal.dataset import TrainedOn
from corsmal.errors import ArgumentError, check_choice
from corsmal.files import writing
from corsmal.filling.prediction import FillingPredictor
from corsmal.filling.recipe import FillingTraining, Preset
from corsmal.filling.records import LEVEL_NAMES, PREDICTION_COLUMNS, TYPE_NAMES
from corsmal.filling.samples import FillingSample
from corsmal.filling.training import part_of, train_filling

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
    preset: Preset | FillingTraining = "paper",
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
        preset: ``paper``, ``tuned``, or settings of your own.
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
    fold_of = {sample.recording_id: _fold(folds, sample) for sample in samples}
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
        weights = train_filling(
            folder / f"seed{seed}" / f"fold{fold}",
            others,
            preset=preset,
            seed=seed,
            validation=held if validation == "fold" else None,
            trained_on=None if trained_on is None else trained_on.part(seen, protocol=protocol, fold=fold),
            progress=part_of(progress, done, len(runs)),
        )
        predictor = FillingPredictor(weights)
        for sample in held:
            rows[seed, sample.recording_id] = {**_row(sample, predictor), "fold": fold, "seed": seed}
    ordered = [rows[seed, sample.recording_id] for seed in seeds for sample in samples]
    table = pd.DataFrame(ordered, columns=list(COLUMNS))
    with writing(folder / "predictions.csv", advice="choose another folder") as part:
        table.to_csv(part, index=False)
    return table


def _fold(folds: Mapping[str, int] | pd.Series, sample: FillingSample) -> int:
    try:
        return int(folds[sample.recording_id])
    except (KeyError, TypeError, ValueError) as error:
        raise ArgumentError(f"folds must name a fold for every sample, got none for {sample.recording_id}") from error


def _row(sample: FillingSample, predictor: FillingPredictor) -> dict[str, object]:
    prediction = predictor.predict(sample.features)
    return {
        "recording_id": sample.recording_id,
        "container_id": sample.container_id,
        "true_type": sample.filling_type,
        "true_level": sample.filling_level,
        "predicted_type": prediction.filling_type,
        "predicted_level": prediction.filling_level,
        **{f"p_{name}": value for name, value in prediction.probabilities.items()},
    }
