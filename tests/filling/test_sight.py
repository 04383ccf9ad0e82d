import os

import numpy as np
import pytest
import torch

from corsmal.dataset import open_dataset
from corsmal.errors import ArgumentError, FileError, NotFoundError
from corsmal.estimation import estimate
from corsmal.filling import FillingConfig, FillingModel, FillingPredictor, FusedPredictor, open_filling, save_filling
from corsmal.filling.config import PooledConfig, RecurrentConfig
from corsmal.filling.features import Features, recording_features
from corsmal.filling.fused import FusedConfig, FusedModel, save_fused
from corsmal.filling.fused_prediction import predicted_from, predicted_until, predicted_within
from corsmal.filling.sight import ROW_S, FeatureFolders, Senses, part_of, recording_senses, sight_features
from corsmal.parameters import ShapeParameters
from corsmal.stages.estimates import Predictors, estimate_key, estimate_with
from corsmal.stages.settings import default_settings
from tests.tiny import write_tiny_dataset


def write_array(folder, name, *shape, seed=0):
    folder.mkdir(exist_ok=True)
    values = np.random.default_rng(seed).normal(size=shape).astype(np.float16)
    np.save(folder / f"{name}.npy", values)
    return values


@pytest.fixture
def fused(tmp_path):
    torch.manual_seed(0)
    model = FusedModel(FusedConfig((RecurrentConfig(hidden=2),), (PooledConfig(hidden=2),)))
    save_fused(tmp_path / "fused.safetensors", model.eval())
    return FusedPredictor(tmp_path / "fused.safetensors")


@pytest.fixture
def recording(tmp_path):
    return open_dataset(write_tiny_dataset(tmp_path / "set", recordings=1, frames=3))["000000"]


def test_arrays_are_read_in_single_precision_until_a_time(tmp_path):
    values = write_array(tmp_path / "seen", "000000", 3, 4, 512)
    found = sight_features(tmp_path / "seen", "000000")
    assert found.dtype == np.float32
    assert np.array_equal(found, values.astype(np.float32))
    # a clip is 16 of 30 frames a second: two have ended after 1.5 s
    assert sight_features(tmp_path / "seen", "000000", end_s=1.5).shape == (3, 2, 512)
    with pytest.raises(NotFoundError, match=r"before 0\.50 s"):
        sight_features(tmp_path / "seen", "000000", end_s=0.5)
    write_array(tmp_path / "seen", "000001", 2, 4, 512)
    with pytest.raises(FileError, match=r"shape \(2, 4, 512\)"):
        sight_features(tmp_path / "seen", "000001")


def test_folders_are_told_apart_by_their_arrays(tmp_path):
    write_array(tmp_path / "heard", "000000", 5, 128)
    write_array(tmp_path / "seen", "000000", 3, 4, 512)
    heard, seen = tmp_path / "heard", tmp_path / "seen"
    assert FeatureFolders.of([seen, heard]) == FeatureFolders(sound=heard, sight=seen)
    assert FeatureFolders.of([]) == FeatureFolders()
    with pytest.raises(FileError, match="holds features of sight, as does"):
        FeatureFolders.of([seen, seen])
    (tmp_path / "empty").mkdir()
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "000000.npy").write_bytes(b"none")
    for name, text in (("absent", "no such folder"), ("empty", "no arrays"), ("broken", "no NumPy array")):
        with pytest.raises(FileError, match=text):
            FeatureFolders.of([tmp_path / name])


def test_either_sense_may_be_missing_and_a_note_says_so(tmp_path, recording, fused):
    heard, seen = tmp_path / "heard", tmp_path / "seen"
    heard.mkdir()
    sight = write_array(seen, "000000", 3, 4, 512).astype(np.float32)
    only_seen = recording_senses(recording, sight=seen, folder=heard)
    assert only_seen.sound is None
    assert "has no features" in only_seen.notes[0]
    expected = fused.predict(None, sight=sight)
    assert predicted_from(only_seen, fused).probabilities == expected.probabilities
    sound = write_array(heard, "000000", 5, 128).astype(np.float32)[None]
    both = predicted_from(recording_senses(recording, sight=seen, folder=heard), fused)
    assert both.probabilities == fused.predict(sound, sight=sight).probabilities
    assert both.steps_s == 0.96
    (seen / "000000.npy").unlink()
    only_heard = recording_senses(recording, sight=seen, folder=heard)
    assert predicted_from(only_heard, fused).probabilities == fused.predict(sound).probabilities
    (heard / "000000.npy").unlink()
    with pytest.raises(NotFoundError, match=r"heard.*seen"):
        recording_senses(recording, sight=seen, folder=heard)


def test_an_estimate_is_made_from_both_and_kept_by_both(tmp_path, recording, fused):
    heard, seen = tmp_path / "heard", tmp_path / "seen"
    write_array(heard, "000000", 5, 128)
    write_array(seen, "000000", 3, 4, 512)
    hearing = Predictors(filling=fused, features=heard)
    watching = Predictors(filling=fused, features=heard, sight=seen)
    own = {name: estimate_with(made, recording, {}).filling for name, made in (("h", hearing), ("w", watching))}
    assert own["h"].sight is None
    assert own["w"].sight is not None
    assert own["w"].probabilities != own["h"].probabilities
    before = estimate_key(recording, watching, "")
    assert before != estimate_key(recording, hearing, "")
    write_array(seen, "000000", 3, 6, 512)
    assert estimate_key(recording, watching, "") != before


