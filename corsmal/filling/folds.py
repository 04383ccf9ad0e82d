"""Which recordings are validated together: spread by filling (paper 4.1), or whole containers at a time."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from corsmal.errors import ArgumentError

PAPER_FOLDS = 7
"""The paper's number of folds (4.1)."""

WINNERS_FOLDS = ((1, 4, 7), (2, 5, 8), (3, 6, 9))
"""Containers of the three folds of the 2020 challenge's winners: a cup, a glass and a box each, unseen in training."""


def spread_folds(table: pd.DataFrame, *, folds: int = PAPER_FOLDS, seed: int = 0) -> pd.Series:
    """Folds over which every (type, level) configuration is spread equally (paper 4.1).

    Args:
        table: indexed by recording id, with ``filling_type`` and ``filling_level``, such as ``Dataset.table``;
            recordings without both are left out.
        folds: how many.
        seed: of the order in which recordings are dealt.

    Returns:
        0 to ``folds`` − 1 by recording id. The folds' sizes differ by at most one, and so do the recordings that
        they have of each configuration.

    Raises:
        ArgumentError: a column is missing, or there are fewer recordings than folds, or fewer than two folds.
    """
    known = _known(table, ["filling_type", "filling_level"])
    if not 2 <= folds <= len(known):
        raise ArgumentError(f"folds must be from 2 to the {len(known)} recordings with a known filling, got {folds}")
    shuffled = known.sample(frac=1, random_state=np.random.default_rng(seed))
    dealt = shuffled.sort_values(["filling_type", "filling_level"], kind="stable").index
    numbers = pd.Series(np.arange(len(dealt)) % folds, index=dealt, name="fold")
    return numbers.reindex(known.index)


def folds_by_container(table: pd.DataFrame, *, groups: Sequence[Sequence[int]] = WINNERS_FOLDS) -> pd.Series:
    """Folds of whole containers, ``groups`` of their ids: each is validated by a network that was not trained on it.

    Returns:
        The position of the container's group, by recording id of ``table``; recordings without a ``container_id`` are
        left out.

    Raises:
        ArgumentError: a container is in no group or in two, or there are fewer than two groups.
    """
    known = _known(table, ["container_id"])
    fold_of = {container: fold for fold, group in enumerate(groups) for container in group}
    if len(groups) < 2 or len(fold_of) != sum(map(len, groups)):
        raise ArgumentError(f"groups must be two or more without a container in common, got {list(groups)}")
    absent = sorted(set(known["container_id"]) - set(fold_of))
    if absent:
        raise ArgumentError(f"groups must hold every container, got none with container {absent[0]}")
    return known["container_id"].map(fold_of).astype(int).rename("fold")


def _known(table: pd.DataFrame, columns: list[str]) -> pd.DataFrame:
    missing = [column for column in columns if column not in table]
    if missing:
        raise ArgumentError(f"table must have the columns {columns}, got none named {missing[0]!r}")
    return table[columns].dropna()
