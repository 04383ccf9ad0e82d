"""Filling type and level of a recording from its sound, its views, or both."""

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from corsmal.dataset import TrainedOn
from corsmal.errors import ArgumentError, NotFoundError
from corsmal.filling.features import Features
from corsmal.filling.frontend import LogMelParameters
from corsmal.filling.fused import FusedConfig, is_fused, read_fused
from corsmal.filling.fusion import Answer, Sense
from corsmal.filling.prediction import FillingPredictor
from corsmal.filling.records import FillingPrediction, FusedPrediction, PredictsFilling
from corsmal.filling.samples import FillingSample
from corsmal.filling.sight import Senses, part_of
from corsmal.weights import choose_device, network_digest, read_training


class FusedPredictor:
    """The networks of both senses with their gate.

    Args:
        weights: safetensors written by ``save_fused``.
        device: such as ``cuda:0``; default: the CPU.

    Raises:
        FileError: the file is absent, broken, or of something else.
        ArgumentError: there is no such device.

    Example:
        >>> predictor = FusedPredictor(Path("filling.safetensors"))  # doctest: +SKIP
        >>> prediction = predictor.predict(sound, sight=sight)  # (C, T, 128), (3, T, 512)  # doctest: +SKIP
        >>> prediction.filling_level, prediction.sight_share  # doctest: +SKIP
    """

    def __init__(self, weights: Path, *, device: str | None = None) -> None:
        self._device = choose_device(device)
        self._model = read_fused(weights).to(self._device)
        self.name = f"fused filling network, weights {weights.name}"
        self.digest = network_digest("filling", weights)
        self.trained_on = TrainedOn.from_json(read_training(weights, "filling"))

    @property
    def config(self) -> FusedConfig:
        """The sizes of both senses' networks."""
        return self._model.config

    @property
    def front_end(self) -> LogMelParameters:
        """How the sound of a recording without arrays becomes rows."""
        return LogMelParameters.of(self.config.sound[0].front_end)

    @torch.inference_mode()
    def predict(
        self,
        features: NDArray[np.floating] | None,
        *,
        sight: NDArray[np.floating] | None = None,
        steps_s: float | None = None,
        calibrated: bool = True,
    ) -> FusedPrediction:
        """What one recording holds.

        Args:
            features: (C, T, features) of its sound, such as the weights were trained on; None: it is missing.
            sight: (views, T, features) of its videos, a missing view zero everywhere; None: they are missing.
            steps_s: seconds from one row of the sound to the next, kept in the record.
            calibrated: whether the temperatures are used.

        Raises:
            ArgumentError: both are missing, or one has another shape, is empty or not finite.
        """
        given = {"sound": self._checked("sound", features), "sight": self._checked("sight", sight)}
        heard = None if given["sound"] is None else self._model.answer("sound", given["sound"])
        seen = None if given["sight"] is None else self._model.answer("sight", given["sight"])
        types, levels, share = self._model.gate(heard, seen, calibrated=calibrated)
        return FusedPrediction(
            _numbers(types),
            _numbers(levels),
            steps_s=steps_s,
            decoding="feasible",
            sound=self._alone(heard, None),
            sight=self._alone(None, seen),
            sight_share=float(share[0]),
            kind_probabilities=None if seen is None or seen.kinds is None else _numbers(seen.kinds.exp()),
        )

    def predict_sample(self, sample: FillingSample) -> FusedPrediction:
        """What a recording of a training set holds, whose truth is not used."""
        return self.predict(sample.features, sight=sample.sight)

    def _alone(self, sound: Answer | None, sight: Answer | None) -> FillingPrediction | None:
        if sound is None and sight is None:
            return None
        types, levels, _ = self._model.gate(sound, sight)
        return FillingPrediction(_numbers(types), _numbers(levels), decoding="feasible")

    def _checked(self, sense: Sense, array: NDArray[np.floating] | None) -> Tensor | None:
        """(1, C, T, features) on the device."""
        if array is None:
            return None
        own = getattr(self.config, sense)[0]
        name = "features" if sense == "sound" else "sight"
        if array.ndim != 3 or (array.shape[0], array.shape[2]) != (own.channels, own.features) or not array.shape[1]:
            wanted = f"({own.channels}, T, {own.features}) with T at least 1"
            raise ArgumentError(f"{name} must be {wanted} for these weights, got {array.shape}")
        if not np.isfinite(array).all():
            raise ArgumentError(f"{name} must be finite, got NaN or infinity")
        return torch.tensor(array, dtype=torch.float32, device=self._device)[None]


def open_filling(weights: Path) -> FillingPredictor | FusedPredictor:
    """The predictor of a file of weights, whichever network it holds.

    Raises:
        FileError: the file is absent, broken, or of something else.
    """
    return FusedPredictor(weights) if is_fused(weights) else FillingPredictor(weights)


def predicted_from(given: Features | Senses, predictor: PredictsFilling) -> FillingPrediction:
    """What a recording holds, from ``recording_features`` or ``recording_senses``.

    Raises:
        ArgumentError: there is sight, and the predictor is no ``FusedPredictor``; or as for its ``predict``.
    """
    if isinstance(given, Features):
        return predictor.predict(given.values, steps_s=given.row_s)
    if not isinstance(predictor, FusedPredictor):
        raise ArgumentError("the filling network reads sound only; name a fused one, or no features of the videos")
    return _asked(given, predictor)


def predicted_within(given: Senses, predictor: FusedPredictor, stretch_s: tuple[float, float]) -> FusedPrediction:
    """What the network would have said of a stretch of a recording.

    Args:
        given: of the whole recording.
        predictor: the network.
        stretch_s: its start and end, s.

    Raises:
        NotFoundError: no row of features lies within.
    """
    return _asked(part_of(given, *stretch_s), predictor)


def predicted_until(
    given: Senses, predictor: FusedPredictor, times_s: Sequence[float]
) -> list[tuple[float, FusedPrediction]]:
    """What the network would have said, had the recording ended earlier.

    Args:
        given: of the whole recording.
        predictor: the network.
        times_s: seconds from its start.

    Returns:
        Each time with the prediction; times are left out until which there is no row of features.
    """
    found = []
    for time_s in times_s:
        with suppress(NotFoundError):
            found.append((time_s, predicted_within(given, predictor, (0.0, time_s))))
    return found


def _asked(given: Senses, predictor: FusedPredictor) -> FusedPrediction:
    if given.sound is None:
        return predictor.predict(None, sight=given.sight)
    return predictor.predict(given.sound.values, sight=given.sight, steps_s=given.sound.row_s)


def _numbers(logits: Tensor) -> NDArray[np.float64]:
    return logits[0].cpu().double().numpy()
