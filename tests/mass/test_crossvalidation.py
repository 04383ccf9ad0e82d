from collections import Counter
from dataclasses import replace

import pytest

from corsmal.dataset import TrainedOn
from corsmal.errors import ArgumentError
from corsmal.mass import MassConfig, MassPredictor, MassTraining, judge_mass, train_mass
from corsmal.mass.crossvalidation import cross_validate_mass, judge_validation, spread_mass_folds
from tests.mass.test_samples import made_rows

TINY = MassTraining(network=MassConfig(channels=(2, 3, 4, 5), hidden=(6, 4)), epochs=2, batch=4)
ROWS = list(made_rows(10))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    trained_on = TrainedOn({row.recording_id: {} for row in ROWS}, is_synthetic=True)
    folds = spread_mass_folds(ROWS, folds=2)
    return folder, folds, cross_validate_mass(folder, ROWS, folds=folds, training=TINY, trained_on=trained_on)


def test_folds_hold_equally_many_of_each_container():
    folds = spread_mass_folds(ROWS, folds=5)
    counts = Counter((row.container, folds[row.recording_id]) for row in ROWS)
    assert set(counts.values()) == {2}


def test_every_recording_is_weighed_by_the_network_that_has_not_seen_it(run):
    folder, folds, table = run
    assert sorted(table["recording_id"]) == sorted(row.recording_id for row in ROWS)
    for fold in (0, 1):
        held = [row for row in ROWS if folds[row.recording_id] == fold]
        predictor = MassPredictor(folder / "seed0" / f"fold{fold}" / "mass.safetensors")
        expected = judge_mass(predictor, held)
        assert table[table["fold"] == fold]["mass_g"].tolist() == expected["mass_g"].tolist()
        assert set(predictor.trained_on.recordings).isdisjoint(row.recording_id for row in held)
        assert (predictor.trained_on.protocol, predictor.trained_on.fold) == ("held-out", fold)


def test_the_paper_judges_those_by_which_the_epoch_was_chosen(tmp_path):
    training = replace(TINY, validation=0.2)
    trained = train_mass(ROWS, tmp_path, training)
    judged = judge_validation(MassPredictor(trained.path), ROWS, training)
    assert len(judged) == trained.validation_rows == 4
    assert Counter(judged["container"]) == dict.fromkeys({row.container for row in ROWS}, 2)


def test_what_cannot_be_is_named(tmp_path):
    with pytest.raises(ArgumentError, match="folds must be from 2"):
        spread_mass_folds(ROWS[:1])
    with pytest.raises(ArgumentError, match="two or more"):
        cross_validate_mass(tmp_path, ROWS, folds={row.recording_id: 0 for row in ROWS}, training=TINY)
    with pytest.raises(ArgumentError, match="got none for"):
        cross_validate_mass(tmp_path, ROWS, folds={}, training=TINY)
