"""Files of the filling network's weights: the library's own, and the authors'."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from torch import nn

from corsmal.filling.config import check_together
from corsmal.filling.network import AnyModel, build_model, config_of
from corsmal.filling.released import read_released
from corsmal.state_dicts import is_state_dict
from corsmal.weights import read_network, save_network


def save_filling(path: Path, models: Sequence[AnyModel], *, training: Mapping[str, Any] | None = None) -> None:
    """Write up to eight models, whose probabilities are averaged, with their configs and what they were trained on.

    They must expect the same channels and features and read their answers alike.

    Raises:
        ArgumentError: there is none, there are too many, or they do not belong together.
        FileError: the file cannot be written.
    """
    configs = [model.config for model in models]
    check_together(configs)
    save_network(path, nn.ModuleList(models), kind="filling", config=list(map(asdict, configs)), training=training)


def read_filling(path: Path) -> list[AnyModel]:
    """The models of a file that ``save_filling`` wrote, or the one of the authors' file, ready to predict.

    Raises:
        FileError: the file is absent, broken, holds something else, or holds weights that are not finite.
    """
    if is_state_dict(path):
        return [read_released(path)]

    def build(contents: Sequence[dict[str, Any]]) -> nn.ModuleList:
        configs = list(map(config_of, contents))
        check_together(configs)
        return nn.ModuleList(map(build_model, configs))

    return [model for model in read_network(path, "filling", build) if isinstance(model, AnyModel)]
