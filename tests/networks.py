"""Networks that have learnt nothing, as files."""

from pathlib import Path
from typing import Any

import torch

from corsmal.filling import FillingConfig, FillingModel, save_filling
from corsmal.mass import MassConfig, MassModel, save_mass


def write_networks(folder: Path, *, training: dict[str, Any] | None = None) -> dict[str, Path]:
    """Files of a filling and a mass network, of the paper's sizes."""
    torch.manual_seed(0)
    paths = {name: folder / f"{name}.safetensors" for name in ("filling", "mass")}
    save_filling(paths["filling"], [FillingModel(FillingConfig.paper()).eval()], training=training)
    save_mass(paths["mass"], MassModel(MassConfig.paper()).eval(), training=training)
    return paths
