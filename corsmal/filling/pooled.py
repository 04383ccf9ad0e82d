"""A network for feature arrays of video: statistics of the rows over time, and two FC layers.

Not in the paper. There are hundreds of recordings of few containers, which are soon memorised: recurrent networks on
rows of R(2+1)D knew the levels in unseen containers less well, and take longer to train. Here the mean, the maximum and
the deviation over time of every feature, of rows that are normalised, stand beside each other for all views.
"""

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from corsmal.filling.config import PooledConfig
from corsmal.filling.inputs import checked_mask
from corsmal.filling.records import LEVEL_NAMES, TYPE_NAMES

STATISTICS = 3
"""Mean, maximum and deviation."""

DEVIATION_MIN = 1e-6
"""A statistic with a smaller deviation counts as one that never changes."""


class PooledModel(nn.Module):
    """Features of recordings to the logits of filling type and level.

    Args:
        config: its sizes.

    Example:
        >>> model = PooledModel(PooledConfig()).eval()
        >>> types, levels = model(torch.rand(2, 3, 20, 512))
        >>> types.shape, levels.shape
        (torch.Size([2, 4]), torch.Size([2, 3]))
    """

    pooled_mean: Tensor
    pooled_std: Tensor

    def __init__(self, config: PooledConfig) -> None:
        super().__init__()
        self.config = config
        shape = (config.channels, STATISTICS * config.features)
        self.register_buffer("pooled_mean", torch.zeros(shape))
        self.register_buffer("pooled_std", torch.ones(shape))
        self.dropout = nn.Dropout(config.dropout)
        self.first = nn.Linear(shape[0] * shape[1], config.hidden)
        self.type_head = nn.Linear(config.hidden, len(TYPE_NAMES))
        self.level_head = nn.Linear(config.hidden, len(LEVEL_NAMES))

    def learn_statistics(self, recordings: Sequence[NDArray[np.float32]]) -> None:
        """Take means and deviations of the statistics from the recordings, (C, T, features) each."""
        pooled = []
        for features in recordings:
            given = torch.from_numpy(features)[None]
            pooled.append(_pooled(given, torch.ones(1, given.shape[2], dtype=torch.bool))[0])
        values = torch.stack(pooled)
        self.pooled_mean.copy_(values.mean(dim=0))
        deviation = values.std(dim=0, correction=0)
        self.pooled_std.copy_(torch.where(deviation > DEVIATION_MIN, deviation, 1.0))

    def forward(self, features: Tensor, mask: Tensor | None = None) -> tuple[Tensor, Tensor]:
        """Logits of type (B, 4) and level (B, 3); arguments as in ``FillingModel.forward``.

        A channel that is zero everywhere is missing, and counts as an average one.
        """
        return self.explain(features, mask)[:2]

    def explain(self, features: Tensor, mask: Tensor | None = None) -> tuple[Tensor, Tensor, Tensor]:
        """``forward``, and (B, T) the rows that it rests on: all alike."""
        mask = checked_mask(features, mask, channels=self.config.channels, width=self.config.features)
        x = (_pooled(features, mask) - self.pooled_mean) / self.pooled_std  # (B, C, 3 · features)
        x = x * features.flatten(2).any(dim=2)[..., None]
        x = self.dropout(functional.gelu(self.first(self.dropout(x.flatten(1)))))
        return self.type_head(x), self.level_head(x), mask / mask.sum(dim=1, keepdim=True)


def _pooled(features: Tensor, mask: Tensor) -> Tensor:
    """(B, C, 3 · features) mean, maximum and deviation over the mask's rows, from (B, C, T, features) and (B, T)."""
    x = functional.layer_norm(features, features.shape[-1:])
    own = mask[:, None, :, None]  # (B, 1, T, 1)
    count = own.sum(dim=2)  # (B, 1, 1)
    mean = (x * own).sum(dim=2) / count
    deviation = (((x - mean[:, :, None]) ** 2 * own).sum(dim=2) / count).sqrt()
    highest = x.masked_fill(~own, -torch.inf).amax(dim=2)
    return torch.cat([mean, highest, deviation], dim=2)
