from dataclasses import asdict, replace

import pytest

from corsmal.dataset import TrainedOn, open_dataset
from corsmal.estimation import TrainingMeans
from corsmal.parameters import ShapeParameters
from corsmal.stages.detections import load_detections
from corsmal.stages.estimates import SYNTHETIC, Predictors, kept_row, load_estimate
from corsmal.stages.settings import default_settings, left_out_note
from corsmal.weights import bundled_path
from tests.fakes import FakeFilling, FakeMass
from tests.networks import write_networks

PAPER = ShapeParameters.paper()


@pytest.fixture(scope="module")
def dataset(tiny_dataset_root):
    return open_dataset(tiny_dataset_root)


@pytest.fixture(autouse=True)
def no_weights_in_the_environment(monkeypatch):
    for kind in ("FILLING", "MASS"):
        monkeypatch.delenv(f"CORSMAL_{kind}_WEIGHTS", raising=False)


def test_bundled_networks_do_not_speak_about_filmed_recordings(dataset):
    settings = default_settings(dataset, shape=PAPER)
    assert (settings.filling, settings.mass, settings.means) == (None, None, None)
    assert "--filling demo --mass demo" in left_out_note(dataset, settings)


def test_bundled_networks_speak_when_they_are_named(dataset):
    settings = default_settings(dataset, shape=PAPER, filling="demo", mass="demo")
    assert settings.filling.path == bundled_path("filling")
    assert settings.mass.path == bundled_path("mass")
    assert left_out_note(dataset, settings) == ""


def test_weights_of_the_environment_speak(dataset, tmp_path, monkeypatch):
    paths = write_networks(tmp_path)
    for kind, path in paths.items():
        monkeypatch.setenv(f"CORSMAL_{kind.upper()}_WEIGHTS", str(path))
    settings = default_settings(dataset, shape=PAPER)
    assert {"filling": settings.filling.path, "mass": settings.mass.path} == paths


def test_rows_are_found_without_opening_the_networks(dataset, store):
    settings = default_settings(dataset, shape=PAPER, filling="demo", mass="demo")
    networks = settings.open()
    assert (settings.digests, settings.key) == (networks.digests, networks.key)
    recording, origin = dataset["000000"], load_detections(dataset["000000"], store=store).key
    assert kept_row(recording, settings, origin, store=store) is None
    row = load_estimate(recording, networks, store=store)
    assert kept_row(recording, settings, origin, store=store) == row
    assert kept_row(recording, replace(settings, mass=None), origin, store=store) is None


def test_no_recording_falls_back_to_a_mean_that_holds_its_own_truth(dataset, store):
    """A set of one annotated recording without detections used to score 0 % on its own mean."""
    alone = Predictors(means=TrainingMeans.of(dataset))
    row = load_estimate(replace(dataset["000002"], views={}), alone, store=store)
    others = [dataset[name].annotation.capacity_ml for name in ("000000", "000001")]
    assert row["status"] == "fallback: training mean"
    assert row["capacity_ml"] == pytest.approx(sum(others) / 2)
    assert load_estimate(replace(dataset["000002"], views={}), Predictors(), store=store)["status"] == "failed"


def trained(dataset, ids, **changes):
    return replace(TrainedOn.of([dataset[name] for name in ids]), **changes)


def test_rows_say_whether_their_networks_have_seen_them(dataset, store):
    filling, mass = FakeFilling(2, 1), FakeMass(20.0)
    filling.trained_on, mass.trained_on = trained(dataset, ["000000"]), None
    rows = [load_estimate(each, Predictors(filling=filling, mass=mass), store=store) for each in dataset]
    assert [row["filling_held_out"] for row in rows] == [False, True, True]
    assert [row["mass_held_out"] for row in rows] == [None] * 3  # weights that do not say what they were trained on
    assert {row["filling_weights"] for row in rows} == {filling.digest}


def test_a_network_of_synthetic_recordings_is_marked_on_filmed_ones(dataset, store):
    filling = FakeFilling(2, 1)
    filling.trained_on = TrainedOn({"a": {}}, is_synthetic=True)
    row = load_estimate(dataset["000000"], Predictors(filling=filling), store=store)
    assert row["filling_weights"].endswith(SYNTHETIC)
    assert "trained on synthetic recordings only" in row["notes"]


def test_dimensions_of_another_preset_than_the_mass_network_learned_from_are_named(dataset, store):
    mass = FakeMass(20.0)
    mass.trained_on = TrainedOn({"a": {}}, is_synthetic=False, facts={"shape": "paper"})
    rows = [
        load_estimate(dataset["000000"], Predictors(shape=shape, mass=mass), store=store)
        for shape in (PAPER, ShapeParameters.lode())
    ]
    assert ["of the shape preset" in row["notes"] for row in rows] == [False, True]


def test_weights_hand_on_the_means_of_their_training_set(dataset, tmp_path):
    means = TrainingMeans.of(dataset)
    said = TrainedOn({"a": {}}, None, facts={"means": asdict(means)}).to_json()
    mass = write_networks(tmp_path, training=said)["mass"]
    assert default_settings(dataset, shape=PAPER, mass=mass).means == means


def test_how_long_an_estimate_took_is_in_its_row(dataset, store):
    assert load_estimate(dataset["000000"], Predictors(), store=store)["execution_time_ms"] > 0
