from dataclasses import replace

import pandas as pd
import pytest
import torch

from corsmal.errors import ArgumentError, FileError
from corsmal.mass import MassConfig, MassPredictor, MassTraining, read_mass, train_mass
from tests.mass.test_samples import made_row, made_rows

NETWORK = MassConfig(channels=(2, 3, 4, 5), hidden=(6, 4))
TINY = MassTraining(network=NETWORK, epochs=3, batch=8)


@pytest.fixture(scope="module")
def learnt(tmp_path_factory):
    """A run that ends by itself, and its losses."""
    folder = tmp_path_factory.mktemp("learnt")
    training = MassTraining(network=NETWORK, epochs=40, batch=4, rate=2e-2, patience=4)
    result = train_mass(made_rows(20), folder, training)
    return result, pd.read_csv(folder / "log" / "version_0" / "metrics.csv")["validation_loss"].dropna().to_list()


def test_two_containers_are_learnt(learnt):
    result, _ = learnt
    assert (result.rows, result.validation_rows, result.dropped) == (32, 8, {})
    predictor = MassPredictor(result.path)
    for row, other_g in ((made_row(3), 59), (list(made_rows(4))[-1], 10)):
        found = predictor.predict(
            row.mask, width_top_mm=row.width_top_mm, width_bottom_mm=row.width_bottom_mm, height_mm=row.height_mm
        )
        assert abs(found.mass_g - row.mass_g) < abs(found.mass_g - other_g)


def test_training_stops_when_the_validation_loss_no_longer_falls(learnt):
    result, losses = learnt
    assert result.epochs == len(losses) < 40
    assert losses[-5] == min(losses) == pytest.approx(result.validation_loss)


def test_statistics_are_those_of_the_rows_that_are_trained_on(learnt):
    model = read_mass(learnt[0].path)
    assert float(model.numbers_mean[1]) == 61
    assert float(model.numbers_mean[2]) == pytest.approx((119 + 241) / 2)


def test_the_least_mass_of_the_rows_is_kept(learnt):
    result, _ = learnt
    assert read_mass(result.path).config == replace(NETWORK, least_mass_g=10.0)


def test_a_stopped_run_that_goes_on_ends_like_one_that_was_not(tmp_path):
    whole = train_mass(made_rows(), tmp_path / "whole", TINY)
    train_mass(made_rows(), tmp_path / "parts", replace(TINY, epochs=2))
    parts = train_mass(made_rows(), tmp_path / "parts", TINY)
    assert parts.epochs == 3
    assert parts.validation_loss == pytest.approx(whole.validation_loss)
    first, second = read_mass(whole.path).state_dict(), read_mass(parts.path).state_dict()
    for name, value in first.items():
        torch.testing.assert_close(value, second[name], msg=name)


def test_rows_without_dimensions_are_left_out_and_counted(tmp_path):
    rows = [*made_rows(), made_row(90, height_mm=None), made_row(91, width_top_mm=None)]
    result = train_mass(rows, tmp_path, replace(TINY, epochs=1))
    assert result.dropped == {"height_mm is missing": 1, "width_top_mm is missing": 1}
    assert result.rows + result.validation_rows == 20


@pytest.mark.parametrize("rows", [[], [made_row()], [made_row(0), made_row(1)], [made_row(height_mm=None)] * 9])
def test_too_few_rows_are_an_error(tmp_path, rows):
    with pytest.raises(ArgumentError, match="rows must leave two to train on and one to validate with"):
        train_mass(rows, tmp_path, TINY)


@pytest.mark.parametrize("content", [b"", b"no checkpoint"])
def test_a_broken_checkpoint_is_named(tmp_path, content):
    path = tmp_path / "checkpoints" / "last.ckpt"
    path.parent.mkdir()
    path.write_bytes(content)
    with pytest.raises(FileError, match="delete it to begin again") as raised:
        train_mass(made_rows(), tmp_path, TINY)
    assert raised.value.path == path


def test_a_checkpoint_of_another_network_is_named(tmp_path):
    train_mass(made_rows(), tmp_path, replace(TINY, epochs=1))
    other = replace(TINY, network=replace(NETWORK, hidden=(7, 4)))
    with pytest.raises(FileError, match="is of another network"):
        train_mass(made_rows(), tmp_path, other)


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(FileError, match="choose another folder"):
        train_mass(made_rows(), tmp_path / "file" / "run", TINY)


@pytest.mark.parametrize(
    "change",
    [{"epochs": 0}, {"patience": 0}, {"batch": 1}, {"validation": 0}, {"validation": 1}, {"rate": 0}, {"seed": -1}],
)
def test_settings_out_of_their_range_are_an_error(change):
    with pytest.raises(ArgumentError):
        replace(TINY, **change)
