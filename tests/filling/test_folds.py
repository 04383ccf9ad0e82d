import numpy as np
import pandas as pd
import pytest

from corsmal.dataset import open_dataset
from corsmal.errors import ArgumentError
from corsmal.filling import WINNERS_FOLDS, folds_by_container, spread_folds


def made_table(counts):
    """So many recordings of each (type, level)."""
    rows = [pair for pair, count in counts.items() for _ in range(count)]
    table = pd.DataFrame(rows, columns=["filling_type", "filling_level"], dtype="Int64")
    table["container_id"] = np.arange(len(rows)) % 9 + 1
    return table.set_index(pd.Index([f"{index:06d}" for index in range(len(rows))], name="id"))


def test_every_configuration_is_spread_equally():
    table = made_table({(0, 0): 30, (1, 1): 22, (1, 2): 7, (3, 2): 3})
    folds = spread_folds(table)
    counts = pd.crosstab([table["filling_type"], table["filling_level"]], folds)
    assert (counts.max(axis=1) - counts.min(axis=1) <= 1).all()
    assert np.ptp(folds.value_counts()) <= 1
    assert folds.index.equals(table.index)
    assert sorted(folds.unique()) == list(range(7))


def test_seed_decides_who_is_where():
    table = made_table({(0, 0): 30, (1, 1): 30})
    first, again, other = (spread_folds(table, seed=seed) for seed in (0, 0, 1))
    assert first.equals(again)
    assert not first.equals(other)


def test_recordings_without_a_known_filling_are_left_out():
    table = made_table({(0, 0): 10, (1, 1): 10})
    table.loc["000003", "filling_level"] = pd.NA
    assert "000003" not in spread_folds(table, folds=3)
    table.loc["000004", "container_id"] = pd.NA
    assert "000004" not in folds_by_container(table)


def test_containers_go_to_the_fold_of_their_group():
    table = made_table({(0, 0): 18})
    folds = folds_by_container(table)
    assert [folds.iloc[container - 1] for container in range(1, 10)] == [0, 1, 2] * 3
    assert WINNERS_FOLDS == ((1, 4, 7), (2, 5, 8), (3, 6, 9))


@pytest.mark.parametrize("groups", [[(1, 2)], [(1, 2, 3), (3, 4, 5, 6, 7, 8, 9)], [(1, 2, 3), (4, 5, 6)]])
def test_groups_that_do_not_divide_the_containers_are_refused(groups):
    with pytest.raises(ArgumentError, match="groups must"):
        folds_by_container(made_table({(0, 0): 18}), groups=groups)


@pytest.mark.parametrize("folds", [0, 1, 11])
def test_numbers_of_folds_that_cannot_be_are_refused(folds):
    with pytest.raises(ArgumentError, match="folds must be from 2 to the 10 recordings"):
        spread_folds(made_table({(0, 0): 10}), folds=folds)


def test_table_without_a_column_is_refused():
    with pytest.raises(ArgumentError, match="'filling_level'"):
        spread_folds(made_table({(0, 0): 10}).drop(columns="filling_level"))


def test_folds_of_the_training_set(real_dataset_root):
    table = open_dataset(real_dataset_root).table
    folds = folds_by_container(table)
    assert folds.value_counts().to_dict() == {0: 228, 1: 228, 2: 228}
    spread = spread_folds(table)
    counts = pd.crosstab([table["filling_type"], table["filling_level"]], spread)
    assert counts.shape == (7, 7)
    assert (counts.max(axis=1) - counts.min(axis=1) <= 1).all()
