"""Files of the mass network's weights: the library's own, and the authors'."""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from corsmal.mass.network import MassConfig, MassModel
from corsmal.mass.released import read_released
from corsmal.state_dicts import is_state_dict
from corsmal.weights import read_network, save_network


def save_mass(path: Path, model: MassModel, *, training: Mapping[str, Any] | None = None) -> None:
    """Write a model's weights in half precision, its statistics, its config and what it was trained on.

    Raises:
        FileError: the file cannot be written.
    """
    save_network(path, model, kind="mass", config=asdict(model.config), training=training, half=True)


def read_mass(path: Path) -> MassModel:
    """The model of a file that ``save_mass`` wrote, or of the authors' file, ready to predict.

    Raises:
        FileError: the file is absent, broken, holds something else, or holds weights that are not finite.
    """
    if is_state_dict(path):
        return read_released(path)
    return read_network(path, "mass", lambda config: MassModel(MassConfig(**config)))
