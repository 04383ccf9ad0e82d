"""What a cross-validated fused network says uncalibrated, where a sense is missing, or where both are noisy."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from corsmal.filling.crossvalidation import fold_folder, fold_number, prediction_row, write_predictions
from corsmal.filling.fused_prediction import FusedPredictor
from corsmal.filling.records import FusedPrediction
from corsmal.filling.samples import FillingSample

NOISE = 0.5
"""Deviation of the noise on every number, in deviations of the recording's own features."""

Condition = Callable[[FusedPredictor, FillingSample], FusedPrediction]


def _uncalibrated(predictor: FusedPredictor, sample: FillingSample) -> FusedPrediction:
    return predictor.predict(sample.features, sight=sample.sight, calibrated=False)


def _without_sight(predictor: FusedPredictor, sample: FillingSample) -> FusedPrediction:
    return predictor.predict(sample.features)


def _without_sound(predictor: FusedPredictor, sample: FillingSample) -> FusedPrediction:
    return predictor.predict(None if sample.sight is not None else sample.features, sight=sample.sight)


def _noisy(predictor: FusedPredictor, sample: FillingSample) -> FusedPrediction:
    rng = np.random.default_rng([ord(letter) for letter in sample.recording_id])
    sight = None if sample.sight is None else _with_noise(sample.sight, rng)
    return predictor.predict(_with_noise(sample.features, rng), sight=sight)


CONDITIONS: dict[str, Condition] = {
    "not calibrated": _uncalibrated,
    "sound only": _without_sight,
    "sight only": _without_sound,
    "both noisy": _noisy,
}


def predictions_by_condition(
    folder: Path, samples: Sequence[FillingSample], *, folds: Mapping[str, int] | pd.Series, seeds: Sequence[int]
) -> dict[str, pd.DataFrame]:
    """The predictions of ``cross_validate`` by its own networks under each of ``CONDITIONS``.

    Recordings without sight keep their sound.

    Args:
        folder: of the cross-validation; gets ``predictions_sound-only.csv`` and the others.
        samples: as it was given them.
        folds: likewise.
        seeds: likewise.

    Returns:
        A table of ``COLUMNS`` for each of ``CONDITIONS``.

    Raises:
        FileError: weights are missing.
    """
    numbers = {sample.recording_id: fold_number(folds, sample) for sample in samples}
    rows: dict[str, list[dict[str, object]]] = {name: [] for name in CONDITIONS}
    for seed in seeds:
        for fold in sorted(set(numbers.values())):
            predictor = FusedPredictor(fold_folder(folder, seed, fold) / "filling.safetensors")
            for sample in samples:
                if numbers[sample.recording_id] != fold:
                    continue
                for name, predicted in CONDITIONS.items():
                    row = prediction_row(sample, predicted(predictor, sample))
                    rows[name].append({**row, "fold": fold, "seed": seed})
    return {
        name: write_predictions(folder / f"predictions_{name.replace(' ', '-')}.csv", own) for name, own in rows.items()
    }


def _with_noise(array: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    noisy: NDArray[np.float32] = (array + NOISE * array.std() * rng.normal(size=array.shape)).astype(np.float32)
    return noisy
