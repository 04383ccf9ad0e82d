from dataclasses import asdict, replace

import numpy as np
import pandas as pd
import pytest
import torch

from corsmal.dataset import TrainedOn
from corsmal.errors import ArgumentError, FileError
from corsmal.filling import FillingPredictor, FusedPredictor, FusedTraining, cross_validate, train_fused
from corsmal.filling.config import PooledConfig, RecurrentConfig
from corsmal.filling.fused import FusedConfig, FusedModel, read_fused, save_fused
from corsmal.filling.fused_training import inner_folds, seen
from corsmal.filling.senses import CONDITIONS, predictions_by_condition
from corsmal.weights import save_network
from tests.filling.made import JOINT, WIDTH, made_features, made_samples

SOUND = RecurrentConfig(channels=2, features=WIDTH, hidden=4)
SIGHT = PooledConfig(features=8, hidden=4)
TINY = FusedTraining(
    sound=(replace(JOINT, networks=(SOUND,), epochs=2),) * 2, sight=replace(JOINT, networks=(SIGHT,), epochs=2)
)


def samples_of_both(count, *, blind=()):
    """Recordings whose sight says the level in its first columns; those in ``blind`` have none."""
    found = []
    for index, sample in enumerate(made_samples(count)):
        sight = made_features(2 * sample.rows, seed=index, channels=3, width=8) * 0.3
        sight[..., sample.filling_level] += 2
        found.append(replace(sample, sight=None if index in blind else sight))
    return found


def untrained(seed=0):
    torch.manual_seed(seed)
    return FusedModel(FusedConfig((SOUND, SOUND), (SIGHT,))).eval()


@pytest.fixture
def weights(tmp_path):
    save_fused(tmp_path / "filling.safetensors", untrained())
    return tmp_path / "filling.safetensors"


def test_model_is_read_back(weights):
    first, second = untrained(), read_fused(weights)
    assert second.config == first.config
    for name, value in first.state_dict().items():
        assert torch.equal(second.state_dict()[name], value)


def test_older_file_that_names_no_gate_has_one_of_kinds(tmp_path):
    model = untrained()
    sizes = asdict(model.config)
    del sizes["gate"]
    save_network(tmp_path / "old.safetensors", model, kind="filling", config={"fused": sizes})
    found = read_fused(tmp_path / "old.safetensors")
    assert found.gate.form == "kinds"
    assert found.gate.state_dict().keys() == model.gate.state_dict().keys()
    save_fused(tmp_path / "new.safetensors", FusedModel(FusedConfig((SOUND,), (SIGHT,), "visible")))
    assert read_fused(tmp_path / "new.safetensors").gate.form == "visible"


def test_preset_has_at_most_eight_networks_and_a_small_file(tmp_path):
    preset = FusedTraining()
    sound = tuple(config for group in preset.sound for config in group.networks)
    save_fused(tmp_path / "preset.safetensors", FusedModel(FusedConfig(sound, preset.sight.networks, preset.gate)))
    assert len(sound) + len(preset.sight.networks) <= 8
    assert (tmp_path / "preset.safetensors").stat().st_size < 20e6


def test_prediction_holds_what_each_sense_says(weights):
    [sample] = samples_of_both(1)
    predictor = FusedPredictor(weights)
    both = predictor.predict_sample(sample)
    heard, watched = predictor.predict(sample.features), predictor.predict(None, sight=sample.sight)
    assert both.sound.probabilities == heard.probabilities
    assert both.sight.probabilities == watched.probabilities
    assert (heard.sight, watched.sound) == (None, None)
    assert (heard.sight_share, watched.sight_share, both.sight_share) == (0, 1, 0.5)
    assert both.type_probabilities == pytest.approx(heard.type_probabilities, abs=1e-6)
    # an untrained gate takes the mean of the logarithms
    expected = np.sqrt(heard.level_probabilities * watched.level_probabilities)
    assert both.level_probabilities == pytest.approx(expected / expected.sum(), abs=1e-6)
    assert both.decoding == "feasible"
    with torch.no_grad():
        kinds = untrained().sight[0].seen(torch.from_numpy(sample.sight)[None])[2].softmax(dim=1)[0].numpy()
    assert both.kind_probabilities == pytest.approx(kinds, abs=1e-6)
    assert heard.kind_probabilities is None


