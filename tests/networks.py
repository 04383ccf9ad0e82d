"""Networks that were not trained: as files, and in place of training where that is not what a test is about."""

from pathlib import Path
from typing import Any

import torch

from corsmal.filling import FillingConfig, FillingModel, save_filling
from corsmal.filling.network import build_model
from corsmal.mass import MassConfig, MassModel, save_mass


def write_networks(folder: Path, *, training: dict[str, Any] | None = None) -> dict[str, Path]:
    """Files of a filling and a mass network, of the paper's sizes; the masses lie near the mean of two."""
    torch.manual_seed(0)
    paths = {name: folder / f"{name}.safetensors" for name in ("filling", "mass")}
    save_filling(paths["filling"], [FillingModel(FillingConfig.paper()).eval()], training=training)
    mass = MassModel(MassConfig.paper()).eval()
    mass.learn_statistics(torch.tensor([[98.0, 61.0, 119.0], [60.0, 40.0, 200.0]]), torch.tensor([134.0, 60.0]))
    save_mass(paths["mass"], mass, training=training)
    return paths


def untrained_filling(folder: Path, samples: Any, *, training: Any, index: int, seed: int, **_options: Any) -> Any:
    """In place of ``corsmal.filling.loop.fit_network``: the first weights, which follow from seed and index."""
    torch.manual_seed(10 * seed + index)
    network = build_model(training.networks[index])
    network.learn_statistics([sample.features for sample in samples])
    folder.mkdir(parents=True, exist_ok=True)
    save_filling(folder / "network.safetensors", [network.eval()])
    return network


def untrained_mass(module: Any, _folder: Path, _training: Any) -> tuple[float, int]:
    """In place of ``corsmal.mass.training._fit``: the first weights, which follow from the seed."""
    module.network.eval()
    return 1.0, 1
