"""Container mass from the restored mask and the dimensions (paper 3.3).

PyTorch is imported only when something is asked for that needs it.
"""

import importlib
from typing import TYPE_CHECKING, Any

from corsmal.mass.axis import Axis, AxisRule
from corsmal.mass.physics import filling_mass_g, mm_per_pixel
from corsmal.mass.records import MassPrediction, MassRow, RestoredMask
from corsmal.mass.restoration import restore_mask

if TYPE_CHECKING:
    from corsmal.mass.network import MassConfig, MassModel, read_mass, save_mass
    from corsmal.mass.prediction import MassPredictor
    from corsmal.mass.training import MassTraining, train_mass

__all__ = [
    "Axis",
    "AxisRule",
    "MassConfig",
    "MassModel",
    "MassPrediction",
    "MassPredictor",
    "MassRow",
    "MassTraining",
    "RestoredMask",
    "filling_mass_g",
    "mm_per_pixel",
    "read_mass",
    "restore_mask",
    "save_mass",
    "train_mass",
]

_FILES = {
    "network": ("MassConfig", "MassModel", "read_mass", "save_mass"),
    "prediction": ("MassPredictor",),
    "training": ("MassTraining", "train_mass"),
}


def __getattr__(name: str) -> Any:
    for file, names in _FILES.items():
        if name in names:
            return getattr(importlib.import_module(f"corsmal.mass.{file}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