def test_what_does_not_fit_the_weights_is_refused(weights):
    [sample] = samples_of_both(1)
    predictor = FusedPredictor(weights)
    with pytest.raises(ArgumentError, match="neither"):
        predictor.predict(None)
    with pytest.raises(ArgumentError, match="features must be"):
        predictor.predict(sample.features[:1])
    with pytest.raises(ArgumentError, match="sight must be"):
        predictor.predict(sample.features, sight=sample.sight[:, :0])
    with pytest.raises(ArgumentError, match="finite"):
        predictor.predict(sample.features, sight=sample.sight * np.nan)


def test_file_of_another_network_is_no_fused_one(weights):
    with pytest.raises(FileError, match="not a file of the filling network's weights"):
        FillingPredictor(weights)
    with pytest.raises(ArgumentError, match="at most 8"):
        FusedConfig((SOUND,) * 7, (SIGHT,) * 2)
    with pytest.raises(ArgumentError, match="recognise the container's kind"):
        FusedConfig((SOUND,), (SOUND,))


def test_gate_is_learned_from_containers_unseen_by_the_networks():
    folds = inner_folds(made_samples(21))
    assert sorted(sample.recording_id for fold in folds for sample in fold) == [f"{n:06d}" for n in range(21)]
    containers = [{sample.container_id for sample in fold} for fold in folds]
    assert containers == [{1}, {2}, {3}]
    one = inner_folds([replace(sample, container_id=1) for sample in made_samples(21)])
    assert [len(fold) for fold in one] == [7, 7, 7]


def test_kinds_are_dealt_over_the_inner_folds():
    samples = [replace(made_samples(1)[0], container_id=number) for number in (8, 1, 2, 4, 5, 7)]
    folds = [{sample.container_id for sample in fold} for fold in inner_folds(samples)]
    assert folds == [{1, 5}, {2, 7}, {4, 8}]


def test_training_ends_with_one_file_and_resumes(tmp_path):
    samples, shares = samples_of_both(28, blind=(0, 5)), []
    record = TrainedOn({sample.recording_id: {} for sample in samples}, is_synthetic=True)
    path = train_fused(tmp_path, samples, training=TINY, trained_on=record, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1)
    model = read_fused(path)
    assert (len(model.sound), len(model.sight)) == (2, 1)
    assert model.gate.visible.abs() > 0
    assert FusedPredictor(path).trained_on == record
    before = path.stat().st_mtime_ns
    path.unlink()
    assert (
        train_fused(tmp_path, samples, training=TINY) == path
    )  # networks are there: the same bytes but for the record
    again = read_fused(path).state_dict()
    assert all(torch.equal(value, again[name]) for name, value in model.state_dict().items())
    assert path.stat().st_mtime_ns != before
    with pytest.raises(FileError, match="other recordings or settings"):
        train_fused(tmp_path, samples_of_both(28), training=TINY)


def test_sight_takes_the_place_of_sound():
    samples = samples_of_both(3, blind=(1,))
    assert [sample.recording_id for sample in seen(samples)] == ["000000", "000002"]
    assert np.array_equal(seen(samples)[1].features, samples[2].sight)


def test_training_without_sight_is_refused(tmp_path):
    with pytest.raises(ArgumentError, match="sound and of sight"):
        train_fused(tmp_path, made_samples(14), training=TINY)
    for wrong in ({"inner": 0}, {"inner": 2}, {"sound": (replace(TINY.sound[0], keep="best"),)}):
        with pytest.raises(ArgumentError):
            replace(TINY, **wrong)


def test_cross_validation_also_under_each_condition(tmp_path):
    samples = samples_of_both(28, blind=(3,))
    folds = pd.Series({sample.recording_id: index % 2 for index, sample in enumerate(samples)})
    found = cross_validate(tmp_path, samples, folds=folds, preset=TINY)
    tables = predictions_by_condition(tmp_path, samples, folds=folds, seeds=(0,))
    assert set(tables) == set(CONDITIONS)
    assert all(set(table["recording_id"]) == set(found["recording_id"]) for table in tables.values())
    own = {name: table.set_index("recording_id")["p_full"] for name, table in tables.items()}
    both = found.set_index("recording_id")["p_full"]
    assert own["sound only"]["000003"] == own["sight only"]["000003"] == both["000003"]
    assert not np.isclose(own["sight only"]["000004"], own["sound only"]["000004"])
    assert not np.isclose(own["both noisy"]["000004"], both["000004"])
    predictor = FusedPredictor(tmp_path / "seed0" / "fold0" / "filling.safetensors")
    assert both["000004"] == pytest.approx(predictor.predict_sample(samples[4]).probabilities["full"])
    assert (tmp_path / "predictions_sight-only.csv").is_file()
