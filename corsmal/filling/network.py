"""The network that filling type and level share (paper 2): CNN encoder, Transformer encoder, two heads.

The paper gives the layers and no widths. Chosen: blocks normalise before attention and before their FC layers, and not
after the last; the FC layers inside a block are twice as wide as the features; GELU between two FC layers. The config
says where the authors' program does otherwise.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from corsmal.filling.config import AnyConfig, ConvolvedConfig, FillingConfig, PooledConfig, RecurrentConfig
from corsmal.filling.convolved import ConvolvedModel
from corsmal.filling.inputs import checked_mask
from corsmal.filling.pooled import PooledModel
from corsmal.filling.records import LEVEL_NAMES, TYPE_NAMES
from corsmal.filling.recurrent import RecurrentModel

KERNEL = 5
KERNEL_NOISE = 0.02
"""Deviation of the random part of the first kernels, whose middle is 1."""

PROBABILITY_MIN = 1e-12
"""The smallest probability whose logarithm is stored."""

DEVIATION_MIN = 1e-6
"""A feature with a smaller deviation counts as one that never changes."""


class CNNEncoder(nn.Module):
    """A depthwise 5×5 convolution, then a pointwise one to a single channel (paper 2.1).

    The plain form starts near the mean of the channels: random kernels blur the features and leave them smaller than
    the positions, and some trainings never took off.
    """

    def __init__(self, config: FillingConfig) -> None:
        super().__init__()
        channels, is_plain = config.channels, config.encoder == "plain"
        wide = channels if is_plain else 2 * channels
        self.norm = None if is_plain else nn.BatchNorm1d(channels)
        self.depthwise = nn.Conv2d(channels, wide, KERNEL, padding=KERNEL // 2, groups=channels)
        self.pointwise = nn.Linear(wide, 1)
        if is_plain:
            self._start_near_the_mean(channels)

    @torch.no_grad()
    def _start_near_the_mean(self, channels: int) -> None:
        nn.init.dirac_(self.depthwise.weight, groups=channels)
        self.depthwise.weight += KERNEL_NOISE * torch.randn_like(self.depthwise.weight)
        nn.init.constant_(self.pointwise.weight, 1 / channels)
        for layer in ("depthwise", "pointwise"):
            nn.init.zeros_(self.get_parameter(f"{layer}.bias"))

    def forward(self, x: Tensor, mask: Tensor) -> Tensor:
        """(B, C, T, features) to (B, T, features); ``mask`` (B, T) is true on a recording's own rows."""
        if self.norm is None:
            return self._convolved(x)
        rows = x.transpose(1, 2)  # (B, T, C, features)
        normalised = torch.zeros_like(rows)
        normalised[mask] = self.norm(rows[mask]).relu()  # of (rows, C, features); zeros beyond the end
        return self._convolved(normalised.transpose(1, 2)).relu()

    def _convolved(self, x: Tensor) -> Tensor:
        encoded: Tensor = self.pointwise(self.depthwise(x).movedim(1, 3))  # (B, T, features, 1)
        return encoded[..., 0]


class SquaredReLU(nn.Module):
    """The square of what is positive, and zero."""

    def forward(self, x: Tensor) -> Tensor:
        """Of any shape."""
        return x.relu().square()


