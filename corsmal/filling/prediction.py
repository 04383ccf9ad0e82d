"""Filling type and level of a recording, from its features and trained weights."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from corsmal.dataset import TrainedOn
from corsmal.errors import ArgumentError
from corsmal.filling.config import AnyConfig
from corsmal.filling.files import read_filling
from corsmal.filling.frontend import LogMelParameters, check_loud, silent_rows
from corsmal.filling.network import AnyModel, mean_logits
from corsmal.filling.records import FillingPrediction
from corsmal.filling.samples import FillingSample
from corsmal.weights import choose_device, network_digest, read_training

WINDOWS_AT_ONCE = 32


class FillingPredictor:
    """One trained network, or several whose probabilities are averaged.

    Args:
        weights: safetensors written by ``save_filling``, or the authors' ``task1and2.pt``.
        device: such as ``cuda:0``; default: the CPU, which is quick enough for one recording.

    Raises:
        FileError: the file is absent, broken, or of something else.
        ArgumentError: there is no such device.

    Example:
        >>> predictor = FillingPredictor(Path("filling.safetensors"))  # doctest: +SKIP
        >>> prediction = predictor.predict(features)  # (C, T, 128)  # doctest: +SKIP
        >>> prediction.filling_type, prediction.filling_level, prediction.type_probabilities  # doctest: +SKIP
    """

    def __init__(self, weights: Path, *, device: str | None = None) -> None:
        self._device = choose_device(device)
        self._models = [model.to(self._device) for model in read_filling(weights)]
        count = len(self._models)
        self.name = f"filling network, weights {weights.name}" + (f", mean of {count}" if count > 1 else "")
        self.digest = network_digest("filling", weights)
        self.trained_on = TrainedOn.from_json(read_training(weights, "filling"))

    @property
    def config(self) -> AnyConfig:
        """Of the first model; all agree on the channels, the features and how the answer is read."""
        return self._models[0].config

    @property
    def front_end(self) -> LogMelParameters:
        """How sound becomes the features that it expects."""
        return LogMelParameters.of(self.config.front_end)

    @property
    def channels(self) -> int:
        """C of the features that it expects."""
        return self.config.channels

    def predict(
        self, features: NDArray[np.floating], *, crop: tuple[int, int] | None = None, steps_s: float | None = None
    ) -> FillingPrediction:
        """What one recording holds.

        Args:
            features: (C, T, features), log-mel or such as the weights were trained on.
            crop: [start, end) of the rows to look at; default: all.
            steps_s: seconds from one row to the next, kept in the record.

        Raises:
            ArgumentError: the features have another shape, are empty or not finite, or the crop lies outside or holds
                silence for which the front end has no number.
        """
        rows = crop or (0, features.shape[1] if features.ndim == 3 else 0)
        return self._predict(features, [rows], steps_s)[0]

    def predict_sample(self, sample: FillingSample) -> FillingPrediction:
        """What a recording of a training set holds, whose truth is not used."""
        return self.predict(sample.features)

    def predict_windows(
        self, features: NDArray[np.floating], *, window: int, hop: int, steps_s: float | None = None
    ) -> list[FillingPrediction]:
        """What the network would say had it heard only a window, sliding across the recording.

        Args:
            features: as for ``predict``.
            window: rows of a window; a shorter recording is one window.
            hop: rows from the start of one window to the next.
            steps_s: as for ``predict``.

        Returns:
            One record per window that lies inside the recording; ``rows`` says where. Windows with silence for which
            the front end has no number are left out.

        Raises:
            ArgumentError: window or hop is not positive, or as for ``predict``.
        """
        if window < 1 or hop < 1:
            raise ArgumentError(f"window and hop must be at least one row, got {window} and {hop}")
        total = features.shape[1] if features.ndim == 3 else 0
        windows = [(start, min(start + window, total)) for start in range(0, max(total - window, 0) + 1, hop)]
        loud = [crop for crop in windows if total and not silent_rows(features[:, slice(*crop)]).any()]
        return self._predict(features, loud or windows, steps_s)

    def _predict(
        self, features: NDArray[np.floating], crops: Sequence[tuple[int, int]], steps_s: float | None
    ) -> list[FillingPrediction]:
        """One record per crop; all crops are equally long."""
        self._check(features, crops, steps_s)
        cut = [torch.tensor(features[:, start:end], dtype=torch.float32) for start, end in crops]
        batches = [torch.stack(cut[first : first + WINDOWS_AT_ONCE]) for first in range(0, len(cut), WINDOWS_AT_ONCE)]
        answers = [_answer(self._models, batch.to(self._device)) for batch in batches]
        types, levels, attention = (torch.cat(part).cpu().double().numpy() for part in zip(*answers, strict=True))
        return [
            FillingPrediction(
                type_logits=types[index],
                level_logits=levels[index],
                attention=attention[index] / attention[index].sum(),
                steps_s=steps_s,
                rows=rows,
                decoding=self.config.decoding,
            )
            for index, rows in enumerate(crops)
        ]

    def _check(self, features: NDArray[np.floating], crops: Sequence[tuple[int, int]], steps_s: float | None) -> None:
        expected = (self.config.channels, self.config.features)
        if features.ndim != 3 or (features.shape[0], features.shape[2]) != expected or not features.shape[1]:
            wanted = f"({expected[0]}, T, {expected[1]}) with T at least 1"
            raise ArgumentError(f"features must be {wanted} for these weights, got {features.shape}")
        for start, end in crops:
            if not 0 <= start < end <= features.shape[1]:
                raise ArgumentError(f"crop must lie in 0..{features.shape[1]}, start before end, got {(start, end)}")
        if np.isfinite(features).all():
            return
        if not (np.isfinite(features) | np.isneginf(features)).all():
            raise ArgumentError("features must be finite, got NaN or infinity")
        for start, end in crops:
            check_loud(features[:, start:end], row_s=steps_s, first=start)


@torch.inference_mode()
def _answer(models: Sequence[AnyModel], batch: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """(B, 4) and (B, 3) logits and (B, T) attention: one model's own, or the mean of several (of probabilities)."""
    types, levels, attention = zip(*(model.explain(batch) for model in models), strict=True)
    return mean_logits(types), mean_logits(levels), torch.stack(tuple(attention)).mean(dim=0)
