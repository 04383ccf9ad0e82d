"""The container mass of a reproduction: predictions by networks that have not seen the recording, and the final one."""

from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from corsmal.dataset import TrainedOn
from corsmal.files import writing
from corsmal.runs.reproduction_settings import ReproductionSettings
from corsmal.stages.version import METHOD_VERSION
from corsmal.store import digest

if TYPE_CHECKING:
    from corsmal.mass import MassRow

KEY_DIGITS = 12


def mass_predictions(
    rows: "Sequence[MassRow]",
    settings: ReproductionSettings,
    folder: Path,
    *,
    table: pd.DataFrame,
    trained_on: TrainedOn,
    progress: Callable[[float], None],
) -> pd.DataFrame:
    """The mass of every recording that a network may be judged by, kept in a file beside the networks.

    Args:
        rows: masks and dimensions of the recordings whose mass is annotated.
        settings: the reproduction's.
        folder: gets a folder for these rows and settings.
        table: of the dataset, with ``container_id``.
        trained_on: the dataset's recordings.
        progress: called with the share that is done.

    Returns:
        As ``cross_validate_mass``; under the paper's protocol only the recordings by which training was stopped.

    Raises:
        ArgumentError: there are too few recordings.
        FileError: the folder cannot be written.
    """
    key = digest("mass", METHOD_VERSION, settings.mass, settings.folds, settings.seeds, identity_of(rows))
    folder = folder / f"{settings.protocol}-{key[:KEY_DIGITS]}"
    kept = folder / "predictions.csv"
    if not kept.is_file():
        if settings.protocol == "paper":
            found = _validated_share(rows, settings, folder, trained_on=trained_on, progress=progress)
        else:
            found = _out_of_fold(rows, settings, folder, table=table, trained_on=trained_on, progress=progress)
        with writing(kept, advice="choose another folder") as part:
            found.to_csv(part, index=False)
    return pd.read_csv(kept, dtype={"recording_id": "str", "reason": "str"}).fillna({"reason": ""})


def final_mass_network(
    rows: "Sequence[MassRow]", folder: Path, settings: ReproductionSettings, *, trained_on: TrainedOn
) -> Path:
    """The weights of the network that is trained on all recordings; not trained again where they are there.

    Raises:
        ArgumentError: there are too few recordings.
        FileError: the folder cannot be written.
    """
    from corsmal.mass import train_mass  # noqa: PLC0415 - loads PyTorch

    path = folder / "mass.safetensors"
    return path if path.is_file() else train_mass(rows, folder, settings.mass, trained_on=trained_on).path


def identity_of(rows: "Sequence[MassRow]") -> str:
    """A digest of what a mass network is given."""
    return digest([[getattr(row, field.name) for field in fields(row)] for row in rows])


def _out_of_fold(
    rows: "Sequence[MassRow]",
    settings: ReproductionSettings,
    folder: Path,
    *,
    table: pd.DataFrame,
    trained_on: TrainedOn,
    progress: Callable[[float], None],
) -> pd.DataFrame:
    from corsmal.mass.crossvalidation import (  # noqa: PLC0415 - as above
        cross_validate_mass,
        mass_folds_by_container,
        spread_mass_folds,
    )

    by_container = settings.folds == "containers"
    return cross_validate_mass(
        folder,
        rows,
        folds=mass_folds_by_container(rows, table) if by_container else spread_mass_folds(rows),
        training=settings.mass,
        seeds=range(settings.seeds),
        trained_on=trained_on,
        progress=progress,
    )


def _validated_share(
    rows: "Sequence[MassRow]",
    settings: ReproductionSettings,
    folder: Path,
    *,
    trained_on: TrainedOn,
    progress: Callable[[float], None],
) -> pd.DataFrame:
    from corsmal.mass import MassPredictor, train_mass  # noqa: PLC0415 - as above
    from corsmal.mass.crossvalidation import judge_validation  # noqa: PLC0415 - as above

    parts = []
    for seed in range(settings.seeds):
        training = replace(settings.mass, seed=seed)
        trained = train_mass(rows, folder / f"seed{seed}", training, trained_on=trained_on)
        parts.append(judge_validation(MassPredictor(trained.path), rows, training).assign(fold=0, seed=seed))
        progress((seed + 1) / settings.seeds)
    return pd.concat(parts, ignore_index=True)