class Block(nn.Module):
    """Self-attention and two FC layers, each with a shortcut, each behind a LayerNorm (paper 2.2)."""

    def __init__(self, config: FillingConfig) -> None:
        super().__init__()
        self.norm_attention = nn.LayerNorm(config.features)
        self.attention = nn.MultiheadAttention(config.features, config.heads, batch_first=True)
        self.norm_layers = None if config.norms == "shared" else nn.LayerNorm(config.features)
        self.layers = nn.Sequential(
            nn.Linear(config.features, config.hidden),
            nn.GELU() if config.activation == "gelu" else SquaredReLU(),
            nn.Dropout(config.dropout),
            nn.Linear(config.hidden, config.features),
        )
        self.dropout = nn.Dropout(config.dropout)

    def forward(self, x: Tensor, padding: Tensor | None, *, cls_only: bool = False) -> tuple[Tensor, Tensor | None]:
        """One block, from (B, T + 1, features) and ``padding`` (B, T + 1) bool, true on rows that are not attended to.

        None: all are; PyTorch loads half a second of symbolic algebra to check a mask.

        With ``cls_only`` only what becomes of the cls embedding is computed. In the last block, which needs no more, a
        training step without it takes 1.5 times as long (8 × 220–600 × 128 features, a CPU with AVX2 only).

        Returns:
            (B, T + 1, features), or (B, 1, features) with the (B, 1, T + 1) weights of its attention, mean over heads.
        """
        keys = self.norm_attention(x)
        queries, x = (keys[:, :1], x[:, :1]) if cls_only else (keys, x)
        attended, weights = self.attention(queries, keys, keys, key_padding_mask=padding, need_weights=cls_only)
        x = x + self.dropout(attended)
        norm = self.norm_layers or self.norm_attention
        return x + self.dropout(self.layers(norm(x))), weights


class FillingModel(nn.Module):
    """Features of recordings to the logits of filling type and level (paper 2, figure 1).

    Args:
        config: its sizes.

    Example:
        >>> model = FillingModel(FillingConfig.paper(channels=1)).eval()
        >>> types, levels = model(torch.rand(2, 1, 30, 128))
        >>> types.shape, levels.shape
        (torch.Size([2, 4]), torch.Size([2, 3]))
    """

    feature_mean: Tensor
    feature_std: Tensor
    duration_mean: Tensor
    duration_std: Tensor

    def __init__(self, config: FillingConfig) -> None:
        super().__init__()
        self.config = config
        self.register_buffer("feature_mean", torch.zeros(config.features))
        self.register_buffer("feature_std", torch.ones(config.features))
        self.register_buffer("duration_mean", torch.zeros(()))
        self.register_buffer("duration_std", torch.ones(()))
        if config.positions == "first":
            self.register_buffer("first_position", sinusoidal_positions(1, config.features)[0])
        self.cnn = CNNEncoder(config)
        self.cls = nn.Parameter(torch.randn(config.features) * 0.02)
        self.blocks = nn.ModuleList(Block(config) for _ in range(config.blocks))
        self.type_head = self._head(len(TYPE_NAMES))
        self.level_head = self._head(len(LEVEL_NAMES))

    def _head(self, classes: int) -> nn.Sequential:
        given = self.config.features + self.config.duration_input
        hidden = self.config.head_hidden
        activation = nn.GELU() if self.config.activation == "gelu" else nn.ReLU()
        return nn.Sequential(
            nn.Linear(given, hidden), activation, nn.Dropout(self.config.dropout), nn.Linear(hidden, classes)
        )

    def learn_statistics(self, recordings: Sequence[NDArray[np.float32]]) -> None:
        """Take the means and deviations of features and log T from the recordings, (C, T, features) each."""
        durations = np.log([features.shape[1] for features in recordings])
        self._take("duration", durations.mean(), durations.std())
        if self.config.standardise:
            rows = sum(features.shape[0] * features.shape[1] for features in recordings)
            sums = [features.sum(axis=(0, 1), dtype=np.float64) for features in recordings]
            mean = np.sum(sums, axis=0) / rows
            squares = [((features - mean) ** 2).sum(axis=(0, 1)) for features in recordings]
            self._take("feature", mean, np.sqrt(np.sum(squares, axis=0) / rows))

    def _take(self, name: str, mean: NDArray[np.float64], deviation: NDArray[np.float64]) -> None:
        """What never changes is left as large as it is."""
        self.get_buffer(f"{name}_mean").copy_(torch.as_tensor(mean))
        self.get_buffer(f"{name}_std").copy_(torch.as_tensor(np.where(deviation > DEVIATION_MIN, deviation, 1.0)))

    def forward(self, features: Tensor, mask: Tensor | None = None) -> tuple[Tensor, Tensor]:
        """The logits of a batch.

        Args:
            features: (B, C, T, features) float32; rows beyond a recording's end may hold anything finite.
            mask: (B, T) bool, true on a recording's own rows, which come first; default: all are.

        Returns:
            (B, 4) type logits and (B, 3) level logits, before the softmax.

        Raises:
            ArgumentError: the arrays have other shapes, or a recording has no rows.
        """
        types, levels, _ = self.explain(features, mask)
        return types, levels

    def explain(self, features: Tensor, mask: Tensor | None = None) -> tuple[Tensor, Tensor, Tensor]:
        """``forward``, and what the cls embedding attends to.

        Returns:
            (B, 4), (B, 3) and (B, T): the attention of the last block, mean over heads, without what the embedding
            pays to itself; sums to 1 over T.
        """
        mask = checked_mask(features, mask, channels=self.config.channels, width=self.config.features)
        x = (features - self.feature_mean) / self.feature_std if self.config.standardise else features
        is_full = bool(mask.all())
        x = x if is_full else x * mask[:, None, :, None]  # zeros beyond the end, as the convolution's own padding
        x = self.cnn(x, mask)
        x = torch.cat([self.cls.expand(len(x), 1, -1), x], dim=1)  # (B, T + 1, features)
        x = x + self._positions(x)
        padding = None if is_full else torch.cat([mask.new_zeros(len(mask), 1), ~mask], dim=1)  # (B, T + 1)
        for block in self.blocks[:-1]:
            x, _ = block(x, padding)
        x, weights = self.blocks[-1](x, padding, cls_only=True)  # (B, 1, features), (B, 1, T + 1)
        z = x[:, 0]
        if self.config.duration_input:
            durations = (mask.sum(dim=1).log() - self.duration_mean) / self.duration_std
            z = torch.cat([z, durations[:, None]], dim=1)
        attention = weights[:, 0, 1:]
        return self.type_head(z), self.level_head(z), attention / attention.sum(dim=1, keepdim=True)

    def _positions(self, x: Tensor) -> Tensor:
        if self.config.positions == "first":
            return self.get_buffer("first_position")
        return sinusoidal_positions(x.shape[1], x.shape[2]).to(x)


