"""The fused filling network in one file: networks of sound, networks of sight, and the gate between them."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, get_args

from torch import Tensor, nn

from corsmal.errors import ArgumentError, check_choice
from corsmal.filling.config import MODELS_MAX, AnyConfig, PooledConfig, check_together
from corsmal.filling.fusion import SENSES, Answer, FusionGate, GateForm, Sense
from corsmal.filling.network import build_model, config_of, mean_logits
from corsmal.state_dicts import is_state_dict
from corsmal.weights import read_metadata, read_network, save_network


@dataclass(frozen=True)
class FusedConfig:
    """Sizes of the networks of both senses, and the gate between them.

    Args:
        sound: a config per network of sound.
        sight: a config per network of sight, which recognises the container's kind; together at most ``MODELS_MAX``.
        gate: see ``FusionGate``; older files have the default and do not name it.

    Raises:
        ArgumentError: there are too many, those of one sense do not belong together, or there is no such gate.
    """

    sound: tuple[AnyConfig, ...]
    sight: tuple[AnyConfig, ...]
    gate: GateForm = "kinds"

    def __post_init__(self) -> None:
        check_choice("gate", self.gate, get_args(GateForm))
        for configs in (self.sound, self.sight):
            check_together(configs)
        if not all(isinstance(config, PooledConfig) for config in self.sight):
            raise ArgumentError(f"sight must have networks that recognise the container's kind, got {self.sight}")
        if len(self.sound) + len(self.sight) > MODELS_MAX:
            raise ArgumentError(f"sound and sight must have at most {MODELS_MAX} networks together, got {self}")


class FusedModel(nn.Module):
    """Networks of sound and of sight, the probabilities of each sense averaged, and the gate.

    Args:
        config: their sizes.
    """

    def __init__(self, config: FusedConfig) -> None:
        super().__init__()
        self.config = config
        self.sound = nn.ModuleList(map(build_model, config.sound))
        self.sight = nn.ModuleList(map(build_model, config.sight))
        self.gate = FusionGate(config.gate)

    def forward(self, sound: Tensor | None, sight: Tensor | None) -> tuple[Tensor, Tensor, Tensor]:
        """Logits of type and level and the share of sight in the level, see ``FusionGate.forward``.

        Args:
            sound: (B, C, T, features) of sound; None: it is missing.
            sight: (B, views, T, features) of sight; None: it is missing.
        """
        types, levels, share = self.gate(
            None if sound is None else self.answer("sound", sound),
            None if sight is None else self.answer("sight", sight),
        )
        return types, levels, share

    def answer(self, sense: Sense, features: Tensor) -> Answer:
        """What the networks of one sense say about features as in ``forward``."""
        networks = getattr(self, sense)
        heads = zip(*(model.seen(features) if sense == "sight" else model(features) for model in networks), strict=True)
        return Answer(*(mean_logits(logits).log_softmax(dim=1) for logits in heads))


def save_fused(path: Path, model: FusedModel, *, training: Mapping[str, Any] | None = None) -> None:
    """Write the networks and the gate in one file, with their config and what they were trained on.

    Raises:
        FileError: the file cannot be written.
    """
    save_network(path, model, kind="filling", config={"fused": asdict(model.config)}, training=training)


def read_fused(path: Path) -> FusedModel:
    """The model of a file that ``save_fused`` wrote, ready to predict.

    Raises:
        FileError: the file is absent, broken, holds something else, or holds weights that are not finite.
    """

    def build(content: Mapping[str, Mapping[str, Any]]) -> FusedModel:
        sizes = dict(content["fused"])
        sound, sight = (tuple(map(config_of, sizes.pop(sense))) for sense in SENSES)
        return FusedModel(FusedConfig(sound, sight, **sizes))

    return read_network(path, "filling", build)


def is_fused(path: Path) -> bool:
    """Whether a file of filling weights holds a fused network.

    Raises:
        FileError: the file is absent, broken, or of another network.
    """
    return not is_state_dict(path) and isinstance(read_metadata(path, "filling")[0], Mapping)
