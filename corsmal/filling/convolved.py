"""A convolutional network for short feature arrays, of sound or of sight: convolutions over the rows of every channel.

Not in the paper. An array such as VGGish's has seven rows in the median, so that two convolutions see most of
it. What matters is how the rows are summed up: beside mean and maximum over time stands their sum, because the longer a
filling is poured, the more of it there is. (Within the training containers of the winners' folds, level by one network:
73.4 without the sum, 75.7 with it.)
"""

from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn import functional

from corsmal.filling.config import ConvolvedConfig
from corsmal.filling.summarised import SummarisedModel

SUM_ROWS = 8
"""Sums over time are divided by this number of rows, about the median, so that they are as large as the means."""


class ConvolvedModel(SummarisedModel):
    """Features of recordings to the logits of filling type and level.

    Args:
        config: its sizes.

    Example:
        >>> model = ConvolvedModel(ConvolvedConfig()).eval()
        >>> types, levels = model(torch.rand(2, 1, 7, 128))
        >>> types.shape, levels.shape
        (torch.Size([2, 4]), torch.Size([2, 3]))
    """

    def __init__(self, config: ConvolvedConfig) -> None:
        super().__init__(config)
        widths = (config.features, *(config.hidden,) * config.layers)
        self.convolutions = nn.ModuleList(
            nn.Conv1d(before, after, config.kernel, padding=config.kernel // 2) for before, after in pairwise(widths)
        )
        self._add_heads(3 * config.hidden)  # mean, maximum and sum

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
