"""Weights of the mass network in a file."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

from corsmal.errors import FileError
from corsmal.mass.network import MassConfig, MassModel
from corsmal.weights import read_network, save_network

KIND = "mass"
ADVICE = "train one with `python -m corsmal train mass`, or take the file that came along"


def save_mass(path: Path, model: MassModel) -> None:
    """Write a model's weights, in half precision, its statistics and its config.

    Raises:
        FileError: the file cannot be written.
    """
    save_network(path, model, kind=KIND, config=asdict(model.config), half=True)


def read_mass(path: Path) -> MassModel:
    """The model of a file that ``save_mass`` wrote, ready to predict.

    Raises:
        FileError: the file is absent, broken, holds something else, or holds weights that are not finite.
    """
    content, state = read_network(path, kind=KIND, advice=ADVICE)
    try:
        model = MassModel(MassConfig(**{name: _tuple(value) for name, value in content.items()}))
    except (TypeError, ValueError) as error:
        raise FileError(path, f"is no file of the {KIND} network's weights; {ADVICE}") from error
    try:
        model.load_state_dict(state)
    except RuntimeError as error:
        raise FileError(path, f"holds weights that do not fit the sizes it names; {ADVICE}") from error
    return model.eval()


def _tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value
