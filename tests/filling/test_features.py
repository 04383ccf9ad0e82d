import dataclasses
import io

import numpy as np
import pytest
import soundfile

from corsmal.dataset import Recording, open_dataset
from corsmal.errors import FileError, NotFoundError
from corsmal.filling import features as module
from corsmal.filling import log_mel
from corsmal.filling.features import recording_features
from corsmal.filling.frontend import LogMelParameters
from corsmal.notes import flags_of
from tests.tiny import write_audio


@pytest.fixture
def heard(tmp_path):
    """A recording of half a second of noise in eight channels."""
    return Recording("000001", audio_path=write_audio(tmp_path / "audio" / "000001.wav", seconds=0.5))


def saved(folder, name, array):
    folder.mkdir(exist_ok=True)
    np.save(folder / f"{name}.npy", array)
    return folder


def test_sound_gives_its_log_mel_rows(heard):
    features = recording_features(heard)
    expected = log_mel(heard.audio().samples)
    assert features.values.shape == expected.shape == (8, 22, 128)
    assert features.values.dtype == np.float32
    assert features.row_s == LogMelParameters().row_s
    np.testing.assert_allclose(features.values, expected, atol=0.005)


def test_stored_features_are_the_computed_ones_and_computed_once(heard, store, monkeypatch):
    unstored = recording_features(heard).values
    first = recording_features(heard, store=store).values
    monkeypatch.setattr(module, "read_audio", lambda *_, **__: pytest.fail("the sound was read again"))
    second = recording_features(heard, store=store).values
    np.testing.assert_array_equal(first, unstored)
    np.testing.assert_array_equal(second, unstored)


def test_sound_that_ended_earlier_is_heard_as_such(heard, store, tmp_path):
    whole = recording_features(heard, store=store).values
    shorter = Recording("000001", audio_path=write_audio(tmp_path / "shorter" / "000001.wav", seconds=0.3))
    cut = recording_features(heard, store=store, end_s=0.3).values
    np.testing.assert_array_equal(cut, recording_features(shorter).values)
    np.testing.assert_array_equal(recording_features(heard, store=store, end_s=9.0).values, whole)
    np.testing.assert_array_equal(recording_features(heard, store=store).values, whole)


def test_arrays_end_earlier_by_their_rows(tmp_path):
    folder = saved(tmp_path, "000001", np.ones((5, 128), np.float32))
    assert recording_features(Recording("000001"), folder=folder, end_s=2.0).values.shape == (1, 2, 128)
    with pytest.raises(NotFoundError, match="no features before 0"):
        recording_features(Recording("000001"), folder=folder, end_s=0.5)


def test_changed_sound_parameters_and_rules_are_computed_anew(heard, store):
    first = recording_features(heard, store=store)
    other = recording_features(heard, parameters=LogMelParameters(hop=2048), store=store)
    assert other.values.shape == (8, 11, 128)
    assert other.row_s == 2 * first.row_s
    write_audio(heard.audio_path, seconds=0.3)
    assert recording_features(heard, store=store).values.shape == (8, 13, 128)
    write_audio(heard.audio_path, seconds=0.3, channels=2)
    repeated = recording_features(heard, channels="repeat", store=store).values
    averaged = recording_features(heard, channels="average", store=store).values
    np.testing.assert_array_equal(repeated[0], repeated[2])
    assert np.abs(repeated[0] - repeated[1]).max() > 1
    np.testing.assert_array_equal(averaged, averaged[:1].repeat(8, axis=0))


def test_broken_entry_of_the_store_is_computed_again(heard, store):
    expected = recording_features(heard, store=store).values
    [path] = store.root.rglob("*.npz")
    path.write_bytes(path.read_bytes()[:100])
    np.testing.assert_array_equal(recording_features(heard, store=store).values, expected)
    assert "computed again" in store.problems[0]


def test_a_store_that_cannot_be_written_stops_nothing(heard, blocked):
    assert recording_features(heard, store=blocked).values.shape == (8, 22, 128)


def test_another_rate_is_resampled(tmp_path):
    path = tmp_path / "a.wav"
    soundfile.write(path, np.random.default_rng(0).normal(0, 0.1, (16_000, 8)), 16_000)
    values = recording_features(Recording("1", audio_path=path)).values
    assert values.shape == (8, 44, 128)
    loud, silent = values[..., :80].mean(), values[..., 110:].mean()  # band 110 begins at 11 kHz
    assert loud - silent > 5


