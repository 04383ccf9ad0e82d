"""The sizes and forms of the filling networks: the paper's with its presets and its authors', and three for arrays."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, get_args

from corsmal.errors import ArgumentError, check_choice
from corsmal.fields import UNLESS_DEFAULT
from corsmal.filling.records import Decoding

FrontEnd = Literal["paper", "released"]
"""How sound becomes features, see ``LogMelParameters.of``."""

Encoder = Literal["plain", "normalised"]
"""``normalised``: features pass a batch norm of each channel and a ReLU first, the depthwise convolution doubles the
channels, and what is encoded passes a ReLU (the authors' program)."""

Positions = Literal["sequence", "first"]
"""``first``: every row and the class embedding get the first position, so that their order is not known. The authors'
program looks positions up by the recording's place in the batch."""

Norms = Literal["two", "shared"]
"""The LayerNorms of a block: one before attention and one before its FC layers, or the same one (the authors')."""

Activation = Literal["gelu", "squared relu"]
"""Between the FC layers of a block; the heads have GELU, or with ``squared relu`` a plain ReLU (the authors')."""

FORMS = {
    "front_end": FrontEnd,
    "encoder": Encoder,
    "positions": Positions,
    "norms": Norms,
    "activation": Activation,
    "decoding": Decoding,
}
"""The choices among forms, by the field of the config."""

MODELS_MAX = 8
"""More models than this in one file make a prediction slow and hardly better."""


@dataclass(frozen=True)
class FillingConfig:
    """Sizes of the network, what it is given, and how its answer is read.

    Args:
        channels: C, channels of the features: 8 microphones, or 1 for features that were mixed before.
        features: features per row: N_mel of Table 1, and the width of the Transformer.
        heads: of each block's self-attention.
        blocks: encoder blocks.
        hidden: width between the two FC layers of a block.
        head_hidden: width between the two FC layers of a classification head.
        dropout: of what attention and FC layers give, while training.
        duration_input: whether the heads are also given log T.
        standardise: whether features are standardised, each of the ``features`` by its mean and deviation in training.
        decoding: how type and level are read off the two heads' probabilities.
        front_end: how sound becomes the features.
        encoder: the convolutions and what is around them.
        positions: what is added to the rows, so that their order is known.
        norms: of a block.
        activation: between two FC layers.

    Raises:
        ArgumentError: a size is not a positive whole number, or they do not fit together.
    """

    channels: int = 8
    features: int = 128
    heads: int = 4
    blocks: int = 3
    hidden: int = 256
    head_hidden: int = 64
    dropout: float = 0.1
    duration_input: bool = False
    standardise: bool = True
    decoding: Decoding = "independent"
    front_end: FrontEnd = field(default="paper", metadata=UNLESS_DEFAULT)
    encoder: Encoder = field(default="plain", metadata=UNLESS_DEFAULT)
    positions: Positions = field(default="sequence", metadata=UNLESS_DEFAULT)
    norms: Norms = field(default="two", metadata=UNLESS_DEFAULT)
    activation: Activation = field(default="gelu", metadata=UNLESS_DEFAULT)

    def __post_init__(self) -> None:
        for name in ("channels", "features", "heads", "blocks", "hidden", "head_hidden"):
            size = getattr(self, name)
            if type(size) is not int or size < 1:
                raise ArgumentError(f"{name} must be a positive whole number, got {size!r}")
        if self.features % self.heads or self.features % 2:
            raise ArgumentError(f"features must be even and a multiple of heads, got {self.features} and {self.heads}")
        if not (isinstance(self.dropout, float | int) and 0 <= self.dropout < 1):
            raise ArgumentError(f"dropout must lie in 0..1, got {self.dropout!r}")
        for name in ("duration_input", "standardise"):
            if type(getattr(self, name)) is not bool:
                raise ArgumentError(f"{name} must be true or false, got {getattr(self, name)!r}")
        for name, choices in FORMS.items():
            check_choice(name, getattr(self, name), get_args(choices))

    @classmethod
    def paper(cls, *, channels: int = 8) -> "FillingConfig":
        """The paper's network.

        Features are taken as they are: with standardised ones, which make columns loud that are all but silent, the
        network memorised the levels of the training containers in each of the winners' folds.
        """
        return cls(channels=channels, dropout=0.3, standardise=False)

    @classmethod
    def tuned(cls, *, channels: int = 8, standardise: bool = False) -> "FillingConfig":
        """The same layers; the heads know the duration, and only pairs that exist are answered."""
        return cls(channels=channels, duration_input=True, standardise=standardise, decoding="feasible")

    @classmethod
    def released(cls, *, channels: int = 8) -> "FillingConfig":
        """The network of the authors' program, where it does otherwise than the paper and where the paper is silent."""
        return cls(
            channels=channels,
            head_hidden=32,
            dropout=0.05,
            standardise=False,
            front_end="released",
            encoder="normalised",
            positions="first",
            norms="shared",
            activation="squared relu",
        )


class _OfArrays:
    @property
    def front_end(self) -> FrontEnd:
        """Of the log-mel rows that the network may be given."""
        return "paper"


@dataclass(frozen=True)
class RecurrentConfig(_OfArrays):
    """Sizes of the recurrent network and how its answer is read.

    Args:
        channels: C, microphones or views.
        features: features per row.
        hidden: states of the GRU, in each direction.
        both_ways: whether a second GRU reads the rows from the end.
        dropout: of the normalised features and of what the heads are given, while training.
        decoding: how type and level are read off the two heads' probabilities.
        network: names this kind of network in files.

    Raises:
        ArgumentError: a size is not a positive whole number, or a choice is unknown.
    """

    channels: int = 1
    features: int = 128
    hidden: int = 64
    both_ways: bool = True
    dropout: float = 0.3
    decoding: Decoding = "feasible"
    network: Literal["recurrent"] = "recurrent"

    def __post_init__(self) -> None:
        _check_sizes(self)
        if type(self.both_ways) is not bool:
            raise ArgumentError(f"both_ways must be true or false, got {self.both_ways!r}")
        check_choice("network", self.network, ("recurrent",))


@dataclass(frozen=True)
class ConvolvedConfig(_OfArrays):
    """Sizes of the convolutional network and how its answer is read.

    Args:
        channels: C, microphones or views.
        features: features per row.
        hidden: outputs of each convolution.
        layers: convolutions.
        kernel: rows that one of them sees, an odd number.
        dropout: of the normalised features and of what the heads are given, while training.
        decoding: how type and level are read off the two heads' probabilities.
        network: names this kind of network in files.

    Raises:
        ArgumentError: a size is not a positive whole number, or a choice is unknown.
    """

    channels: int = 1
    features: int = 128
    hidden: int = 64
    layers: int = 2
    kernel: int = 3
    dropout: float = 0.3
    decoding: Decoding = "feasible"
    network: Literal["convolved"] = "convolved"

    def __post_init__(self) -> None:
        _check_sizes(self, "layers", "kernel")
        if not self.kernel % 2:
            raise ArgumentError(f"kernel must be odd, got {self.kernel}")
        check_choice("network", self.network, ("convolved",))


@dataclass(frozen=True)
class PooledConfig(_OfArrays):
    """Sizes of the network on changes over time and how its answer is read.

    Args:
        channels: C, views.
        features: features per row.
        hidden: width between the two FC layers.
        dropout: of the statistics and of what the heads are given, while training.
        decoding: how type and level are read off the two heads' probabilities.
        network: names this kind of network in files.

    Raises:
        ArgumentError: a size is not a positive whole number, or a choice is unknown.
    """

    channels: int = 3
    features: int = 512
    hidden: int = 64
    dropout: float = 0.5
    decoding: Decoding = "feasible"
    network: Literal["pooled"] = "pooled"

    def __post_init__(self) -> None:
        _check_sizes(self)
        check_choice("network", self.network, ("pooled",))


AnyConfig = FillingConfig | RecurrentConfig | ConvolvedConfig | PooledConfig


def _check_sizes(config: RecurrentConfig | ConvolvedConfig | PooledConfig, *further: str) -> None:
    for name in ("channels", "features", "hidden", *further):
        size = getattr(config, name)
        if type(size) is not int or size < 1:
            raise ArgumentError(f"{name} must be a positive whole number, got {size!r}")
    if not (isinstance(config.dropout, float | int) and 0 <= config.dropout < 1):
        raise ArgumentError(f"dropout must lie in 0..1, got {config.dropout!r}")
    check_choice("decoding", config.decoding, get_args(Decoding))


def check_together(configs: Sequence[AnyConfig]) -> None:
    """Whether one file may hold models of these configs.

    Raises:
        ArgumentError: there is none, there are too many, or they differ in what they expect or how they are read.
    """
    if not 1 <= len(configs) <= MODELS_MAX:
        raise ArgumentError(f"models must be 1 to {MODELS_MAX}, got {len(configs)}")
    kinds = {(config.channels, config.features, config.front_end, config.decoding) for config in configs}
    if len(kinds) > 1:
        raise ArgumentError(f"models must agree on channels, features, front end and decoding, got {sorted(kinds)}")
