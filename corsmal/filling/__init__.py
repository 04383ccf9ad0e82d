"""Filling type and level from sound: log-mel, the shared network, its training and its predictions (paper 2).

PyTorch is imported only when something is asked for that needs it.
"""

import importlib
from typing import TYPE_CHECKING, Any

from corsmal.filling.records import FEASIBLE_PAIRS, LEVEL_NAMES, TYPE_NAMES, Decoding, FillingPrediction, decode

if TYPE_CHECKING:
    from corsmal.filling.config import FillingConfig
    from corsmal.filling.crossvalidation import cross_validate
    from corsmal.filling.folds import WINNERS_FOLDS, folds_by_container, spread_folds
    from corsmal.filling.frontend import LogMelParameters, log_mel
    from corsmal.filling.network import FillingModel, read_filling, save_filling
    from corsmal.filling.prediction import FillingPredictor
    from corsmal.filling.recipe import FillingTraining
    from corsmal.filling.samples import FillingSample, filling_samples
    from corsmal.filling.training import train_filling

__all__ = [
    "FEASIBLE_PAIRS",
    "LEVEL_NAMES",
    "TYPE_NAMES",
    "WINNERS_FOLDS",
    "Decoding",
    "FillingConfig",
    "FillingModel",
    "FillingPrediction",
    "FillingPredictor",
    "FillingSample",
    "FillingTraining",
    "LogMelParameters",
    "cross_validate",
    "decode",
    "filling_samples",
    "folds_by_container",
    "log_mel",
    "read_filling",
    "save_filling",
    "spread_folds",
    "train_filling",
]

_FILES = {
    "crossvalidation": ("cross_validate",),
    "folds": ("WINNERS_FOLDS", "folds_by_container", "spread_folds"),
    "frontend": ("LogMelParameters", "log_mel"),
    "config": ("FillingConfig",),
    "network": ("FillingModel", "read_filling", "save_filling"),
    "prediction": ("FillingPredictor",),
    "recipe": ("FillingTraining",),
    "samples": ("FillingSample", "filling_samples"),
    "training": ("train_filling",),
}


def __getattr__(name: str) -> Any:
    for file, names in _FILES.items():
        if name in names:
            return getattr(importlib.import_module(f"corsmal.filling.{file}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