def test_network_of_sound_refuses_sight(tmp_path, recording):
    write_array(tmp_path / "seen", "000000", 3, 4, 512)
    path = tmp_path / "filling.safetensors"
    save_filling(path, [FillingModel(FillingConfig.paper()).eval()])
    predictor = open_filling(path)
    assert isinstance(predictor, FillingPredictor)
    with pytest.raises(ArgumentError, match="reads sound only"):
        predicted_from(recording_senses(recording, sight=tmp_path / "seen"), predictor)
    found = estimate(recording, filling=predictor, features=lambda _: recording_features(recording))
    assert found.filling.ok


def test_file_of_a_fused_network_is_opened_as_one(tmp_path, fused):
    assert isinstance(open_filling(tmp_path / "fused.safetensors"), FusedPredictor)
    with pytest.raises(FileError):
        open_filling(tmp_path / "absent.safetensors")
    assert fused.config.sight == (PooledConfig(hidden=2),)


@pytest.mark.usefixtures("recording")
def test_folders_of_the_environment_are_told_apart(tmp_path, monkeypatch):
    assert FeatureFolders.in_environment() == FeatureFolders()
    write_array(tmp_path / "heard", "000000", 5, 128)
    write_array(tmp_path / "seen", "000000", 3, 4, 512)
    monkeypatch.setenv("CORSMAL_FEATURES", f"{tmp_path / 'seen'}{os.pathsep}{tmp_path / 'heard'}")
    assert FeatureFolders.in_environment() == FeatureFolders(sound=tmp_path / "heard", sight=tmp_path / "seen")
    settings = default_settings(open_dataset(tmp_path / "set"), shape=ShapeParameters.paper())
    assert (settings.features, settings.sight) == (tmp_path / "heard", tmp_path / "seen")
    monkeypatch.setenv("CORSMAL_FEATURES", str(tmp_path / "none"))
    with pytest.raises(FileError, match="no such folder"):
        FeatureFolders.in_environment()


def senses(sound_rows=4, sight_rows=6, *, row_s=0.96):
    rng = np.random.default_rng(0)
    sound = Features(rng.normal(size=(1, sound_rows, 128)).astype(np.float32), row_s)
    return Senses(sound, rng.normal(size=(3, sight_rows, 512)).astype(np.float32), ())


@pytest.mark.parametrize(
    ("stretch_s", "sound_rows", "sight_rows"),
    [
        ((0.0, 9.0), (0, 4), (0, 6)),
        ((0.0, 2 * 0.96), (0, 2), (0, 3)),  # three clips have ended after 1.6 s, a fourth ends after 2.13 s
        ((0.5, 2.0), (1, 2), (1, 3)),
        ((0.0, 0.6), None, (0, 1)),
        ((3 * ROW_S, 9.0), (2, 4), (3, 6)),
    ],
)
def test_rows_of_a_stretch_lie_within_it_whole(stretch_s, sound_rows, sight_rows):
    given = senses()
    part = part_of(given, *stretch_s)
    expected = None if sound_rows is None else given.sound.values[:, slice(*sound_rows)]
    assert (part.sound is None) == (expected is None)
    assert expected is None or np.array_equal(part.sound.values, expected)
    assert np.array_equal(part.sight, given.sight[:, slice(*sight_rows)])


def test_log_mel_rows_are_instants_and_a_stretch_without_any_row_is_refused():
    given = senses(100, 1, row_s=0.02)
    assert part_of(given, 0.1, 0.2).sound.values.shape[1] == 6
    with pytest.raises(NotFoundError, match=r"between 0\.50 and 0\.60 s"):
        part_of(senses(), 0.5, 0.6)
    assert given.duration_s == pytest.approx(2.0)
    assert senses(1, 6).duration_s == pytest.approx(6 * ROW_S)


def test_what_was_said_until_a_time_is_what_is_said_of_the_rows_until_then(fused):
    given = senses()
    moments = predicted_until(given, fused, [0.1, 0.6, 2.0])
    assert [time_s for time_s, _ in moments] == [0.6, 2.0]
    assert moments[0][1].sound is None
    expected = fused.predict(given.sound.values[:, :2], sight=given.sight[:, :3])
    assert np.array_equal(moments[1][1].level_logits, expected.level_logits)
    assert np.array_equal(predicted_within(given, fused, (0.0, 2.0)).level_logits, expected.level_logits)


def test_without_a_folder_of_sight_only_the_sound_is_given_and_that_is_said(recording, tmp_path):
    write_array(tmp_path / "heard", "000000", 5, 128)
    found = recording_senses(recording, sight=None, folder=tmp_path / "heard")
    assert found.sight is None
    assert "CORSMAL_FEATURES" in found.notes[0]
