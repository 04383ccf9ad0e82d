"""The front end of the filling network: a waveform as log-mel rows (paper 2)."""

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Literal, get_args

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import Tensor
from torchaudio.functional import melscale_fbanks

from corsmal.dataset.audio import SAMPLE_RATE_HZ
from corsmal.errors import ArgumentError, check_choice
from corsmal.fields import UNLESS_DEFAULT
from corsmal.filling.config import FrontEnd

Padding = Literal["silence", "reflection"]
Logarithm = Literal["natural", "binary"]
Precision = Literal["double", "single"]


@dataclass(frozen=True)
class LogMelParameters:
    """How a waveform becomes rows of log-mel values.

    Args:
        sample_rate_hz: what sound at another rate is resampled to.
        window: samples under a window, and the length of its FFT; even.
        hop: samples from one row to the next.
        mels: bands, from 0 Hz to half the sampling rate.
        floor: least power of a band, so that silence has a logarithm. Rounding to 16 bit alone gives an FFT bin about
            6e-8, so the default hides nothing that a 16 bit file can hold. With 0 silence is −∞.
        padding: what stands before the first and after the last sample: ``silence``, or the sound's ``reflection``.
        logarithm: to which base.
        precision: of the spectrum. Single precision loses the bands that are 80 dB below the loudest of their row.
    """

    sample_rate_hz: int = SAMPLE_RATE_HZ
    window: int = 2048
    hop: int = 1024
    mels: int = 128
    floor: float = 1e-7
    padding: Padding = field(default="silence", metadata=UNLESS_DEFAULT)
    logarithm: Logarithm = field(default="natural", metadata=UNLESS_DEFAULT)
    precision: Precision = field(default="double", metadata=UNLESS_DEFAULT)

    def __post_init__(self) -> None:
        for name in ("sample_rate_hz", "window", "hop", "mels"):
            if getattr(self, name) < 1:
                raise ArgumentError(f"{name} must be at least 1, got {getattr(self, name)}")
        if self.window % 2:
            raise ArgumentError(f"window must be even, got {self.window}")
        if not 0 <= self.floor < math.inf:
            raise ArgumentError(f"floor must be finite and not negative, got {self.floor}")
        for name, choices in (("padding", Padding), ("logarithm", Logarithm), ("precision", Precision)):
            check_choice(name, getattr(self, name), get_args(choices))

    @classmethod
    def of(cls, front_end: FrontEnd) -> "LogMelParameters":
        """The paper's, with what it leaves open chosen here, or those of the authors' program.

        Raises:
            ArgumentError: there is no such front end.
        """
        check_choice("front_end", front_end, get_args(FrontEnd))
        if front_end == "paper":
            return cls()
        return cls(floor=0.0, padding="reflection", logarithm="binary", precision="single")

    @property
    def row_s(self) -> float:
        """Seconds from one row to the next."""
        return self.hop / self.sample_rate_hz

    def rows(self, samples: int) -> int:
        """How many rows a waveform of that many samples at ``sample_rate_hz`` has."""
        return 1 + samples // self.hop


def log_mel(
    waveform: ArrayLike, *, sample_rate_hz: int = SAMPLE_RATE_HZ, parameters: LogMelParameters | None = None
) -> NDArray[np.float32]:
    """A waveform as log-mel rows (paper 2).

    Where the paper is silent: periodic Hann window; row t is centred at sample t · hop, with silence before the first
    and after the last sample; power spectrum |X|², not scaled; triangular bands equally spaced on the HTK mel scale
    (2595 log10(1 + f / 700)) from 0 Hz to half the sampling rate, each with peak 1; natural logarithm of the band's
    power, at least ``floor``. The parameters hold other choices. Channels do not influence each other.

    Args:
        waveform: (C, S) floating samples in -1..1, C and S at least 1.
        sample_rate_hz: of the waveform; another rate than the parameters' is resampled first.
        parameters: the numbers; default: those of the paper.

    Returns:
        (C, T, mels) float32, T = 1 + S // hop at the parameters' rate.

    Raises:
        ArgumentError: the waveform has another shape, is empty, or is not of finite floating numbers, the rate is not
            positive, or there is less than a window to be reflected.

    Example:
        >>> log_mel(np.zeros((8, 441_000), np.float32)).shape
        (8, 431, 128)
    """
    parameters = parameters or LogMelParameters()
    samples = _checked(waveform)
    if sample_rate_hz < 1:
        raise ArgumentError(f"sample_rate_hz must be at least 1, got {sample_rate_hz}")
    if sample_rate_hz != parameters.sample_rate_hz:
        common = math.gcd(sample_rate_hz, parameters.sample_rate_hz)
        up, down = parameters.sample_rate_hz // common, sample_rate_hz // common
        from scipy import signal  # noqa: PLC0415 - takes most of a second

        samples = signal.resample_poly(samples, up, down, axis=1)
    if parameters.padding == "reflection" and samples.shape[1] < parameters.window:
        least = f"{parameters.window} samples at {parameters.sample_rate_hz} Hz"
        raise ArgumentError(f"waveform must be at least a window long, {least}, got {samples.shape[1]}")
    # one channel at a time: the spectra of one stay in the processor's cache, and those of long files in memory
    return np.stack([_rows_of_channel(channel, parameters) for channel in samples])


