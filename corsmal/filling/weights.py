"""Weights of the filling network in a file: one model, or several whose probabilities are averaged."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import safetensors
import safetensors.torch
import torch

from corsmal.errors import ArgumentError, FileError
from corsmal.files import writing
from corsmal.filling.config import FillingConfig
from corsmal.filling.network import FillingModel

MODELS_MAX = 8
"""More models than this in one file make a prediction slow and hardly better."""

ADVICE = "train one with `python -m corsmal train filling`, or take the file that came along"


def save_filling(path: Path, models: Sequence[FillingModel]) -> None:
    """Write the weights of up to eight models, with their configs beside them.

    Args:
        path: the file, ``.safetensors``.
        models: they must expect the same channels and features and read their answers alike.

    Raises:
        ArgumentError: there is none, there are too many, or they do not belong together.
        FileError: the file cannot be written.
    """
    check_together([model.config for model in models])
    state = {
        f"{index}.{name}": value.detach().cpu().contiguous()
        for index, model in enumerate(models)
        for name, value in model.state_dict().items()
    }
    configs = json.dumps([asdict(model.config) for model in models])
    with writing(path, advice="choose another folder", errors=(safetensors.SafetensorError,)) as part:
        safetensors.torch.save_file(state, part, {"filling": configs})


def read_filling(path: Path) -> list[FillingModel]:
    """The models of a file that ``save_filling`` wrote, ready to predict.

    Raises:
        FileError: the file is absent, broken, holds something else, or holds weights that are not finite.
    """
    try:
        with safetensors.safe_open(path, "pt") as file:
            configs = [FillingConfig(**config) for config in json.loads(file.metadata()["filling"])]
            state = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - not a mapping
        check_together(configs)
    except (OSError, safetensors.SafetensorError, AttributeError, KeyError, TypeError, ValueError) as error:
        raise FileError(path, f"is no file of the filling network's weights; {ADVICE}") from error
    if not all(torch.isfinite(value).all() for value in state.values()):
        raise FileError(path, f"holds weights that are not finite; {ADVICE}")
    models = [FillingModel(config).eval() for config in configs]
    try:
        torch.nn.ModuleList(models).load_state_dict(state)
    except RuntimeError as error:
        raise FileError(path, f"holds weights that do not fit the sizes it names; {ADVICE}") from error
    return models


def check_together(configs: Sequence[FillingConfig]) -> None:
    """Whether one file may hold models of these configs.

    Raises:
        ArgumentError: there is none, there are too many, or they differ in what they expect or how they are read.
    """
    if not 1 <= len(configs) <= MODELS_MAX:
        raise ArgumentError(f"models must be 1 to {MODELS_MAX}, got {len(configs)}")
    kinds = {(config.channels, config.features, config.decoding) for config in configs}
    if len(kinds) > 1:
        raise ArgumentError(f"models must agree on channels, features and decoding, got {sorted(kinds)}")
