from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import soundfile

from corsmal.estimation import TrainingMeans, estimate
from corsmal.evaluation.estimates import check_estimates
from corsmal.evaluation.protocols import left_out
from corsmal.filling import released
from corsmal.parameters import ShapeParameters
from corsmal.stages import estimates as estimating
from corsmal.stages.estimates import Predictors, load_estimate
from corsmal.stages.settings import EstimateSettings
from corsmal.stages.version import METHOD_VERSION
from corsmal.weights import file_sha256, find_weights
from tests.fakes import FakeFilling, FakeMass
from tests.released import write_released


@pytest.fixture
def all_stages(dataset):
    return Predictors(means=TrainingMeans.of(dataset), filling=FakeFilling(2, 1), mass=FakeMass(20.0))


@pytest.fixture
def counted(monkeypatch):
    """The ids of the recordings that were estimated, not read."""
    ids = []

    def counting(recording, **options):
        ids.append(recording.id)
        return estimate(recording, **options)

    monkeypatch.setattr(estimating, "estimate", counting)
    return ids


def all_rows(dataset, predictors, store):
    return [load_estimate(recording, predictors, store=store) for recording in dataset]


def test_rows_are_the_estimates(dataset, store, all_stages):
    rows = all_rows(dataset, all_stages, store)
    assert [row["recording_id"] for row in rows] == [recording.id for recording in dataset]
    alone = estimate(
        dataset["000000"], means=all_stages.means.for_container(None), filling=all_stages.filling, mass=all_stages.mass
    )
    assert {name: rows[0][name] for name in alone.row()} == alone.row()


def test_rows_name_the_authors_networks_and_count_as_held_out_nowhere(dataset, store, tmp_path):
    paths = write_released(tmp_path)
    settings = EstimateSettings(
        means=TrainingMeans.of(dataset),
        filling=find_weights("filling", paths["filling"]),
        mass=find_weights("mass", paths["mass"]),
    )
    predictors = settings.open()
    assert predictors.digests == settings.digests
    row = load_estimate(dataset["000000"], predictors, store=store)
    assert row["filling_weights"] == f"released filling network {file_sha256(paths['filling'])}"
    assert row["mass_weights"] == f"released mass network {file_sha256(paths['mass'])}"
    assert (row["filling_held_out"], row["mass_held_out"]) == (None, None)
    for name in ("filling", "mass"):
        assert f"{name}: the network is in the authors' file, which does not say" in row["notes"]
    assert row["container_mass_g"] > 0
    samples, rate_hz = soundfile.read(dataset["000000"].audio_path, dtype="float32")
    types, _ = released.logits(paths["filling"], samples.T, sample_rate_hz=rate_hz)
    powers = np.exp(types.astype(float))
    assert [row[f"type_p{index}"] for index in range(4)] == pytest.approx((powers / powers.sum()).tolist(), rel=1e-4)
    checked = check_estimates(pd.DataFrame([row]), pd.Index(["000000"])).table
    assert left_out(checked).table[["filling", "mass"]].to_numpy().all()


def test_second_run_reads_and_gives_the_same(dataset, store, all_stages, counted):
    first = all_rows(dataset, all_stages, store)
    assert len(counted) == len(dataset)
    assert all_rows(dataset, all_stages, store) == first
    assert len(counted) == len(dataset)


@pytest.mark.parametrize(
    "change",
    [
        {"shape": ShapeParameters(circumferences=40)},
        {"means": None},
        {"filling": None},
        {"filling": FakeFilling(3, 2)},
        {"mass": FakeMass(7.0)},
    ],
)
def test_other_settings_are_estimated_anew(dataset, store, all_stages, counted, change):
    for predictors in (all_stages, replace(all_stages, **change), all_stages):
        load_estimate(dataset["000000"], predictors, store=store)
    assert counted == ["000000"] * 2


def test_predictors_of_another_version_of_the_method_have_another_key(all_stages, monkeypatch):
    before = all_stages.key
    monkeypatch.setattr(estimating, "METHOD_VERSION", METHOD_VERSION + 1)
    assert all_stages.key != before


def test_broken_recording_is_one_failed_row_with_its_reason(dataset, store, all_stages, tmp_path):
    broken = tmp_path / "broken.pickle"
    broken.write_bytes(b"no calibration")
    recording = dataset["000000"]
    views = {name: replace(view, calibration_path=broken) for name, view in recording.views.items()}
    sound = tmp_path / "broken.wav"
    sound.write_bytes(b"RIFF")
    predictors = replace(all_stages, means=None)
    rows = all_rows([replace(recording, views=views, audio_path=sound), dataset["000001"]], predictors, store)
    assert [row["status"] for row in rows] == ["failed", "fitted"]
    assert str(broken) in rows[0]["notes"]
    assert str(sound) in rows[0]["notes"]


def test_features_come_from_a_folder_where_one_is_named(dataset, store, all_stages, tmp_path):
    np.save(tmp_path / "000000.npy", np.ones((5, 128), np.float32))
    predictors = replace(all_stages, features=Path(tmp_path))
    assert load_estimate(dataset["000000"], predictors, store=store)["filling_type"] == 2
    assert predictors.filling.heard.shape == (1, 5, 128)
    without = load_estimate(dataset["000001"], predictors, store=store)
    assert without["filling_type"] is None
    assert "000001.npy" in without["notes"]
