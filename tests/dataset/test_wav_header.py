"""Sound as recorders write it: every file holds the same ramp, and a damaged header costs none of it."""

import struct

import numpy as np
import pytest
import soundfile

from corsmal.dataset.audio import check_audio, read_audio
from corsmal.errors import FileError
from corsmal.notes import flags_of

RATE, SAMPLES = 44_100, 4_410
RAMP = (np.arange(SAMPLES)[:, None] * np.arange(1, 9) % 30_000).astype(np.int16)
REPAIRED = ("sound-repaired",)


def whole(tmp_path, subtype="PCM_16", rate=RATE):
    path = tmp_path / "whole.wav"
    soundfile.write(path, RAMP if subtype.startswith("PCM") else RAMP / 32_768, rate, subtype=subtype)
    content = bytearray(path.read_bytes())
    return content, content.index(b"data")


def read(tmp_path, content):
    path = tmp_path / "a.wav"
    path.write_bytes(content)
    audio = read_audio(path)
    assert flags_of(check_audio(path)) == flags_of(audio.notes)
    return audio


def sized(content, at, data, riff=None):
    content[at + 4 : at + 8] = struct.pack("<I", data)
    content[4:8] = struct.pack("<I", len(content) - 8 if riff is None else riff)
    return content


@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24", "PCM_32", "FLOAT", "DOUBLE"])
def test_a_whole_file_is_read_by_its_header(tmp_path, subtype):
    audio = read(tmp_path, whole(tmp_path, subtype)[0])
    np.testing.assert_array_equal(audio.samples.T * 32_768, RAMP)
    assert audio.notes == ()


@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24", "FLOAT"])
@pytest.mark.parametrize("sizes", [(0, 0), (0, None), (0xFFFFFFFF, 0xFFFFFFFF), (800, 836), (8, None), (2**31, 0)])
def test_a_header_that_was_not_finished_costs_no_sound(tmp_path, sizes, subtype):
    audio = read(tmp_path, sized(*whole(tmp_path, subtype), *sizes))
    np.testing.assert_array_equal(audio.samples.T * 32_768, RAMP)
    assert flags_of(audio.notes) == REPAIRED
    assert "header" in audio.notes[0]


def test_a_file_that_breaks_off_is_read_as_far_as_it_goes(tmp_path):
    content, at = whole(tmp_path)
    audio = read(tmp_path, content[: at + 8 + 16 * 1000 + 5])
    np.testing.assert_array_equal(audio.samples.T * 32_768, RAMP[:1000])
    assert audio.notes == ("it breaks off: its header promises 0.10 s of sound",)
    assert flags_of(audio.notes) == REPAIRED


@pytest.mark.parametrize(("padding", "flags"), [(b"", REPAIRED), (b"\0", ())])
@pytest.mark.parametrize("name", [b"LIST", b"bext", b"junk"])
def test_a_missing_padding_byte_is_made_up_for(tmp_path, name, padding, flags):
    content, at = whole(tmp_path)
    content[at:at] = name + struct.pack("<I", 5) + b"abcde" + padding
    audio = read(tmp_path, content)
    np.testing.assert_array_equal(audio.samples.T * 32_768, RAMP)
    assert flags_of(audio.notes) == flags


@pytest.mark.parametrize("rest", [b"LIST" + struct.pack("<I", 4) + b"INFO", b"\0" * 40, b"TAG"])
def test_what_follows_the_samples_is_no_sound(tmp_path, rest):
    audio = read(tmp_path, whole(tmp_path)[0] + rest)
    assert (audio.samples.shape, audio.notes) == ((8, SAMPLES), ())


@pytest.mark.parametrize(("bits", "subtype"), [(16, "FLOAT"), (24, "FLOAT"), (32, "FLOAT"), (16, "DOUBLE")])
def test_floating_samples_in_the_scale_of_whole_numbers_are_divided(tmp_path, bits, subtype):
    path = tmp_path / "a.wav"
    soundfile.write(path, RAMP / 32_768 * 2.0 ** (bits - 1), RATE, subtype=subtype)
    for end_s in (None, 0.01):
        audio = read_audio(path, end_s=end_s)
        np.testing.assert_allclose(audio.samples.T * 32_768, RAMP[: audio.samples.shape[1]], rtol=1e-6)
        assert f"were taken for {bits} bit numbers" in audio.notes[0]
        assert flags_of(audio.notes) == REPAIRED
    assert flags_of(check_audio(path)) == REPAIRED


def test_floating_samples_a_little_beyond_full_scale_stay(tmp_path):
    soundfile.write(tmp_path / "a.wav", RAMP / 20_000, RATE, subtype="FLOAT")
    audio = read_audio(tmp_path / "a.wav")
    assert (audio.notes, round(float(audio.samples.max()), 3)) == ((), 1.5)


def test_samples_in_no_known_scale_are_refused(tmp_path):
    soundfile.write(tmp_path / "a.wav", RAMP * 1e9, RATE, subtype="FLOAT")
    with pytest.raises(FileError, match="where -1 to 1 is expected; save it as 16 bit WAV"):
        read_audio(tmp_path / "a.wav")


@pytest.mark.parametrize(("rate", "flags"), [(16_000, True), (44_000, True), (44_100, False), (48_000, False)])
def test_a_rate_below_the_datasets_is_said(tmp_path, rate, flags):
    audio = read(tmp_path, whole(tmp_path, rate=rate)[0])
    assert flags_of(audio.notes) == (("sound-outside-training",) if flags else ())
    assert all(f"recorded at {rate / 1000:g} kHz" in note for note in audio.notes)


def test_a_sound_that_is_too_long_is_refused_before_it_is_read(tmp_path):
    content, at = whole(tmp_path)
    for size in (2**32 - 400, 0):
        with (tmp_path / "a.wav").open("wb") as file:
            file.write(sized(content[: at + 8], at, size))
            file.truncate(2**32 - 300)
        with pytest.raises(FileError, match="are read; cut it"):
            read_audio(tmp_path / "a.wav")


@pytest.mark.parametrize(("at", "value"), [(24, b"\xff\xff\xff\xf0"), (24, bytes(4)), (22, b"\xff\xff"), (22, b"\0\0")])
def test_a_header_that_cannot_be_is_one_sentence(tmp_path, at, value):
    content, data = whole(tmp_path)
    content[at : at + len(value)] = value
    (tmp_path / "a.wav").write_bytes(sized(content, data, 0))
    with pytest.raises(FileError) as caught:
        read_audio(tmp_path / "a.wav")
    assert "\n" not in str(caught.value)
