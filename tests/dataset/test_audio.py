from pathlib import Path

import numpy as np
import pytest
import soundfile

from corsmal.dataset.audio import read_audio
from corsmal.errors import ArgumentError, FileError
from tests.tiny import write_audio


def test_samples_are_read_channel_by_channel(tmp_path: Path) -> None:
    steps = np.arange(100)[:, None] * np.arange(1, 9)
    soundfile.write(tmp_path / "a.wav", steps.astype(np.int16), 44_100, subtype="PCM_16")
    audio = read_audio(tmp_path / "a.wav")
    assert audio.sample_rate_hz == 44_100
    assert audio.samples.dtype == np.float32
    for channel in range(8):
        np.testing.assert_array_equal(audio.samples[channel] * 32_768, np.arange(100) * (channel + 1))


def test_samples_cannot_be_changed(tmp_path: Path) -> None:
    audio = read_audio(write_audio(tmp_path / "a.wav", seconds=0.1))
    with pytest.raises(ValueError, match="read-only"):
        audio.samples[0, 0] = 1


def test_other_rates_are_kept(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", np.zeros((800, 8)), 16_000)
    audio = read_audio(tmp_path / "a.wav")
    assert (audio.sample_rate_hz, audio.duration_s) == (16_000, 0.05)


@pytest.mark.parametrize(("end_s", "expected"), [(0.05, 2205), (0.1, 4410), (7.0, 4410), (None, 4410)])
def test_cut_shortens_only_longer_files(tmp_path: Path, end_s: float | None, expected: int) -> None:
    path = write_audio(tmp_path / "a.wav", seconds=0.1)
    cut = read_audio(path, end_s=end_s).samples
    assert cut.shape == (8, expected)
    np.testing.assert_array_equal(cut, read_audio(path).samples[:, :expected])


@pytest.mark.parametrize("channels", [1, 2, 7, 9])
def test_another_number_of_channels_is_said(tmp_path: Path, channels: int) -> None:
    path = write_audio(tmp_path / "a.wav", seconds=0.01, channels=channels)
    with pytest.raises(FileError, match=rf"a\.wav: has {channels} channels where the dataset's recordings have 8"):
        read_audio(path)


@pytest.mark.parametrize(
    ("found", "repeated", "mean"),
    [
        (1, [1, 1, 1, 1, 1, 1, 1, 1], 1),
        (2, [1, 2, 1, 2, 1, 2, 1, 2], 1.5),
        (3, [1, 2, 3, 1, 2, 3, 1, 2], 2),
        (8, [1, 2, 3, 4, 5, 6, 7, 8], None),
        (10, [1, 2, 3, 4, 5, 6, 7, 8], 5.5),
    ],
)
def test_channels_are_repeated_or_averaged_when_asked(
    tmp_path: Path, found: int, repeated: list[int], mean: float | None
) -> None:
    path = tmp_path / "a.wav"
    soundfile.write(path, np.tile(np.arange(1, found + 1) / 64, (20, 1)), 44_100, subtype="FLOAT")
    np.testing.assert_array_equal(read_audio(path, channels="repeat").samples[:, 0] * 64, repeated)
    expected = repeated if mean is None else [mean] * 8
    np.testing.assert_allclose(read_audio(path, channels="average").samples[:, 19] * 64, expected)


def test_unknown_rule_for_channels_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ArgumentError, match="channels must be one of strict, repeat, average, got 'mono'"):
        read_audio(tmp_path / "a.wav", channels="mono")  # type: ignore[arg-type]


def test_broken_files_are_named(tmp_path: Path) -> None:
    header = write_audio(tmp_path / "whole.wav", seconds=0.1).read_bytes()[:20]
    for name, content in {"empty.wav": b"", "text.wav": b"no sound" * 50, "header.wav": header}.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(FileError, match=f"{name}: "):
            read_audio(tmp_path / name)


def test_truncated_file_gives_what_is_there(tmp_path: Path) -> None:
    path = write_audio(tmp_path / "a.wav", seconds=0.1)
    whole = read_audio(path).samples
    path.write_bytes(path.read_bytes()[: 44 + 1000 * 16])
    np.testing.assert_array_equal(read_audio(path).samples[:, :900], whole[:, :900])


def test_silent_length_zero_and_infinite_samples_are_errors(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "none.wav", np.zeros((0, 8)), 44_100)
    with pytest.raises(FileError, match="holds no sound"):
        read_audio(tmp_path / "none.wav")
    soundfile.write(tmp_path / "nan.wav", np.full((10, 8), np.nan), 44_100, subtype="FLOAT")
    with pytest.raises(FileError, match="not finite"):
        read_audio(tmp_path / "nan.wav")


def test_absent_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"a\.wav: there is no such sound file"):
        read_audio(tmp_path / "a.wav")


@pytest.mark.parametrize(
    ("form", "subtype", "endian", "digits"),
    [
        ("WAV", "PCM_24", "FILE", 6),
        ("WAV", "PCM_32", "FILE", 7),
        ("WAV", "PCM_U8", "FILE", 2),
        ("WAV", "DOUBLE", "FILE", 7),
        ("WAV", "PCM_16", "BIG", 4),
        ("WAVEX", "PCM_16", "FILE", 4),
        ("RF64", "PCM_16", "FILE", 4),
        ("W64", "PCM_16", "FILE", 4),
        ("AIFF", "PCM_16", "FILE", 4),
        ("FLAC", "PCM_16", "FILE", 4),
    ],
)
def test_other_forms_of_a_file_named_wav_hold_the_same_samples(
    tmp_path: Path, form: str, subtype: str, endian: str, digits: int
) -> None:
    samples = np.random.default_rng(0).uniform(-0.5, 0.5, (500, 8))
    path = tmp_path / "a.WAV"
    soundfile.write(path, samples, 48_000, format=form, subtype=subtype, endian=endian)
    found = read_audio(path)
    assert (found.sample_rate_hz, found.notes) == (48_000, ())
    np.testing.assert_allclose(found.samples.T, samples, atol=10.0**-digits)
