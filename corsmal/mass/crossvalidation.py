"""Cross-validation of the mass network: every recording weighed by a network that was not trained on it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from corsmal.dataset import TrainedOn
from corsmal.errors import ArgumentError
from corsmal.mass.judging import judge_mass
from corsmal.mass.prediction import MassPredictor
from corsmal.mass.records import MassRow
from corsmal.mass.samples import held_out
from corsmal.mass.training import MassTraining, train_mass

FOLDS = 5

CONTAINER_GROUPS = ((1, 4, 7), (2, 5, 8), (3, 6, 9))
"""A cup, a glass and a box each."""


def spread_mass_folds(rows: Sequence[MassRow], *, folds: int = FOLDS, seed: int = 0) -> dict[str, int]:
    """Folds, 0 to ``folds`` − 1 by recording id, over which every container's recordings are spread equally.

    Several rows of one recording are in one fold; ``seed`` gives the order in which recordings are dealt.

    Raises:
        ArgumentError: there are fewer than two folds, or fewer recordings than folds.
    """
    recordings = sorted({(row.container, row.recording_id) for row in rows})
    if not 2 <= folds <= len(recordings):
        raise ArgumentError(f"folds must be from 2 to the {len(recordings)} recordings with a known mass, got {folds}")
    rng = np.random.default_rng(seed)
    shuffled = [recordings[index] for index in rng.permutation(len(recordings))]
    return {name: index % folds for index, (_, name) in enumerate(sorted(shuffled, key=lambda pair: pair[0]))}


def mass_folds_by_container(
    rows: Sequence[MassRow], table: pd.DataFrame, *, groups: Sequence[Sequence[int]] = CONTAINER_GROUPS
) -> dict[str, int]:
    """Folds of whole containers, ``groups`` of their ids: each is weighed by a network that has not seen it.

    Returns:
        The position of the container's group, by recording id; containers are looked up in ``table``, such as
        ``Dataset.table``.

    Raises:
        ArgumentError: a container is in no group.
    """
    fold_of = {container: fold for fold, group in enumerate(groups) for container in group}
    known = table["container_id"].to_dict()
    containers = {row.recording_id: known.get(row.recording_id) for row in rows}
    absent = [str(container) for container in containers.values() if container not in fold_of]
    if absent:
        raise ArgumentError(f"groups must hold every container, got none with container {absent[0]}")
    return {name: fold_of[int(str(container))] for name, container in containers.items()}


def cross_validate_mass(
    folder: Path,
    rows: Sequence[MassRow],
    *,
    folds: Mapping[str, int],
    training: MassTraining | None = None,
    seeds: Sequence[int] = (0,),
    trained_on: TrainedOn | None = None,
    progress: Callable[[float], None] | None = None,
) -> pd.DataFrame:
    """Train once per seed and fold, and weigh the fold's recordings; resumed where it was stopped.

    The epoch is chosen by a share of each fold's training recordings, never by those that are then judged.

    Args:
        folder: gets a folder with the training and its weights for each seed and fold.
        rows: all recordings.
        folds: fold by recording id, such as ``spread_mass_folds`` returns.
        training: settings; their seed is replaced by those of ``seeds``, one whole cross-validation each.
        seeds: see ``training``.
        trained_on: all recordings of ``rows``; the weights of each fold keep their part of them.
        progress: called with the fraction that is done, 0..1.

    Returns:
        As ``judge_mass``, with ``fold`` and ``seed``; a row per seed and row of ``rows``.

    Raises:
        ArgumentError: a recording has no fold, there are fewer than two, or a fold leaves too little to train on.
        FileError: the folder cannot be written, or holds a broken file.
    """
    absent = [row.recording_id for row in rows if row.recording_id not in folds]
    if absent:
        raise ArgumentError(f"folds must name a fold for every recording, got none for {absent[0]}")
    numbers = sorted({folds[row.recording_id] for row in rows})
    if len(numbers) < 2:
        raise ArgumentError(f"folds must be two or more, got {len(numbers)}")
    rounds = [(seed, fold) for seed in seeds for fold in numbers]
    parts = []
    for done, (seed, fold) in enumerate(rounds):
        held = [row for row in rows if folds[row.recording_id] == fold]
        others = [row for row in rows if folds[row.recording_id] != fold]
        ids = dict.fromkeys(row.recording_id for row in others)
        trained = train_mass(
            others,
            folder / f"seed{seed}" / f"fold{fold}",
            replace(training or MassTraining(), seed=seed),
            trained_on=None if trained_on is None else trained_on.part(ids, protocol="held-out", fold=fold),
        )
        parts.append(judge_mass(MassPredictor(trained.path), held).assign(fold=fold, seed=seed))
        if progress is not None:
            progress((done + 1) / len(rounds))
    return pd.concat(parts, ignore_index=True)


def judge_validation(predictor: MassPredictor, rows: Sequence[MassRow], training: MassTraining) -> pd.DataFrame:
    """The paper's own protocol: the recordings by which the epoch was chosen are those that are judged (4.2).

    ``predictor`` has the weights that ``train_mass`` wrote for these rows and settings.

    Returns:
        As ``judge_mass``, of the share of each container's recordings that training held out.
    """
    usable = [row for row in rows if _is_usable(predictor, row)]
    held = held_out(
        [(row.container, row.recording_id) for row in usable], share=training.validation, seed=training.seed
    )
    return judge_mass(predictor, [row for row, is_held in zip(usable, held, strict=True) if is_held])


def _is_usable(predictor: MassPredictor, row: MassRow) -> bool:
    return bool(judge_mass(predictor, [row])["reason"].iloc[0] == "")
