"""What the networks for short feature arrays share: rows of every channel summed up over time, and two linear heads."""

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from corsmal.filling.config import ConvolvedConfig, RecurrentConfig
from corsmal.filling.inputs import checked_mask
from corsmal.filling.records import LEVEL_NAMES, TYPE_NAMES


class SummarisedModel(nn.Module):
    """Features of recordings to the logits of filling type and level.

    Rows are normalised. Each channel is summed up by ``_pooled``, the present channels are averaged, and the heads are
    given that and the standardised logarithm of the number of rows.

    Args:
        config: its sizes.
    """

    duration_mean: Tensor
    duration_std: Tensor

    def __init__(self, config: RecurrentConfig | ConvolvedConfig) -> None:
        super().__init__()
        self.config = config
        self.register_buffer("duration_mean", torch.zeros(()))
        self.register_buffer("duration_std", torch.ones(()))
        self.norm = nn.LayerNorm(config.features)
        self.dropout = nn.Dropout(config.dropout)

    def _add_heads(self, pooled: int) -> None:
        """Make the heads, after all other layers, for that many numbers from ``_pooled`` and the duration."""
        self.type_head = nn.Linear(pooled + 1, len(TYPE_NAMES))
        self.level_head = nn.Linear(pooled + 1, len(LEVEL_NAMES))

    def learn_statistics(self, recordings: Sequence[NDArray[np.float32]]) -> None:
        """Take mean and deviation of log T from the recordings, (C, T, features) each."""
        durations = np.log([features.shape[1] for features in recordings])
        self.duration_mean.fill_(float(durations.mean()))
        self.duration_std.fill_(float(durations.std()) or 1.0)

    def forward(self, features: Tensor, mask: Tensor | None = None) -> tuple[Tensor, Tensor]:
        """Logits of type (B, 4) and level (B, 3); arguments as in ``FillingModel.forward``.

        A channel that is zero everywhere is missing; a recording without any is answered from its duration.
        """
        return self.explain(features, mask)[:2]

    def explain(self, features: Tensor, mask: Tensor | None = None) -> tuple[Tensor, Tensor, Tensor]:
        """``forward``, and which rows the answer rests on.

        Returns:
            (B, 4), (B, 3) and (B, T): the share of the states, or of the last convolution's outputs, whose maximum lies
            in the row; sums to 1 over T.
        """
        mask = checked_mask(features, mask, channels=self.config.channels, width=self.config.features)
        count, channels, rows, width = features.shape
        own = mask.repeat_interleave(channels, dim=0)  # (B * C, T)
        pooled, peaks = self._pooled(features.reshape(count * channels, rows, width), own)
        present = features.flatten(2).any(dim=2).to(pooled)  # (B, C)
        weights = present / present.sum(dim=1, keepdim=True).clamp_min(1)
        mean = (weights[..., None] * pooled.view(count, channels, -1)).sum(dim=1)  # (B, pooled)
        durations = (mask.sum(dim=1).log() - self.duration_mean) / self.duration_std
        z = torch.cat([self.dropout(mean), durations[:, None]], dim=1)
        return self.type_head(z), self.level_head(z), peaks.view(count, channels, rows).mean(dim=1)

    def _pooled(self, x: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
        """What sums up each channel, (N, pooled), and where maxima lie, (N, T), from (N, T, features) and (N, T)."""
        raise NotImplementedError
