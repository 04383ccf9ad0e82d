"""A recording's sound as it is drawn: the waveform's envelope and the log-mel rows as a small picture."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.errors import ArgumentError
from corsmal.figures.overlay import jpeg_uri

if TYPE_CHECKING:
    from corsmal.filling.frontend import Logarithm

Floats = NDArray[np.float32]

PAPER_SOURCE = "the paper's front end"

ENVELOPE_POINTS = 900
"""More than the plot has pixels would change nothing but the time to send them."""

PICTURE_WIDTH = 1200
LOG_MEL_DB = (-40.0, 15.0)
"""Power of a band at the two ends of the colours, the same for all recordings."""

DB_PER = {"natural": 10 / np.log(10), "binary": 10 * np.log10(2)}
"""Decibels of power in one unit of a logarithm."""

UNITS = {"natural": "ln", "binary": "log₂"}
SILENCE_GREY = 128
"""Of rows that hold −∞, for which the colours have no place."""


@dataclass(frozen=True, eq=False)
class SoundPicture:
    """What is drawn of one channel.

    Args:
        times_s: (n,) the middles of equal parts of the waveform.
        low: (n,) the least sample of each part.
        high: (n,) the greatest.
        log_mel: the log-mel rows as a JPEG in a ``data:`` address, low frequencies at the bottom.
        span_s: where the picture begins and ends; its first row is centred at 0 s.
        bands: how many mel bands it is high.
        highest_hz: where the highest band ends.
        duration_s: of the sound.
        source: whose front end the rows are of.
        unit: what the colours stand for: ``ln`` or ``log₂`` of the power.
        limits: the values of the darkest and the brightest colour.
        has_silence: whether rows hold −∞, which is drawn grey.
    """

    times_s: Floats
    low: Floats
    high: Floats
    log_mel: str
    span_s: tuple[float, float]
    bands: int
    highest_hz: float
    duration_s: float
    source: str
    unit: str
    limits: tuple[float, float]
    has_silence: bool


def sound_picture(
    samples: Floats,
    rows: Floats,
    *,
    sample_rate_hz: int,
    row_s: float,
    highest_hz: float,
    logarithm: "Logarithm" = "natural",
    source: str = PAPER_SOURCE,
) -> SoundPicture:
    """Prepare one channel for drawing, however long it is.

    Args:
        samples: (S,) waveform, S at least 1.
        rows: (T, bands) logarithms of the bands' power, ``row_s`` apart; −∞ where a front end without a floor meets
            silence.
        sample_rate_hz: of the samples.
        row_s: seconds from one row to the next.
        highest_hz: where the highest band ends.
        logarithm: to which base.
        source: whose front end the rows are of.

    Raises:
        ArgumentError: an array is empty or has another shape.
    """
    if samples.ndim != 1 or rows.ndim != 2 or not samples.size or not rows.size:
        raise ArgumentError(f"samples must be (S,) and rows (T, bands), not empty, got {samples.shape}, {rows.shape}")
    starts = np.unique(np.linspace(0, len(samples), ENVELOPE_POINTS, endpoint=False).astype(int))
    ends = np.append(starts[1:], len(samples))
    return SoundPicture(
        times_s=((starts + ends) / 2 / sample_rate_hz).astype(np.float32),
        low=np.minimum.reduceat(samples, starts).astype(np.float32),
        high=np.maximum.reduceat(samples, starts).astype(np.float32),
        log_mel=_picture(rows * DB_PER[logarithm]),
        span_s=(-row_s / 2, (len(rows) - 0.5) * row_s),
        bands=rows.shape[1],
        highest_hz=highest_hz,
        duration_s=len(samples) / sample_rate_hz,
        source=source,
        unit=UNITS[logarithm],
        limits=(LOG_MEL_DB[0] / DB_PER[logarithm], LOG_MEL_DB[1] / DB_PER[logarithm]),
        has_silence=bool(np.isneginf(rows).any()),
    )


def band_of(frequency_hz: float, *, bands: int, highest_hz: float) -> float:
    """The band, from 0, whose middle lies at a frequency; between two bands a fraction. HTK's mel scale."""
    share = np.log1p(frequency_hz / 700) / np.log1p(highest_hz / 700)
    return float(share * (bands + 1) - 1)


def _picture(rows_db: Floats) -> str:
    low, high = LOG_MEL_DB
    shares = (rows_db.T[::-1] - low) / (high - low)
    grey = (255 * shares.clip(0, 1)).round().astype(np.uint8)
    coloured = np.asarray(cv2.cvtColor(cv2.applyColorMap(grey, cv2.COLORMAP_MAGMA), cv2.COLOR_BGR2RGB), np.uint8)
    coloured[np.isneginf(shares)] = SILENCE_GREY
    if coloured.shape[1] > PICTURE_WIDTH:
        coloured = np.asarray(
            cv2.resize(coloured, (PICTURE_WIDTH, len(coloured)), interpolation=cv2.INTER_AREA), np.uint8
        )
    return jpeg_uri(coloured)