def check_loud(rows: NDArray[np.floating], *, row_s: float | None = None, first: int = 0) -> None:
    """Whether log-mel rows (C, T, mels) hold a number everywhere, as a sound without digital silence gives.

    Args:
        rows: log-mel rows.
        row_s: seconds from one row to the next, by which the error names the moment.
        first: the number of the first row.

    Raises:
        ArgumentError: a row holds −∞.
    """
    if (silent := silent_rows(rows)).any():
        place = first + int(np.argmax(silent))
        where = f"row {place}" if row_s is None else f"{place * row_s:.2f} s"
        problem = f"the sound is silent in a microphone at {where}, and this network takes a logarithm without a floor"
        raise ArgumentError(f"{problem}: choose a part without silence, or another network")


def silent_rows(rows: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Which log-mel rows of (C, T, mels) hold −∞ in any channel: (T,)."""
    return np.asarray(np.isneginf(rows).any(axis=(0, 2)))


def _checked(waveform: ArrayLike) -> NDArray[np.float32]:
    samples = np.asarray(waveform)
    if samples.ndim != 2 or 0 in samples.shape:
        raise ArgumentError(f"waveform must have shape (channels, samples), both at least 1, got {samples.shape}")
    if samples.dtype.kind != "f":
        raise ArgumentError(f"waveform must hold floating numbers in -1..1, got {samples.dtype}")
    samples = samples.astype(np.float32, copy=False)
    if not np.isfinite(samples).all():
        raise ArgumentError("waveform must hold finite numbers, got NaN or infinity")
    return samples


def _rows_of_channel(samples: NDArray[np.float32], parameters: LogMelParameters) -> NDArray[np.float32]:
    window, bands = _window_and_bands(parameters)
    padded, rows = _padded(samples, parameters), parameters.rows(len(samples))
    frames = padded.unfold(0, parameters.window, parameters.hop)[:rows]  # (T, window), overlapping
    spectrum = torch.fft.rfft(frames * window)  # (T, window // 2 + 1)
    power = (spectrum.real.square() + spectrum.imag.square()).float()
    powers = (power @ bands).clamp_min_(parameters.floor)
    return (powers.log_() if parameters.logarithm == "natural" else powers.log2_()).numpy()  # (T, mels)


def _padded(samples: NDArray[np.float32], parameters: LogMelParameters) -> Tensor:
    """The samples with half a window before, and at least enough for the last row after them."""
    before, kind = parameters.window // 2, _type(parameters)
    if parameters.padding == "reflection":
        return torch.from_numpy(np.pad(samples, before, mode="reflect")).to(kind)
    length = (parameters.rows(len(samples)) - 1) * parameters.hop + parameters.window
    padded = torch.zeros(max(before + len(samples), length), dtype=kind)
    padded[before : before + len(samples)] = torch.tensor(samples)
    return padded


def _type(parameters: LogMelParameters) -> torch.dtype:
    return torch.float64 if parameters.precision == "double" else torch.float32


@lru_cache(maxsize=4)
def _window_and_bands(parameters: LogMelParameters) -> tuple[Tensor, Tensor]:
    """The window (n,) in the spectrum's precision and the bands (n // 2 + 1, mels)."""
    bands = melscale_fbanks(
        n_freqs=parameters.window // 2 + 1,
        f_min=0.0,
        f_max=parameters.sample_rate_hz / 2,
        n_mels=parameters.mels,
        sample_rate=parameters.sample_rate_hz,
        norm=None,
        mel_scale="htk",
    )
    return torch.hann_window(parameters.window, dtype=_type(parameters)), bands
