"""Cached calls of the library for a recording's sound: features, pictures, and what the filling network says."""

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import streamlit as st

from corsmal.dataset import Audio, Recording
from corsmal.digests import file_fingerprint
from corsmal.errors import CorsmalError, FileError, NotFoundError
from corsmal.figures.sound import SoundPicture, sound_picture
from corsmal.filling import FillingPrediction
from corsmal.ui import data, media
from corsmal.weights import find_weights

if TYPE_CHECKING:
    from corsmal.filling import FillingPredictor
    from corsmal.filling.features import Features

Seconds = tuple[float, float]

WINDOW_S = 1.0
"""The sliding window: a pour lasts longer, a knock does not."""

ADVICE = "train some with `python -m corsmal train filling ROOT RUN` and name the file in CORSMAL_FILLING_WEIGHTS"

WINDOWS_MAX = 60
"""Windows of a recording, so that a long one takes no longer."""

HOP_MIN = 4
"""Rows between windows at least, about a tenth of a second."""


def predictor() -> "FillingPredictor":
    """The trained network.

    Raises:
        FileError: the weights are missing, broken, or were trained on something else than sound.
    """
    path = find_weights("filling").path
    if not path.is_file():
        raise FileError(path, f"the filling network's weights are missing; {ADVICE}")
    return _predictor(str(path), file_fingerprint(path))


def audio(recording: Recording) -> Audio:
    """A recording's sound.

    Raises:
        CorsmalError: it is missing or cannot be read.
    """
    return _audio(_key(recording), _recording=recording)


def features(recording: Recording) -> "Features":
    """The log-mel rows of a recording's sound, (8, T, 128).

    Raises:
        CorsmalError: as for ``audio``.
    """
    return _features(_key(recording), _recording=recording)


def picture(recording: Recording, *, channel: int | None) -> SoundPicture:
    """One channel, or the mean of all, ready to be drawn.

    Raises:
        CorsmalError: as for ``audio``.
    """
    return _picture(_key(recording), channel, _recording=recording)


def prediction(recording: Recording, *, crop_s: Seconds | None) -> FillingPrediction:
    """What the network says of a crop, or of the whole recording.

    Raises:
        CorsmalError: as for ``audio`` and ``predictor``.
    """
    network, given = predictor(), features(recording)
    rows = None if crop_s is None else crop_rows(crop_s, row_s=given.row_s, total=given.values.shape[1])
    return _prediction(_key(recording), network.digest, rows, _recording=recording)


def windows(recording: Recording) -> list[FillingPrediction]:
    """What the network says of windows of ``WINDOW_S`` that slide across the recording.

    Raises:
        CorsmalError: as for ``audio`` and ``predictor``.
    """
    return _windows(_key(recording), predictor().digest, _recording=recording)


def wav(recording: Recording, *, channel: int | None, crop_s: Seconds | None) -> bytes:
    """What is heard of one channel, or of the mean of all, as a WAV with the fixed gain.

    Raises:
        CorsmalError: as for ``audio``.
    """
    return _wav(_key(recording), channel, crop_s, _recording=recording)


def frame_clock(recording: Recording) -> tuple[int, float] | None:
    """How many frames a recording has, and frames per second; None without a video that can be read."""
    return _frame_clock(data.recording_key(recording), _recording=recording)


def crop_rows(crop_s: Seconds, *, row_s: float, total: int) -> tuple[int, int]:
    """[start, end) of the rows whose middles lie in a crop, at least one."""
    start, end = (round(moment_s / row_s) for moment_s in crop_s)
    start = min(max(start, 0), total - 1)
    return start, min(max(end + 1, start + 1), total)


def _key(recording: Recording) -> str:
    if recording.audio_path is None:
        raise NotFoundError(f"recording {recording.id} has no sound: audio/{recording.id}.wav is missing")
    return f"{recording.id} {file_fingerprint(recording.audio_path)}"


@st.cache_resource(max_entries=2, show_spinner="Reading the filling network")
def _predictor(path: str, fingerprint: str) -> "FillingPredictor":
    del fingerprint
    from corsmal.filling import FillingPredictor  # noqa: PLC0415 - PyTorch takes seconds to import

    network = FillingPredictor(Path(path))
    if (network.channels, network.config.features) != (8, 128):
        raise FileError(
            path,
            f"is of a network for {network.channels} × {network.config.features} features; this page needs one that "
            "was trained on the sound of 8 microphones",
        )
    return network


@st.cache_resource(max_entries=4, show_spinner="Reading the sound")
def _audio(key: str, *, _recording: Recording) -> Audio:
    del key
    return _recording.audio()


@st.cache_resource(max_entries=8, show_spinner="Listening")
def _features(key: str, *, _recording: Recording) -> "Features":
    del key
    from corsmal.filling.features import recording_features  # noqa: PLC0415 - as above

    return recording_features(_recording, store=data.store())


@st.cache_resource(max_entries=32, show_spinner="Listening")
def _picture(key: str, channel: int | None, *, _recording: Recording) -> SoundPicture:
    from corsmal.filling import LogMelParameters, log_mel  # noqa: PLC0415 - as above

    sound, parameters = _audio(key, _recording=_recording), LogMelParameters()
    samples = media.mixed(sound, channel)
    return sound_picture(
        samples,
        log_mel(samples[None], sample_rate_hz=sound.sample_rate_hz, parameters=parameters)[0],
        sample_rate_hz=sound.sample_rate_hz,
        row_s=parameters.row_s,
        highest_hz=parameters.sample_rate_hz / 2,
    )


@st.cache_resource(max_entries=16, show_spinner=False)
def _wav(key: str, channel: int | None, crop_s: Seconds | None, *, _recording: Recording) -> bytes:
    return media.audio_wav(_audio(key, _recording=_recording), channel=channel, crop_s=crop_s)


@st.cache_resource(max_entries=512, show_spinner=False)
def _prediction(key: str, network: str, rows: tuple[int, int] | None, *, _recording: Recording) -> FillingPrediction:
    del network
    given = _features(key, _recording=_recording)
    return predictor().predict(given.values, crop=rows, steps_s=given.row_s)


@st.cache_resource(max_entries=32, show_spinner="Sliding a window across the sound")
def _windows(key: str, network: str, *, _recording: Recording) -> list[FillingPrediction]:
    del network
    given = _features(key, _recording=_recording)
    window = max(1, round(WINDOW_S / given.row_s))
    hop = max(HOP_MIN, -(-(given.values.shape[1] - window) // WINDOWS_MAX))
    return predictor().predict_windows(given.values, window=window, hop=hop, steps_s=given.row_s)


@st.cache_resource(max_entries=64, show_spinner=False)
def _frame_clock(key: str, *, _recording: Recording) -> tuple[int, float] | None:
    del key
    for name in ("view3", "view1", "view2", "view4"):
        if name in _recording.views:
            with suppress(CorsmalError), _recording.views[name].video() as video:
                return video.frame_count, video.fps
    return None
