"""The recordings' sound: eight microphones in one file, WAV or FLAC."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import soundfile
from numpy.typing import NDArray

from corsmal.errors import FileError, check_choice

CHANNELS = 8
"""Microphones of the dataset's two circular arrays."""

ChannelRule = Literal["strict", "repeat", "average"]
"""What to do with a sound of another number of channels than eight: ``strict`` refuses it; ``repeat`` takes its
channels in turn until there are eight; ``average`` gives all eight the mean."""


def check_audio(path: str | Path) -> None:
    """Read a sound file's header.

    Raises:
        FileError: the file is absent or no sound file, is empty, or has another number of channels than eight.
    """
    read_audio(path, end_s=0.001)


@dataclass(frozen=True, eq=False)
class Audio:
    """The sound of one recording.

    Args:
        samples: (8, S) float32 in -1..1, one row per microphone, read-only.
        sample_rate_hz: samples per second and microphone.
    """

    samples: NDArray[np.float32]
    sample_rate_hz: int

    @property
    def duration_s(self) -> float:
        """Length in seconds."""
        return self.samples.shape[1] / self.sample_rate_hz


def read_audio(path: str | Path, *, end_s: float | None = None, channels: ChannelRule = "strict") -> Audio:
    """Read a sound file.

    Args:
        path: a WAV or FLAC file of eight channels, at any sampling rate.
        end_s: where to cut, in seconds from the start; None reads to the end.
        channels: how another number of channels is made eight; default: not at all.

    Raises:
        ArgumentError: there is no such rule for channels.
        FileError: the file is absent or no sound file, is empty, has another number of channels, or holds samples
            that are not finite.
    """
    check_choice("channels", channels, get_args(ChannelRule))
    path = Path(path)
    if not path.is_file():
        raise FileError(path, "there is no such sound file")
    try:
        with soundfile.SoundFile(path) as file:
            rate, found = int(file.samplerate), int(file.channels)
            if found != CHANNELS and channels == "strict":
                raise FileError(path, f"has {found} channels where the dataset's recordings have {CHANNELS}")
            frames = -1 if end_s is None else min(file.frames, round(end_s * rate))
            samples = file.read(frames, dtype="float32", always_2d=True)
    except (soundfile.SoundFileError, OSError) as error:
        raise FileError(path, f"cannot be read as sound ({error}); download it again") from error
    if not len(samples):
        raise FileError(path, "holds no sound; download it again")
    if not np.isfinite(samples).all():
        raise FileError(path, "holds samples that are not finite numbers; download it again")
    if found != CHANNELS:
        source = samples.mean(axis=1, keepdims=True) if channels == "average" else samples
        samples = source[:, np.arange(CHANNELS) % source.shape[1]]
    by_channel = np.ascontiguousarray(samples.T)
    by_channel.flags.writeable = False
    return Audio(by_channel, rate)
