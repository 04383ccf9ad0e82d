from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.filling import FillingPredictor, cross_validate, crossvalidation
from corsmal.filling.crossvalidation import COLUMNS
from tests.filling.made import JOINT, PAPER, made_samples

SHORT = replace(JOINT, epochs=1)
SAMPLES = made_samples(28)
FOLDS = {sample.recording_id: index % 2 for index, sample in enumerate(SAMPLES)}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    shares = []
    table = cross_validate(folder, SAMPLES, folds=FOLDS, preset=SHORT, seeds=(0, 4), progress=shares.append)
    return folder, table, shares


def test_every_recording_is_predicted_once_per_seed(run):
    _, table, shares = run
    assert tuple(table.columns) == COLUMNS
    assert table["recording_id"].tolist() == [sample.recording_id for sample in SAMPLES] * 2
    assert table["seed"].tolist() == [0] * 28 + [4] * 28
    assert table["fold"].tolist() == list(FOLDS.values()) * 2
    assert table["true_type"].tolist() == [sample.filling_type for sample in SAMPLES] * 2
    assert shares == pytest.approx([0.25, 0.5, 0.75, 1])


def test_predictions_are_those_of_networks_that_did_not_hear_the_recording(run, monkeypatch, tmp_path):
    folder, table, _ = run
    for row, sample in zip(table.iloc[28:].itertuples(), SAMPLES, strict=True):
        prediction = FillingPredictor(folder / "seed4" / f"fold{row.fold}" / "filling.safetensors").predict(
            sample.features
        )
        assert (row.predicted_type, row.predicted_level) == prediction.pair
        found = [row.p_none, row.p_pasta, row.p_rice, row.p_water, row.p_empty, row.p_half, row.p_full]
        np.testing.assert_allclose(found, list(prediction.probabilities.values()), atol=1e-6)
    trained = []
    original = crossvalidation.train_filling

    def spy(folder, samples, **others):
        trained.append({sample.recording_id for sample in samples})
        return original(folder, samples, **others)

    monkeypatch.setattr(crossvalidation, "train_filling", spy)
    cross_validate(tmp_path, SAMPLES, folds=FOLDS, preset=SHORT)
    assert trained == [{name for name, fold in FOLDS.items() if fold != held} for held in (0, 1)]


def test_table_is_written_and_a_finished_run_only_read(run):
    folder, table, _ = run
    written = pd.read_csv(folder / "predictions.csv", dtype={"recording_id": str})
    pd.testing.assert_frame_equal(written, table, check_dtype=False)
    shares = []
    again = cross_validate(folder, SAMPLES, folds=pd.Series(FOLDS), preset=SHORT, seeds=(0, 4), progress=shares.append)
    assert shares == []
    pd.testing.assert_frame_equal(again, table)


def test_killed_run_goes_on(run, tmp_path):
    def killed(share):
        if share > 0.6:
            raise KeyboardInterrupt

    with pytest.raises((KeyboardInterrupt, SystemExit)):
        cross_validate(tmp_path, SAMPLES, folds=FOLDS, preset=SHORT, seeds=(0, 4), progress=killed)
    shares = []
    table = cross_validate(tmp_path, SAMPLES, folds=FOLDS, preset=SHORT, seeds=(0, 4), progress=shares.append)
    assert len(shares) <= 2
    pd.testing.assert_frame_equal(table, run[1])


@pytest.mark.parametrize(("validation", "held"), [("fold", 14), ("inner", 2)])
def test_rule_1_looks_at_the_fold_or_at_recordings_of_its_training(tmp_path, monkeypatch, validation, held):
    seen = []
    original = crossvalidation.train_filling

    def spy(folder, samples, **others):
        seen.append(others["validation"])
        return original(folder, samples, **others)

    monkeypatch.setattr(crossvalidation, "train_filling", spy)
    cross_validate(tmp_path, SAMPLES, folds=FOLDS, preset=replace(PAPER, epochs=1), validation=validation)
    if held == 14:
        assert [sample.recording_id for sample in seen[0]] == [name for name, fold in FOLDS.items() if fold == 0]
    else:
        assert seen == [None, None]


def test_folds_that_do_not_divide_the_samples_are_refused(tmp_path):
    absent = dict(list(FOLDS.items())[1:])
    for folds, message in ((absent, "none for 000000"), (dict.fromkeys(FOLDS, 1), "folds must be two or more")):
        with pytest.raises(ArgumentError, match=message):
            cross_validate(tmp_path, SAMPLES, folds=folds, preset=SHORT)


def test_fold_that_leaves_one_class_to_train_on_is_refused(tmp_path):
    folds = {sample.recording_id: 1 + int(sample.filling_type == 0) for sample in SAMPLES}
    with pytest.raises(ArgumentError, match="two classes of filling_type or more, got none only"):
        cross_validate(tmp_path, SAMPLES, folds=folds, preset=SHORT)


def test_unknown_validation_is_refused(tmp_path):
    with pytest.raises(ArgumentError, match="validation must be one of"):
        cross_validate(tmp_path, SAMPLES, folds=FOLDS, preset=SHORT, validation="test")
