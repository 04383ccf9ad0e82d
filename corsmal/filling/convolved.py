"""A convolutional network for short feature arrays, of sound or of sight: convolutions over the rows of every channel.

Not in the paper. An array such as VGGish's has seven rows in the median, so that two convolutions see most of
it. What matters is how the rows are summed up: beside mean and maximum over time stands their sum, because the longer a
filling is poured, the more of it there is. (Within the training containers of the winners' folds, level by one network:
73.4 without the sum, 75.7 with it.)
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from corsmal.filling.config import ConvolvedConfig
from corsmal.filling.inputs import checked_mask
from corsmal.filling.records import LEVEL_NAMES, TYPE_NAMES

SUM_ROWS = 8
"""Sums over time are divided by this number of rows, about the median, so that they are as large as the means."""


class ConvolvedModel(nn.Module):
    """Features of recordings to the logits of filling type and level.

    Args:
        config: its sizes.

    Example:
        >>> model = ConvolvedModel(ConvolvedConfig()).eval()
        >>> types, levels = model(torch.rand(2, 1, 7, 128))
        >>> types.shape, levels.shape
        (torch.Size([2, 4]), torch.Size([2, 3]))
    """

    duration_mean: Tensor
    duration_std: Tensor

    def __init__(self, config: ConvolvedConfig) -> None:
        super().__init__()
        self.config = config
        self.register_buffer("duration_mean", torch.zeros(()))
        self.register_buffer("duration_std", torch.ones(()))
        self.norm = nn.LayerNorm(config.features)
        self.dropout = nn.Dropout(config.dropout)
        widths = (config.features, *(config.hidden,) * config.layers)
        self.convolutions = nn.ModuleList(
            nn.Conv1d(before, after, config.kernel, padding=config.kernel // 2) for before, after in pairwise(widths)
        )
        given = 3 * config.hidden + 1  # mean, maximum, sum and the duration
        self.type_head = nn.Linear(given, len(TYPE_NAMES))
        self.level_head = nn.Linear(given, len(LEVEL_NAMES))

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
            (B, 4), (B, 3) and (B, T): the share of the last convolution's outputs whose maximum lies in the row; sums
            to 1 over T.
        """
        mask = checked_mask(features, mask, channels=self.config.channels, width=self.config.features)
        count, channels, rows, width = features.shape
        own = mask.repeat_interleave(channels, dim=0)  # (B * C, T)
        pooled, peaks = self._pooled(features.reshape(count * channels, rows, width), own)
        present = features.flatten(2).any(dim=2).to(pooled)  # (B, C)
        weights = present / present.sum(dim=1, keepdim=True).clamp_min(1)
        mean = (weights[..., None] * pooled.view(count, channels, -1)).sum(dim=1)  # (B, 3 · hidden)
        durations = (mask.sum(dim=1).log() - self.duration_mean) / self.duration_std
        z = torch.cat([self.dropout(mean), durations[:, None]], dim=1)
        return self.type_head(z), self.level_head(z), peaks.view(count, channels, rows).mean(dim=1)

    def _pooled(self, x: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
        """(N, 3 · hidden) mean, maximum and sum, and where maxima lie, (N, T), from (N, T, features) and (N, T)."""
        own = mask[:, None]  # (N, 1, T)
        x = self.dropout(self.norm(x)).transpose(1, 2)  # (N, features, T)
        for convolution in self.convolutions:
            x = functional.gelu(convolution(x * own))  # zeros beyond the end, as the convolution's own padding
        total = (x * own).sum(dim=2)
        highest, places = x.masked_fill(~own, -torch.inf).max(dim=2)
        peaks = torch.zeros_like(mask, dtype=x.dtype).scatter_add_(1, places, torch.ones_like(highest))
        parts = [total / mask.sum(dim=1, keepdim=True), highest, total / SUM_ROWS]
        return torch.cat(parts, dim=1), peaks / places.shape[1]
