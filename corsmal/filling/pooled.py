"""A network for feature arrays of video: what changes over time in the rows, and two FC layers.

Not in the paper. There are hundreds of recordings of few containers, which are soon memorised: recurrent networks on
rows of R(2+1)D knew the levels in unseen containers less well, and take longer to train. Here statistics over time of
rows that are normalised stand beside each other for all views. None of them holds a row's own height: how the picture
looks tells the containers apart, and what changes in it, the filling. (Within the training containers of the winners'
folds, level of cups and glasses: 83.3 and 74.3 with mean, maximum and deviation, 87.5 and 80.8 with these.)
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from corsmal.filling.config import PooledConfig
from corsmal.filling.inputs import checked_mask
from corsmal.filling.records import KINDS, LEVEL_NAMES, TYPE_NAMES
from corsmal.filling.samples import UNKNOWN, Batch, FillingSample

PARTS = 4
"""Stretches of equal length that a recording is cut into."""

STATISTICS = PARTS + 1
"""The mean of each later part minus that of the first, the deviation, and the maximum minus the mean."""

KIND_WEIGHT, TYPE_WEIGHT = 0.3, 0.5
"""Of the cross-entropies of kind and type in the loss, beside that of the level."""

DEVIATION_MIN = 1e-6
"""A statistic with a smaller deviation counts as one that never changes."""


class PooledModel(nn.Module):
    """Features of recordings to the logits of filling type and level, and of the container's kind.

    The kind says when sight is to be trusted: a level in a box cannot be seen, and the network is not trained on it.

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
        self.kind_head = nn.Linear(config.hidden, len(KINDS))

    def learn_statistics(self, recordings: Sequence[NDArray[np.float32]]) -> None:
        """Take means and deviations of the statistics from the recordings, (C, T, features) each."""
        values = torch.stack([_pooled_alone(features) for features in recordings])
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
        return *self.seen(features, mask)[:2], mask / mask.sum(dim=1, keepdim=True)

    def seen(self, features: Tensor, mask: Tensor | None = None) -> tuple[Tensor, Tensor, Tensor]:
        """``forward``, and the logits of the container's kind, (B, 3)."""
        mask = checked_mask(features, mask, channels=self.config.channels, width=self.config.features)
        return self._heads(_pooled(features, mask), features.flatten(2).any(dim=2))

    def _heads(self, pooled: Tensor, present: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """``seen`` from (B, C, STATISTICS · features) statistics, and which channels there are, (B, C)."""
        x = (pooled - self.pooled_mean) / self.pooled_std * present[..., None]
        x = self.dropout(functional.gelu(self.first(self.dropout(x.flatten(1)))))
        return self.type_head(x), self.level_head(x), self.kind_head(x)

    def losses(self, batch: Batch) -> dict[str, Tensor]:
        """The parts of the loss: of the level, but in boxes, of the type, and of the kind where it is known.

        Args:
            batch: of ``condensed`` recordings.
        """
        pooled, present = batch.features[:, :, :-1].flatten(2), batch.features[:, :, -1, 0]
        types, levels, kinds = self._heads(pooled, present)
        visible = batch.kinds != KINDS.index("box")
        level = functional.cross_entropy(levels, batch.levels, reduction="none")
        kind = functional.cross_entropy(kinds, batch.kinds, ignore_index=UNKNOWN, reduction="sum")
        return {
            "level": (level * visible).sum() / visible.sum().clamp_min(1),
            "type": TYPE_WEIGHT * functional.cross_entropy(types, batch.types),
            "kind": KIND_WEIGHT * kind / (batch.kinds != UNKNOWN).sum().clamp_min(1),
        }


def condensed(samples: Sequence[FillingSample]) -> list[FillingSample]:
    """The recordings to train on, their statistics in place of the rows, so that no epoch computes them again.

    Returns:
        Features are (C, STATISTICS + 1, features): the statistics, and ones where the channel is there, zeros where it
        is missing.
    """
    found = []
    for sample in samples:
        channels, _, width = sample.features.shape
        statistics = _pooled_alone(sample.features).numpy().reshape(channels, STATISTICS, width)
        there = np.array([channel.any() for channel in sample.features], dtype=np.float32)
        present = np.broadcast_to(there[:, None, None], (channels, 1, width))
        found.append(replace(sample, features=np.concatenate([statistics, present], axis=1)))
    return found


def _pooled_alone(features: NDArray[np.float32]) -> Tensor:
    """(C, STATISTICS · features) of one recording, from (C, T, features)."""
    given = torch.from_numpy(features)[None]
    return _pooled(given, torch.ones(1, given.shape[2], dtype=torch.bool))[0]


def _pooled(features: Tensor, mask: Tensor) -> Tensor:
    """(B, C, STATISTICS · features) of the mask's rows, from (B, C, T, features) and (B, T).

    A recording of fewer rows than parts has no changes between them.
    """
    x = functional.layer_norm(features, features.shape[-1:])
    own = mask[:, None, :, None]  # (B, 1, T, 1)
    count = own.sum(dim=2)  # (B, 1, 1)
    mean = (x * own).sum(dim=2) / count
    deviation = (((x - mean[:, :, None]) ** 2 * own).sum(dim=2) / count).sqrt()
    highest = x.masked_fill(~own, -torch.inf).amax(dim=2)
    share = _parts(mask).to(x)  # (B, PARTS, T)
    means = torch.einsum("bpt,bctf->bcpf", share, x)
    changes = (means[:, :, 1:] - means[:, :, :1]).flatten(2)
    return torch.cat([changes, deviation, highest - mean], dim=2)


def _parts(mask: Tensor) -> Tensor:
    """(B, PARTS, T) the weight of each row in the mean of each part; what is left over makes the first parts longer."""
    rows = mask.sum(dim=1, keepdim=True)  # (B, 1)
    length, longer = rows // PARTS, rows % PARTS
    place = torch.arange(mask.shape[1], device=mask.device)
    border = longer * (length + 1)
    number = torch.where(place < border, place // (length + 1), longer + (place - border) // length.clamp_min(1))
    inside = (number[:, None] == torch.arange(PARTS, device=mask.device)[:, None]) & mask[:, None]
    inside = torch.where(rows[..., None] < PARTS, mask[:, None], inside)
    return inside / inside.sum(dim=2, keepdim=True).clamp_min(1)
