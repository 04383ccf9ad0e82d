"""A recurrent network for short feature arrays, of sound or of sight: a GRU over the rows of every channel.

Not in the paper. Arrays such as VGGish's and R(2+1)D's have a row or two per second; the 2020 challenge's winners read
them with GRUs, too. Here rows are normalised, and the states' mean and maximum over time, averaged over channels, go to
two linear heads. Channels are a sound's microphones or a recording's views, of which some may be missing.
"""

import torch
from torch import Tensor, nn

from corsmal.filling.config import RecurrentConfig
from corsmal.filling.summarised import SummarisedModel


class RecurrentModel(SummarisedModel):
    """Features of recordings to the logits of filling type and level.

    Args:
        config: its sizes.

    Example:
        >>> model = RecurrentModel(RecurrentConfig(channels=3, features=512)).eval()
        >>> types, levels = model(torch.rand(2, 3, 20, 512))
        >>> types.shape, levels.shape
        (torch.Size([2, 4]), torch.Size([2, 3]))
    """

    def __init__(self, config: RecurrentConfig) -> None:
        super().__init__(config)
        self.gru = nn.GRU(config.features, config.hidden, batch_first=True, bidirectional=config.both_ways)
        self._add_heads(2 * config.hidden * (1 + config.both_ways))  # mean and maximum

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