@pytest.mark.parametrize("channels", [1, 2])
def test_another_number_of_channels_is_said(tmp_path, channels):
    recording = Recording("1", audio_path=write_audio(tmp_path / "a.wav", channels=channels))
    with pytest.raises(FileError, match=f"has {channels} channels where the dataset's recordings have 8"):
        recording_features(recording)


def test_silent_recording_is_finite_and_the_same_everywhere(tmp_path):
    soundfile.write(tmp_path / "a.wav", np.zeros((5000, 8)), 44_100)
    values = recording_features(Recording("1", audio_path=tmp_path / "a.wav")).values
    assert values.shape == (8, 5, 128)
    assert np.unique(values).tolist() == [np.float32(np.float16(np.log(1e-7)))]


def test_broken_sound_is_named(tmp_path):
    header = write_audio(tmp_path / "whole.wav", seconds=0.1).read_bytes()[:20]
    (tmp_path / "header.wav").write_bytes(header)
    soundfile.write(tmp_path / "none.wav", np.zeros((0, 8)), 44_100)
    soundfile.write(tmp_path / "nan.wav", np.full((10, 8), np.nan), 44_100, subtype="FLOAT")
    for name, problem in {"header": "cannot be read as sound", "none": "no sound", "nan": "not finite"}.items():
        with pytest.raises(FileError, match=rf"{name}\.wav: .*{problem}"):
            recording_features(Recording("1", audio_path=tmp_path / f"{name}.wav"))


def test_recording_without_sound_is_named(tmp_path):
    with pytest.raises(NotFoundError, match=r"recording 000007 has no sound: audio/000007\.wav is missing"):
        recording_features(Recording("000007"))
    with pytest.raises(FileError, match=r"gone\.wav: cannot be read"):
        recording_features(Recording("000007", audio_path=tmp_path / "gone.wav"))


def test_recording_that_was_not_stopped_is_cut_and_other_long_ones_are_not(tmp_path):
    path = tmp_path / "000377.wav"
    soundfile.write(path, np.random.default_rng(0).normal(0, 0.1, (159 * 8000, 8)).astype(np.float32), 8000)
    cut = recording_features(Recording("000377", audio_path=path, sound_end_s=13.10))
    assert cut.values.shape == (8, 1 + int(13.10 * 44_100) // 1024, 128)
    parameters = LogMelParameters(sample_rate_hz=8000, window=1024, hop=4000)
    whole = recording_features(Recording("000377", audio_path=path), parameters=parameters)
    assert whole.values.shape == (8, 1 + 2 * 159, 128)


def test_rows_of_the_recording_that_was_not_stopped_are_cut_too(tmp_path):
    plain, rows = np.arange(159 * 128.0).reshape(159, 128), np.zeros((2, 6848, 128))
    recording = Recording("000377", sound_end_s=13.10)
    values = recording_features(recording, folder=saved(tmp_path / "a", "000377", plain)).values
    np.testing.assert_array_equal(values[0], plain[:13])  # the 14th row ends at 13.44 s
    assert recording_features(recording, folder=saved(tmp_path / "b", "000377", rows)).values.shape == (2, 565, 128)
    short = saved(tmp_path / "c", "000377", plain[:5])
    assert recording_features(recording, folder=short).values.shape == (1, 5, 128)


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64, ">f4", np.int16])
def test_arrays_are_read_with_and_without_channels(tmp_path, dtype):
    array = np.random.default_rng(0).integers(0, 100, (3, 7, 128)).astype(dtype)
    three = recording_features(Recording("b"), folder=saved(tmp_path, "b", np.asfortranarray(array)))
    one = recording_features(Recording("a"), folder=str(saved(tmp_path, "a", array[1])))
    np.testing.assert_array_equal(three.values, array)
    np.testing.assert_array_equal(one.values, array[1:2])
    assert three.values.dtype == one.values.dtype == np.dtype(np.float32)
    assert (three.row_s, one.row_s) == (LogMelParameters().row_s, 0.96)


def test_an_arrays_name_follows_the_rule_for_ids(tmp_path):
    folder = saved(tmp_path, "618", np.full((7, 128), 3.0))
    saved(tmp_path, "0017", np.full((7, 128), 5.0))
    assert recording_features(Recording("000618"), folder=folder).values.max() == 3
    assert recording_features(Recording("000017"), folder=folder).values.max() == 5
    saved(tmp_path, "000618", np.full((7, 128), 4.0))
    assert recording_features(Recording("000618"), folder=folder).values.max() == 4


