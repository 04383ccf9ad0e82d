"""Small sounds of the demo: impacts of grains, ringing bodies, taps, cloth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from corsmal.geometry import Floats
from corsmal.synthetic.sound.events import SAMPLE_RATE_HZ, Material

Samples = NDArray[np.float32]

_BANK = 48


@dataclass(frozen=True)
class _Body:
    """Modes of a wall: their number, range in Hz for a container of 400 mL, range of quality, and loudness."""

    modes: int
    low_hz: float
    high_hz: float
    quality: tuple[float, float]
    gain: float


_BODIES: dict[Material, _Body] = {
    "plastic": _Body(6, 500.0, 4500.0, (8.0, 20.0), 1.0),
    "glass": _Body(5, 1700.0, 9000.0, (120.0, 350.0), 0.8),
    "cardboard": _Body(7, 130.0, 1300.0, (2.5, 6.0), 1.3),
}


def scatter(bank: Floats, onsets: Floats, amplitudes: Floats, *, samples: int, rng: np.random.Generator) -> Samples:
    """Lay short sounds, drawn from a bank (k, n), on a track (samples,).

    They start at ``onsets`` (m,), in samples, and are multiplied by ``amplitudes`` (m,); those outside are dropped.
    """
    starts = onsets.astype(np.int64)
    inside = (starts >= 0) & (starts < samples)
    starts, amplitudes = starts[inside], amplitudes[inside]
    which = rng.integers(len(bank), size=len(starts))
    index = starts[:, None] + np.arange(bank.shape[1])
    values = bank[which] * amplitudes[:, None]
    track = np.bincount(index.ravel(), values.ravel(), minlength=samples + bank.shape[1])
    return track[:samples].astype(np.float32)


def click_bank(rng: np.random.Generator, *, centre_hz: float, spread: float, decay_s: float) -> Floats:
    """Dry impacts of grains, no two alike: (48, n), peaks near 1.

    ``spread`` is the standard deviation of the frequencies' logarithm, ``decay_s`` the mean time to fall to 1/e.
    """
    times_s = np.arange(max(8, round(5 * decay_s * SAMPLE_RATE_HZ))) / SAMPLE_RATE_HZ
    partials = (_BANK, 3, 1)
    frequencies = centre_hz * np.exp(rng.normal(0, spread, partials))
    audible = frequencies < 0.45 * SAMPLE_RATE_HZ
    decays_s = decay_s * rng.uniform(0.5, 1.5, partials)
    waves = np.sin(2 * np.pi * frequencies * times_s + rng.uniform(0, 2 * np.pi, partials))
    weights = rng.uniform(0.2, 1.0, partials) * audible
    return (weights * waves * np.exp(-times_s / decays_s)).sum(axis=1) / 1.5


def body_response(material: Material, *, capacity_ml: float, rng: np.random.Generator) -> Samples:
    """The ringing of a container's wall after an impact: (n,), of unit energy times the material's loudness."""
    body = _BODIES[material]
    scale = (400.0 / capacity_ml) ** 0.25
    frequencies = np.exp(rng.uniform(np.log(body.low_hz), np.log(body.high_hz), (body.modes, 1))) * scale
    frequencies = frequencies.clip(max=0.45 * SAMPLE_RATE_HZ)
    decays_s = rng.uniform(*body.quality, (body.modes, 1)) / (np.pi * frequencies)
    times_s = np.arange(round(min(0.12, 5 * float(decays_s.max())) * SAMPLE_RATE_HZ)) / SAMPLE_RATE_HZ
    gains = rng.uniform(0.3, 1.0, (body.modes, 1))
    ring = (gains * np.exp(-times_s / decays_s) * np.sin(2 * np.pi * frequencies * times_s)).sum(axis=0)
    return (body.gain * ring / np.sqrt((ring**2).sum())).astype(np.float32)


def ring(dry: Samples, response: Samples) -> Samples:
    """A dry track through a body: (n,) as long as the dry one."""
    return signal.oaconvolve(dry, response)[: len(dry)].astype(np.float32)


def tap(response: Samples, *, rng: np.random.Generator, strength: float) -> Samples:
    """A container meeting the table or a hand: a thump of the table, the wall's ringing and one to three hits."""
    samples = round(0.18 * SAMPLE_RATE_HZ)
    times_s = np.arange(samples) / SAMPLE_RATE_HZ
    hits = np.cumsum(rng.exponential(0.02, rng.integers(1, 4))) * SAMPLE_RATE_HZ
    strengths = np.array([strength * rng.uniform(0.3, 1.0) ** hit for hit in range(len(hits))])
    bank = click_bank(rng, centre_hz=1500.0, spread=0.5, decay_s=0.0008)
    dry = scatter(bank, hits, strengths, samples=samples, rng=rng)
    modes_hz = rng.uniform(70, 420, (4, 1))
    thump = (np.sin(2 * np.pi * modes_hz * times_s) * np.exp(-times_s / rng.uniform(0.008, 0.03, (4, 1)))).sum(axis=0)
    return (0.5 * dry + 1.2 * ring(dry, response) + 0.35 * strength * thump).astype(np.float32)


def cloth(rng: np.random.Generator, *, duration_s: float, strength: float) -> Samples:
    """A sleeve that moves: hissing between about 400 Hz and 3 to 12 kHz, swelling once or more, with crackles: (n,)."""
    samples = max(16, round(duration_s * SAMPLE_RATE_HZ))
    knots = np.abs(rng.normal(0, 1, max(4, round(duration_s * 12))))
    knots[[0, -1]] = 0
    envelope = np.interp(np.linspace(0, len(knots) - 1, samples), np.arange(len(knots)), knots)
    grain = np.repeat(rng.exponential(1.0, samples // 64 + 1), 64)[:samples]
    high_hz, low_hz = rng.uniform(3000, 12_000), rng.uniform(250, 700)
    band = signal.butter(1, (low_hz, high_hz), "bandpass", fs=SAMPLE_RATE_HZ, output="sos")
    hiss = signal.sosfilt(band, rng.standard_normal(samples) * np.sqrt(grain))
    return (strength * envelope * hiss).astype(np.float32)
