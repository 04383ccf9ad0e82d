"""The recordings' sound: eight microphones in one file, WAV or FLAC."""

import io
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import soundfile
from numpy.typing import NDArray

from corsmal.dataset.wav_header import WavRepair, find_repair
from corsmal.errors import FileError, check_choice
from corsmal.notes import Note

CHANNELS = 8
"""Microphones of the dataset's two circular arrays."""

SAMPLE_RATE_HZ = 44_100
"""Of the dataset's sound."""

VALUES_MAX = 8 * 48_000 * 300
"""Samples of all channels that are read at most: five minutes of eight. The dataset's recordings last half a minute."""

PEAK_MAX = 8.0
"""Floating samples beyond this, or whole numbers beyond 1, are those of an integer format that were not divided."""

CHECKED_S = 0.001

ChannelRule = Literal["strict", "repeat", "average"]
"""What to do with a sound of another number of channels than eight: ``strict`` refuses it; ``repeat`` takes its
channels in turn until there are eight; ``average`` gives all eight the mean."""

_FLOATING = ("FLOAT", "DOUBLE")
_FULL_SCALES = {16: 2.0**15, 24: 2.0**23, 32: 2.0**31}
"""What the samples of an integer format are divided by, by its bits."""


@dataclass(frozen=True, eq=False)
class Audio:
    """The sound of one recording.

    Args:
        samples: (8, S) float32 in -1..1, one row per microphone, read-only.
        sample_rate_hz: samples per second and microphone.
        notes: sentences on what was repaired, and on a rate below the dataset's.
    """

    samples: NDArray[np.float32]
    sample_rate_hz: int
    notes: tuple[str, ...] = ()

    @property
    def duration_s(self) -> float:
        """Length in seconds."""
        return self.samples.shape[1] / self.sample_rate_hz


def check_audio(path: str | Path) -> tuple[str, ...]:
    """Read a sound file's header; one of floating samples is read whole, to see their scale.

    Returns:
        ``Audio.notes``.

    Raises:
        FileError: the file is absent or no sound file, is empty, or has another number of channels than eight.
    """
    return read_audio(path, end_s=CHECKED_S).notes


def read_audio(path: str | Path, *, end_s: float | None = None, channels: ChannelRule = "strict") -> Audio:
    """Read a sound file.

    A WAV file is read to its end where its header was not finished or names fewer samples than there are, and
    floating samples in the scale of an integer format are divided by its full scale; ``Audio.notes`` says so.

    Args:
        path: a WAV or FLAC file of eight channels, at any sampling rate.
        end_s: where to cut, in seconds from the start; None reads to the end.
        channels: how another number of channels is made eight; default: not at all.

    Raises:
        ArgumentError: there is no such rule for channels.
        FileError: the file is absent or no sound file, is empty, lasts too long, has another number of channels, or
            holds samples that are not finite or in no known scale.
    """
    check_choice("channels", channels, get_args(ChannelRule))
    path = Path(path)
    if not path.is_file():
        raise FileError(path, "there is no such sound file")
    try:
        repair = find_repair(path)
        with _opened(path, repair) as file:
            found = _read(path, file, end_s=end_s, is_strict=channels == "strict")
    except (soundfile.SoundFileError, OSError) as error:
        raise FileError(path, f"cannot be read as sound ({error}); download it again") from error
    notes = (*_repair_notes(repair), *found.notes, *_rate_notes(found.sample_rate_hz))
    samples = found.samples
    if len(samples) != CHANNELS:
        source = samples.mean(axis=0, keepdims=True) if channels == "average" else samples
        samples = source[np.arange(CHANNELS) % source.shape[0]]
    samples = np.ascontiguousarray(samples)
    samples.flags.writeable = False
    return replace(found, samples=samples, notes=notes)


def _opened(path: Path, repair: WavRepair | None) -> soundfile.SoundFile:
    """The open file, or its samples where the header cannot be followed."""
    if repair is None:
        return soundfile.SoundFile(path)
    if repair.values > VALUES_MAX:
        raise FileError(path, "holds more sound than the five minutes of eight channels that are read; cut it")
    with path.open("rb") as file:
        file.seek(repair.start)
        content = io.BytesIO(file.read(repair.end - repair.start))
    return soundfile.SoundFile(
        content,
        format="RAW",
        subtype=repair.subtype,
        endian="LITTLE",
        channels=repair.channels,
        samplerate=repair.sample_rate_hz,
    )


def _read(path: Path, file: soundfile.SoundFile, *, end_s: float | None, is_strict: bool) -> Audio:
    """All channels of the file, (channels, S), up to ``end_s``."""
    rate, found = int(file.samplerate), int(file.channels)
    if found != CHANNELS and is_strict:
        raise FileError(path, f"has {found} channels where the dataset's recordings have {CHANNELS}")
    end = file.frames if end_s is None else min(file.frames, round(end_s * rate))
    is_floating = file.subtype in _FLOATING  # the scale of all its samples counts, whatever is left out
    wanted = file.frames if is_floating else end
    if wanted * found > VALUES_MAX:
        limit_s = VALUES_MAX / found / rate
        raise FileError(path, f"lasts {file.frames / rate:.0f} s, at most {limit_s:.0f} s are read; cut it")
    samples = file.read(wanted, dtype="float32", always_2d=True).T
    if not samples.size:
        raise FileError(path, "holds no sound; download it again")
    if not np.isfinite(samples).all():
        raise FileError(path, "holds samples that are not finite numbers; download it again")
    divisor = _full_scale(path, samples) if is_floating else 1.0
    notes = () if divisor == 1.0 else (_scale_note(samples, divisor),)
    cut = samples[:, :end]
    return Audio(cut if divisor == 1.0 else cut / np.float32(divisor), rate, notes)


def _full_scale(path: Path, samples: NDArray[np.float32]) -> float:
    """What floating samples have to be divided by; 1 where they are as they should be."""
    peak = float(np.abs(samples).max())
    if peak <= 1 or (peak <= PEAK_MAX and not np.array_equal(samples, np.rint(samples))):
        return 1.0
    for scale in _FULL_SCALES.values():
        if peak <= scale:
            return scale
    raise FileError(path, f"holds samples up to {peak:.3g} where -1 to 1 is expected; save it as 16 bit WAV")


def _scale_note(samples: NDArray[np.float32], divisor: float) -> Note:
    bits = next(bits for bits, scale in _FULL_SCALES.items() if scale == divisor)
    peak = float(np.abs(samples).max())
    sentence = f"its samples reach {peak:.0f} where -1 to 1 is expected, and were taken for {bits} bit numbers"
    return Note(sentence, flag="sound-repaired")


def _repair_notes(repair: WavRepair | None) -> tuple[Note, ...]:
    return () if repair is None else (Note(repair.sentence, flag="sound-repaired"),)


def _rate_notes(rate_hz: int) -> tuple[Note, ...]:
    if rate_hz >= SAMPLE_RATE_HZ:
        return ()
    sentence = (
        f"it was recorded at {rate_hz / 1000:g} kHz, the dataset's sound at {SAMPLE_RATE_HZ / 1000:g} kHz: what a "
        f"network learned from above {rate_hz / 2000:g} kHz is missing"
    )
    return (Note(sentence, flag="sound-outside-training"),)


def sound_duration_s(path: str | Path) -> float:
    """The length that a sound file's header gives, in seconds.

    Raises:
        FileError: the file is absent or no sound file.
    """
    try:
        return float(soundfile.info(str(path)).duration)
    except (soundfile.SoundFileError, OSError) as error:
        raise FileError(Path(path), f"cannot be read as sound ({error}); download it again") from error