def sinusoidal_positions(length: int, width: int) -> Tensor:
    """(length, width) P[p, 2i] = sin(p / 10000^(2i / width)), P[p, 2i + 1] = the cosine of the same (paper 2.2)."""
    rates = torch.exp(torch.arange(0, width, 2) * (-math.log(10_000) / width))
    angles = torch.arange(length)[:, None] * rates  # (length, width / 2)
    return torch.stack([angles.sin(), angles.cos()], dim=-1).flatten(1)


AnyModel = FillingModel | RecurrentModel | ConvolvedModel | PooledModel


def build_model(config: AnyConfig) -> AnyModel:
    """The network of a config, with its first weights."""
    if isinstance(config, FillingConfig):
        return FillingModel(config)
    if isinstance(config, RecurrentConfig):
        return RecurrentModel(config)
    return ConvolvedModel(config) if isinstance(config, ConvolvedConfig) else PooledModel(config)


def config_of(content: Mapping[str, Any]) -> AnyConfig:
    """The config that a file holds."""
    kinds: dict[str, type[AnyConfig]] = {
        "recurrent": RecurrentConfig,
        "convolved": ConvolvedConfig,
        "pooled": PooledConfig,
    }
    return kinds[content["network"]](**content) if "network" in content else FillingConfig(**content)


def mean_logits(logits: Sequence[Tensor]) -> Tensor:
    """(B, classes) logits of several networks as one: logarithms of their mean probabilities; a single one's own."""
    if len(logits) == 1:
        return logits[0]
    return torch.stack(tuple(logits)).softmax(dim=-1).mean(dim=0).clamp_min(PROBABILITY_MIN).log()
