from dataclasses import replace

import numpy as np
import pytest
import torch

from corsmal.dataset import TrainedOn
from corsmal.errors import ArgumentError, FileError
from corsmal.filling import FillingModel, FillingPredictor, save_filling, train_filling
from tests.filling.made import JOINT, SMALL, WIDTH, made_features, made_samples

FEASIBLE = replace(SMALL, duration_input=True, decoding="feasible")


@pytest.fixture
def models():
    with torch.random.fork_rng():
        torch.manual_seed(0)
        made = [FillingModel(FEASIBLE).eval() for _ in range(3)]
    for model in made:
        model.learn_statistics([made_features(5), made_features(9)])
    return made


@pytest.fixture
def one(tmp_path, models):
    save_filling(tmp_path / "one.safetensors", models[:1])
    return FillingPredictor(tmp_path / "one.safetensors")


@pytest.fixture
def three(tmp_path, models):
    save_filling(tmp_path / "three.safetensors", models)
    return FillingPredictor(tmp_path / "three.safetensors")


def softmax(logits):
    return np.exp(logits) / np.exp(logits).sum()


@torch.inference_mode()
def test_one_network_answers_with_its_own_logits(one, models):
    features = made_features(9)
    prediction = one.predict(features, steps_s=0.5)
    types, levels, attention = (value[0].numpy() for value in models[0].explain(torch.from_numpy(features)[None]))
    np.testing.assert_allclose(prediction.type_logits, types, atol=1e-5)
    np.testing.assert_allclose(prediction.level_logits, levels, atol=1e-5)
    np.testing.assert_allclose(prediction.attention, attention, atol=1e-5)
    assert (prediction.rows, prediction.steps_s, prediction.decoding, prediction.ok) == ((0, 9), 0.5, "feasible", True)


@torch.inference_mode()
def test_several_networks_answer_with_their_mean_probabilities(three, models):
    features = made_features(9)
    explained = [model.explain(torch.from_numpy(features)[None]) for model in models]
    prediction = three.predict(features)
    for found, index in ((prediction.type_probabilities, 0), (prediction.level_probabilities, 1)):
        expected = np.mean([softmax(answer[index][0].numpy()) for answer in explained], axis=0)
        np.testing.assert_allclose(found, expected, atol=1e-6)
    np.testing.assert_allclose(prediction.attention, np.mean([answer[2][0].numpy() for answer in explained], axis=0))


def test_crop_is_what_the_rows_alone_say(one):
    features = made_features(12)
    cropped, alone = one.predict(features, crop=(3, 8)), one.predict(features[:, 3:8])
    np.testing.assert_array_equal(cropped.type_logits, alone.type_logits)
    assert (cropped.rows, alone.rows) == ((3, 8), (0, 5))
    assert len(cropped.attention) == 5


def test_windows_are_what_their_crops_say(three):
    features = made_features(90)
    windows = three.predict_windows(features, window=10, hop=2, steps_s=0.1)
    assert [window.rows for window in windows] == [(start, start + 10) for start in range(0, 81, 2)]
    for window in windows[::8]:
        alone = three.predict(features, crop=window.rows)
        np.testing.assert_allclose(window.type_logits, alone.type_logits, atol=1e-5)
        np.testing.assert_allclose(window.level_logits, alone.level_logits, atol=1e-5)
        np.testing.assert_allclose(window.attention, alone.attention, atol=1e-5)


def test_recording_shorter_than_the_window_is_one_window(one):
    [only] = one.predict_windows(made_features(4), window=10, hop=3)
    assert only.rows == (0, 4)


def test_features_of_any_float_type_and_order_give_the_same(one):
    features = made_features(9)
    expected = one.predict(features).type_logits
    for other in (features.astype(np.float64), np.asfortranarray(features), features[:, ::-1][:, ::-1]):
        np.testing.assert_allclose(one.predict(other).type_logits, expected, atol=1e-6)


def test_name_and_digest_say_which_weights(one, three, tmp_path):
    assert (one.channels, one.config) == (2, FEASIBLE)
    assert "one.safetensors" in one.name
    assert "mean of 3" in three.name
    assert one.digest != three.digest
    assert FillingPredictor(tmp_path / "one.safetensors").digest == one.digest


@pytest.mark.parametrize(
    "shape", [(9, WIDTH), (1, 9, WIDTH), (2, 9, WIDTH + 1), (2, 0, WIDTH)], ids=["flat", "mono", "wide", "empty"]
)
def test_features_of_another_form_are_refused(one, shape):
    for predict in (one.predict, lambda features: one.predict_windows(features, window=3, hop=1)):
        with pytest.raises(ArgumentError, match=r"features must be \(2, T, 16\)"):
            predict(np.zeros(shape, np.float32))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_features_that_are_not_finite_are_refused(one, value):
    features = made_features(9)
    features[1, 2, 3] = value
    with pytest.raises(ArgumentError, match="features must be finite"):
        one.predict(features)


@pytest.mark.parametrize("crop", [(-1, 3), (4, 4), (5, 3), (0, 10)])
def test_crop_outside_is_refused(one, crop):
    with pytest.raises(ArgumentError, match=r"crop must lie in 0\.\.9"):
        one.predict(made_features(9), crop=crop)


@pytest.mark.parametrize("given", [{"window": 0, "hop": 1}, {"window": 3, "hop": 0}])
def test_windows_without_rows_are_refused(one, given):
    with pytest.raises(ArgumentError, match="window and hop"):
        one.predict_windows(made_features(9), **given)


def test_absent_weights_and_devices_are_refused(tmp_path, one):
    assert one.channels == 2
    with pytest.raises(FileError, match="train one with"):
        FillingPredictor(tmp_path / "absent.safetensors")
    with pytest.raises(ArgumentError, match="device 'abacus'"):
        FillingPredictor(tmp_path / "one.safetensors", device="abacus")


def test_weights_say_what_they_were_trained_on(tmp_path):
    trained = TrainedOn({f"{index:06d}": {"audio": index} for index in range(14)}, is_synthetic=True)
    samples = made_samples(14)
    path = train_filling(tmp_path / "said", samples, preset=replace(JOINT, epochs=1), trained_on=trained)
    assert FillingPredictor(path).trained_on == trained
    path = train_filling(tmp_path / "unsaid", samples, preset=replace(JOINT, epochs=1))
    assert FillingPredictor(path).trained_on is None
