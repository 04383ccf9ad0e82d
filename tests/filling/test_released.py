"""The authors' filling network: its answers, and files and waveforms that are refused."""

import json
import warnings
from dataclasses import replace

import numpy as np
import pytest
import soundfile
import torch
from scipy import signal

from corsmal.errors import ArgumentError
from corsmal.filling import (
    FillingConfig,
    FillingModel,
    FillingPredictor,
    LogMelParameters,
    log_mel,
    read_filling,
    released,
)
from corsmal.weights import RELEASED
from tests.filling.made import SMALL, made_features
from tests.released import random_state, slow_filling, slow_log_mel, write_released

RATE_HZ = 44_100
PARAMETERS = LogMelParameters.of("released")


def noise(samples=5000, *, seed=0, channels=8):
    return np.random.default_rng(seed).normal(0, 0.05, (channels, samples)).astype(np.float32)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return write_released(tmp_path_factory.mktemp("released"))["filling"]


def test_answers_to_a_real_sound_are_those_of_the_authors_program(shared_root, real_dataset_root):
    folder = shared_root / "reference" / "released"
    [(name, expected)] = json.loads((folder / "networks_expected.json").read_text())["filling"].items()
    assert name == "000618_0.5s_to_2s"
    samples, rate_hz = soundfile.read(real_dataset_root / "audio" / "000618.wav", dtype="float32")
    part = samples.T[:, rate_hz // 2 : 2 * rate_hz]
    types, levels = released.logits(folder / "task1and2_random.pt", part, sample_rate_hz=rate_hz)
    np.testing.assert_allclose(types, expected["type_logits"], rtol=1e-4)
    np.testing.assert_allclose(levels, expected["level_logits"], rtol=1e-4)
    assert log_mel(part, parameters=PARAMETERS).shape == tuple(expected["shape"][1:])


@pytest.mark.parametrize(("samples", "seed"), [(2048, 1), (5000, 2)])
def test_answers_are_those_of_the_slow_way(tmp_path, samples, seed):
    path, waveform = write_released(tmp_path, seed=seed)["filling"], noise(samples, seed=seed)
    types, levels = released.logits(path, waveform, sample_rate_hz=RATE_HZ)
    assert (types.shape, levels.shape) == ((4,), (3,))
    slow = slow_filling(random_state("filling", seed=seed), waveform.astype(np.float64))
    np.testing.assert_allclose(types, slow[0], rtol=1e-3, atol=1e-4)
    np.testing.assert_allclose(levels, slow[1], rtol=1e-3, atol=1e-4)


def test_front_end_reflects_the_edges_and_takes_a_logarithm_without_a_floor():
    waveform = noise(3500, channels=2)
    np.testing.assert_allclose(
        log_mel(waveform, parameters=PARAMETERS), slow_log_mel(waveform.astype(np.float64)), atol=2e-3
    )
    waveform[1, 1000:] = 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rows = log_mel(waveform, parameters=PARAMETERS)
    assert np.isfinite(rows[0]).all()
    assert np.isneginf(rows[1, 3]).all()


def test_sound_at_another_rate_is_resampled_first(path):
    waveform = noise(4000)
    resampled = signal.resample_poly(waveform, 2, 1, axis=1)
    for found, expected in zip(
        released.logits(path, waveform, sample_rate_hz=RATE_HZ // 2),
        released.logits(path, resampled, sample_rate_hz=RATE_HZ),
        strict=True,
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-5)


@pytest.mark.parametrize(
    ("waveform", "message"),
    [
        (noise(channels=7), r"must have shape \(8, samples\), got \(7, 5000\)"),
        (noise(channels=9), r"must have shape \(8, samples\), got \(9, 5000\)"),
        (noise()[0], r"must have shape \(8, samples\)"),
        (noise(2047), "at least a window long, 2048 samples at 44100 Hz, got 2047"),
        (noise(0), "both at least 1"),
        (np.zeros((8, 5000), np.float32), "silent in a microphone at row 0"),
        (np.vstack([noise(9000)[:7], np.zeros((1, 9000), np.float32)]), "silent in a microphone at row 0"),
        (np.full((8, 5000), np.nan, np.float32), "finite numbers"),
        (np.ones((8, 5000), np.int16), "floating numbers"),
    ],
)
def test_other_waveforms_are_refused_in_a_sentence(path, waveform, message):
    with pytest.raises(ArgumentError, match=message):
        released.logits(path, waveform, sample_rate_hz=RATE_HZ)


def test_predictor_answers_as_the_function_does_and_names_the_network(path):
    predictor, waveform = FillingPredictor(path), noise()
    assert predictor.front_end == PARAMETERS
    rows = log_mel(waveform, parameters=predictor.front_end)
    prediction = predictor.predict(rows)
    types, levels = released.logits(path, waveform, sample_rate_hz=RATE_HZ)
    np.testing.assert_allclose(prediction.type_logits, types, rtol=1e-5)
    np.testing.assert_allclose(prediction.level_logits, levels, rtol=1e-5)
    assert prediction.attention.shape == (rows.shape[1],)
    assert predictor.digest.startswith(f"{RELEASED}filling network ")
    assert "task1and2.pt" in predictor.name
    assert predictor.trained_on is None


def test_windows_and_crops_around_silence_are_predicted_and_silence_is_not(path):
    predictor, waveform = FillingPredictor(path), noise(40 * 1024)
    waveform[3, 10 * 1024 : 14 * 1024] = 0
    rows = log_mel(waveform, parameters=predictor.front_end)
    silent = np.flatnonzero(np.isneginf(rows).any(axis=(0, 2)))
    assert silent.tolist() == [11, 12, 13]
    assert predictor.predict(rows, crop=(0, 11)).ok
    with pytest.raises(ArgumentError, match=r"silent in a microphone at 0\.55 s"):
        predictor.predict(rows, steps_s=0.05)
    windows = predictor.predict_windows(rows, window=4, hop=2)
    starts = [window.rows[0] for window in windows]
    assert starts == [start for start in range(0, 38, 2) if not 8 <= start <= 13]
    with pytest.raises(ArgumentError, match="silent in a microphone at row 11"):
        predictor.predict(rows, crop=(11, 14))
    with pytest.raises(ArgumentError, match="silent in a microphone at row 0"):
        predictor.predict_windows(rows[:, 11:14], window=3, hop=1)


def test_tensors_of_the_file_become_those_of_the_network(path):
    [model] = read_filling(path)
    state = random_state("filling")
    assert not model.training
    assert model.config == FillingConfig.released()
    cls = state["encoder.transformer.cls_token_adder.gen_cls_token.weight"][:, 0]
    assert torch.equal(model.cls, cls * state["encoder.transformer.cls_token_adder.ones"])
    assert torch.equal(model.first_position, state["encoder.transformer.pe.pos_e"][0, 0])
    first = FillingModel(FillingConfig.released()).first_position
    assert first[:4].tolist() == [0, 1, 0, 1]


@torch.inference_mode()
def test_rows_have_an_order_only_with_positions_of_the_sequence():
    features = torch.from_numpy(made_features(9))[None]
    for positions in ("sequence", "first"):
        torch.manual_seed(0)
        model = FillingModel(replace(SMALL, positions=positions)).eval()
        model.cnn.depthwise.weight[:, :, [0, 1, 3, 4]] = 0  # of the neighbouring rows
        is_order_known = not torch.allclose(model(features)[0], model(features.flip(2))[0], atol=1e-5)
        assert is_order_known == (positions == "sequence")


@torch.inference_mode()
def test_other_deviations_are_switches_of_the_same_network():
    layers = {
        name: [type(layer).__name__ for layer in FillingModel(replace(SMALL, **change)).modules()]
        for name, change in {
            "paper": {},
            "norms": {"norms": "shared"},
            "activation": {"activation": "squared relu"},
            "encoder": {"encoder": "normalised"},
        }.items()
    }
    assert [layers[name].count("LayerNorm") for name in layers] == [4, 2, 4, 4]
    assert [layers[name].count("SquaredReLU") for name in layers] == [0, 0, 2, 0]
    assert [layers[name].count("GELU") for name in layers] == [4, 4, 0, 4]
    assert [layers[name].count("BatchNorm1d") for name in layers] == [0, 0, 0, 1]


def test_batch_norm_learns_from_the_recordings_own_rows_only():
    config = replace(SMALL, encoder="normalised", standardise=False)
    recordings = [made_features(rows, seed=rows) * 2 + 3 for rows in (3, 8)]
    batch, mask = torch.full((2, 2, 8, 16), 1e3), torch.zeros(2, 8, dtype=torch.bool)
    for index, features in enumerate(recordings):
        batch[index, :, : features.shape[1]] = torch.from_numpy(features)
        mask[index, : features.shape[1]] = True
    model = FillingModel(config).train()
    model(batch, mask)
    rows = np.concatenate([features.reshape(2, -1) for features in recordings], axis=1)
    np.testing.assert_allclose(model.cnn.norm.running_mean, 0.1 * rows.mean(axis=1), rtol=1e-4)
    np.testing.assert_allclose(model.cnn.norm.running_var, 0.9 + 0.1 * rows.var(axis=1, ddof=1), rtol=1e-4)
