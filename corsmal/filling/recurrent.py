"""A recurrent network for short feature arrays, of sound or of sight: a GRU over the rows of every channel.

Not in the paper. Arrays such as VGGish's and R(2+1)D's have a row or two per second; the 2020 challenge's winners read
them with GRUs, too. Here rows are normalised, and the states' mean and maximum over time, averaged over channels, go to
two linear heads. Channels are a sound's microphones or a recording's views, of which some may be missing.
"""

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from corsmal.filling.config import RecurrentConfig
from corsmal.filling.inputs import checked_mask
from corsmal.filling.records import LEVEL_NAMES, TYPE_NAMES


class RecurrentModel(nn.Module):
    """Features of recordings to the logits of filling type and level.

    Args:
        config: its sizes.

    Example:
        >>> model = RecurrentModel(RecurrentConfig(channels=3, features=512)).eval()
        >>> types, levels = model(torch.rand(2, 3, 20, 512))
        >>> types.shape, levels.shape
        (torch.Size([2, 4]), torch.Size([2, 3]))
    """

    duration_mean: Tensor
    duration_std: Tensor

    def __init__(self, config: RecurrentConfig) -> None:
        super().__init__()
        self.config = config
        self.register_buffer("duration_mean", torch.zeros(()))
        self.register_buffer("duration_std", torch.ones(()))
        self.norm = nn.LayerNorm(config.features)
        self.dropout = nn.Dropout(config.dropout)
        self.gru = nn.GRU(config.features, config.hidden, batch_first=True, bidirectional=config.both_ways)
        given = 2 * config.hidden * (1 + config.both_ways) + 1  # mean, maximum and the duration
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
            (B, 4), (B, 3) and (B, T): the share of the states whose maximum lies in the row; sums to 1 over T.
        """
        mask = checked_mask(features, mask, channels=self.config.channels, width=self.config.features)
        count, channels, rows, width = features.shape
        own = mask.repeat_interleave(channels, dim=0)  # (B * C, T)
        pooled, peaks = self._pooled(features.reshape(count * channels, rows, width), own)
        present = features.flatten(2).any(dim=2).to(pooled)  # (B, C)
        weights = present / present.sum(dim=1, keepdim=True).clamp_min(1)
        mean = (weights[..., None] * pooled.view(count, channels, -1)).sum(dim=1)  # (B, ·)
        durations = (mask.sum(dim=1).log() - self.duration_mean) / self.duration_std
        z = torch.cat([self.dropout(mean), durations[:, None]], dim=1)
        return self.type_head(z), self.level_head(z), peaks.view(count, channels, rows).mean(dim=1)

    def _pooled(self, x: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
        """The states' mean and maximum, (N, ·), and where maxima lie, (N, T), from (N, T, features) and (N, T)."""
        lengths = mask.sum(dim=1)
        packed = nn.utils.rnn.pack_padded_sequence(
            self.dropout(self.norm(x)), lengths.cpu(), batch_first=True, enforce_sorted=False
        )
        z, _ = nn.utils.rnn.pad_packed_sequence(self.gru(packed)[0], batch_first=True, total_length=x.shape[1])
        highest, places = z.masked_fill(~mask[..., None], -torch.inf).max(dim=1)
        peaks = torch.zeros_like(mask, dtype=z.dtype).scatter_add_(1, places, torch.ones_like(highest))
        return torch.cat([z.sum(dim=1) / lengths[:, None], highest], dim=1), peaks / places.shape[1]