def test_real_features_are_read(shared_root):
    folder = shared_root / "features" / "vggish"
    values = recording_features(Recording("000618"), folder=folder).values
    np.testing.assert_array_equal(values[0], np.load(folder / "000618.npy"))
    cut = open_dataset(shared_root / "ccm" / "train")["000377"]
    assert recording_features(cut, folder=folder).values.shape == (1, 13, 128)


def pickled():
    buffer = io.BytesIO()
    np.save(buffer, np.array([{"a": 1}], dtype=object), allow_pickle=True)
    return buffer.getvalue()


def archived():
    buffer = io.BytesIO()
    np.savez(buffer, a=np.zeros((3, 128)))
    return buffer.getvalue()


@pytest.mark.parametrize(
    "content", [b"", b"no array", b"\x93NUMPY\x01\x00", archived(), archived()[:40], pickled()],
    ids=["empty", "text", "header", "archive", "half an archive", "pickle"],
)  # fmt: skip
def test_what_is_no_array_is_named(tmp_path, content):
    (tmp_path / "a.npy").write_bytes(content)
    with pytest.raises(FileError, match=r"a\.npy: is no NumPy array of numbers"):
        recording_features(Recording("a"), folder=tmp_path)


@pytest.mark.parametrize(
    ("array", "problem"),
    [
        (np.zeros((5, 64)), r"has shape \(5, 64\) where \(rows, 128\) or \(channels, rows, 128\) is expected"),
        (np.zeros((128, 5)), r"has shape \(128, 5\)"),
        (np.zeros(128), r"has shape \(128,\)"),
        (np.zeros((0, 128)), r"has shape \(0, 128\)"),
        (np.zeros((8, 0, 128)), r"has shape \(8, 0, 128\)"),
        (np.zeros((1, 8, 5, 128)), r"has shape \(1, 8, 5, 128\)"),
        (np.full((5, 128), np.nan), "not finite"),
        (np.full((5, 128), -np.inf), "not finite"),
        (np.full((5, 128), 1e300), "not finite"),
        (np.zeros((5, 128), complex), "must hold numbers"),
        (np.zeros((5, 128), bool), "must hold numbers"),
        (np.full((5, 128), "a"), "must hold numbers"),
    ],
)
def test_array_of_another_form_is_named(tmp_path, array, problem):
    with pytest.raises(FileError, match=rf"a\.npy: .*{problem}"):
        recording_features(Recording("a"), folder=saved(tmp_path, "a", array))


def test_absent_arrays_and_folders_are_named(tmp_path):
    with pytest.raises(NotFoundError, match=r"recording a has no features: .*a\.npy is missing"):
        recording_features(Recording("a"), folder=tmp_path)
    with pytest.raises(FileError, match="none: there is no such folder of features"):
        recording_features(Recording("a"), folder=tmp_path / "none")


def test_results_are_records_that_cannot_be_reassigned(heard):
    with pytest.raises(dataclasses.FrozenInstanceError):
        recording_features(heard).row_s = 1.0


@pytest.mark.parametrize(("rate", "is_heard"), [(7_999, False), (8_000, True), (16_000, True), (44_100, True)])
def test_a_low_rate_is_said_also_from_the_store_and_too_low_is_refused(tmp_path, store, rate, is_heard):
    path = tmp_path / "audio" / "000001.wav"
    path.parent.mkdir()
    soundfile.write(path, np.random.default_rng(0).uniform(-0.1, 0.1, (rate // 5, 8)), rate)
    recording = Recording("000001", audio_path=path)
    if not is_heard:
        with pytest.raises(FileError, match=r"recorded at 7.999 kHz, too low for a prediction; record at 44.1 kHz"):
            recording_features(recording, store=store)
        return
    for _ in range(2):
        notes = recording_features(recording, store=store).notes
        assert flags_of(notes) == (("sound-outside-training",) if rate < 44_100 else ())
        assert all(f"{rate / 1000:g} kHz" in note for note in notes)


def test_a_cut_raises_a_flag(tmp_path):
    path = write_audio(tmp_path / "a.wav", seconds=0.3)
    heard = recording_features(Recording("000377", audio_path=path, sound_end_s=0.2))
    assert (heard.notes, flags_of(heard.notes)) == (
        ("it was cut at 0.2 s, its recorder was not stopped",),
        ("sound-cut",),
    )
