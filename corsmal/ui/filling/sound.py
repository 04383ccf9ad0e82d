"""A recording's sound, cached: to play, to draw, and what the filling network predicts from it.

The functions raise a ``CorsmalError`` where the sound or the network is missing or cannot be read.
"""

from typing import TYPE_CHECKING

from corsmal.dataset import Audio
from corsmal.errors import ArgumentError, CorsmalError, FileError
from corsmal.figures.sound import PAPER_SOURCE, SoundPicture, sound_picture
from corsmal.filling import FillingPrediction
from corsmal.ui import media, shared
from corsmal.ui.caching import cached
from corsmal.ui.filling import senses
from corsmal.ui.filling.network import any_network, by_network, fused_network, hears_log_mel, network
from corsmal.ui.opened import OpenedRecording
from corsmal.weights import find_weights

if TYPE_CHECKING:
    from corsmal.filling import FillingPredictor, LogMelParameters
    from corsmal.filling.features import Features

Seconds = senses.Seconds

WINDOW_S = 1.0
"""The sliding window: a pour lasts longer, a knock does not."""

WINDOWS_MAX = 60
"""Windows of a recording, so that a long one takes no longer."""

HOP_MIN = 4
"""Rows between windows at least, about a tenth of a second."""


def predictor() -> "FillingPredictor":
    """The trained network of sound."""
    from corsmal.filling import FusedPredictor  # noqa: PLC0415 - PyTorch takes seconds to import

    found = network()
    if isinstance(found, FusedPredictor):
        raise FileError(find_weights("filling").path, "is of a network of sound and sight, which has no sliding window")
    return found


@cached(4, spinner="Reading the sound")
def audio(opened: OpenedRecording) -> Audio:
    """A recording's sound."""
    return opened.recording.audio()


def picture(opened: OpenedRecording, channel: int | None) -> SoundPicture:
    """One channel, or the mean of all, ready to be drawn as the network is given it.

    Without a network that is given log-mel rows, and where the sound is too short for its front end, by the paper's.
    """
    parameters, source = _front_end()
    try:
        return _picture(opened, channel, parameters, source)
    except ArgumentError:
        return _picture(opened, channel, type(parameters)(), f"{PAPER_SOURCE} (too short for {source})")


def _front_end() -> "tuple[LogMelParameters, str]":
    """Of the picture of the sound, and whose it is."""
    from corsmal.filling import FusedPredictor, LogMelParameters  # noqa: PLC0415 - as above

    try:
        found = any_network()
    except CorsmalError:
        return LogMelParameters(), PAPER_SOURCE
    if isinstance(found, FusedPredictor):
        is_heard = senses.folders().sound is None and hears_log_mel(found.config.sound[0])
    else:
        is_heard = hears_log_mel(found.config)
    if not is_heard:
        return LogMelParameters(), f"{PAPER_SOURCE} (the network is given arrays)"
    is_papers = found.front_end == LogMelParameters()
    return found.front_end, PAPER_SOURCE if is_papers else "the authors' front end"


@cached(32, spinner="Reading the sound")
def _picture(opened: OpenedRecording, channel: int | None, parameters: "LogMelParameters", source: str) -> SoundPicture:
    from corsmal.filling import log_mel  # noqa: PLC0415 - as above

    sound = audio(opened)
    samples = media.mixed(sound, channel)
    return sound_picture(
        samples,
        log_mel(samples[None], sample_rate_hz=sound.sample_rate_hz, parameters=parameters)[0],
        sample_rate_hz=sound.sample_rate_hz,
        row_s=parameters.row_s,
        highest_hz=parameters.sample_rate_hz / 2,
        logarithm=parameters.logarithm,
        source=source,
    )


@cached(16)
def wav(opened: OpenedRecording, channel: int | None, crop_s: Seconds | None) -> bytes:
    """One channel, or the mean of all, as a WAV with the fixed gain."""
    return media.audio_wav(audio(opened), channel=channel, crop_s=crop_s)


@cached(8, key=by_network, spinner="Reading the sound")
def features(opened: OpenedRecording) -> "Features":
    """The log-mel rows of a recording's sound, (8, T, 128), as the network was trained on them."""
    from corsmal.filling.features import recording_features  # noqa: PLC0415 - as above

    return recording_features(opened.recording, parameters=predictor().front_end, store=shared.store())


def prediction(opened: OpenedRecording, crop_s: Seconds | None) -> FillingPrediction:
    """The prediction for a crop, or for the whole recording; from its videos, too, where the network sees them."""
    return _heard(opened, crop_s) if fused_network() is None else senses.prediction(opened, crop_s)


@cached(512, key=by_network)
def _heard(opened: OpenedRecording, crop_s: Seconds | None) -> FillingPrediction:
    given = features(opened)
    rows = None if crop_s is None else crop_rows(crop_s, row_s=given.row_s, total=given.values.shape[1])
    return predictor().predict(given.values, crop=rows, steps_s=given.row_s)


@cached(32, key=by_network, spinner="Sliding a window across the sound")
def windows(opened: OpenedRecording) -> list[FillingPrediction]:
    """The predictions for windows of ``WINDOW_S`` that slide across the recording."""
    given = features(opened)
    window = max(1, round(WINDOW_S / given.row_s))
    hop = max(HOP_MIN, -(-(given.values.shape[1] - window) // WINDOWS_MAX))
    return predictor().predict_windows(given.values, window=window, hop=hop, steps_s=given.row_s)


def crop_rows(crop_s: Seconds, *, row_s: float, total: int) -> tuple[int, int]:
    """[start, end) of the rows whose middles lie in a crop, at least one."""
    start, end = (round(moment_s / row_s) for moment_s in crop_s)
    start = min(max(start, 0), total - 1)
    return start, min(max(end + 1, start + 1), total)
