"""What is heard of a filling: grains or water poured into a container, and grains shaken in a box.

A container that is filled is a tube closed at the bottom: its air column resonates at f = c / (4 (h + 0.6 r)), with
h the height of the air left and r the opening's radius, and at odd multiples of f, so the pitch rises until the
pouring ends (Cabe and Pittenger, *J. Exp. Psychol. HPP* 26, 2000).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from corsmal.dataset.annotation import LEVEL_FRACTIONS
from corsmal.geometry import Floats
from corsmal.synthetic.sound.events import SAMPLE_RATE_HZ, SoundEvents
from corsmal.synthetic.sound.impacts import Samples, body_response, click_bank, ring, scatter
from corsmal.synthetic.sound.room import SPEED_OF_SOUND_M_S

_WINDOW, _HOP = 1024, 256
_CONTROL_HZ = 100
_TARGET_SPREAD = {0: 0.0, 1: 0.05, 2: 0.03}


@dataclass(frozen=True)
class _Grain:
    """How pieces sound: bulk volume of one (mL), how many a second are heard at most, pitch, decay, loudness."""

    volume_ml: float
    rate_max_hz: float
    centre_hz: float
    spread: float
    decay_s: float
    gain: float


_GRAINS = {
    "pasta": _Grain(2.6, 120.0, 2700.0, 0.45, 0.0014, 0.055),
    "rice": _Grain(0.025, 1500.0, 5200.0, 0.35, 0.0004, 0.012),
}


@dataclass(frozen=True, eq=False)
class Pour:
    """How a container fills.

    Args:
        progress: (n,) share of the capacity at ``n`` instants from the beginning to the end of pouring.
        flow: (n,) relative flow there, mean 1.
        duration_s: from beginning to end.
    """

    progress: Floats
    flow: Floats
    duration_s: float

    @classmethod
    def at_random(cls, events: SoundEvents, rng: np.random.Generator) -> "Pour":
        """An unsteady hand that stops near the intended level."""
        duration_s = events.end_s - events.start_s
        instants = max(8, round(duration_s * _CONTROL_HZ))
        knots = rng.normal(0, rng.uniform(0.25, 0.6), max(4, round(duration_s * 3)))
        flow = np.exp(np.interp(np.linspace(0, len(knots) - 1, instants), np.arange(len(knots)), knots))
        rise_s, fall_s = rng.uniform(0.1, 0.5, 2)
        clock = np.linspace(0, duration_s, instants)
        flow *= np.clip(clock / rise_s, 0.02, 1) * np.clip((duration_s - clock) / fall_s, 0.02, 1)
        target = LEVEL_FRACTIONS[events.level] + rng.normal(0, _TARGET_SPREAD[events.level])
        filled = np.cumsum(flow)
        return cls(min(target, 0.97) * filled / filled[-1], flow / flow.mean(), duration_s)

    def at(self, values: Floats, samples: int) -> Samples:
        """A curve over the ``n`` instants, read at every one of ``samples`` samples over the pour."""
        return np.interp(np.linspace(0, len(values) - 1, samples), np.arange(len(values)), values).astype(np.float32)

    def draw(self, count: int, rng: np.random.Generator) -> Floats:
        """(count,) times as a share 0..1 of the pour, more where more flows."""
        cumulative = np.cumsum(self.flow) / self.flow.sum()
        return np.interp(rng.random(count), cumulative, np.linspace(0, 1, len(cumulative)))


def inner_depth_mm(events: SoundEvents) -> float:
    """The depth of the container's inside: its height, or less where capacity and opening leave room for a stem."""
    opening_mm2 = np.pi * (events.opening_mm / 2) ** 2
    return float(min(0.97 * events.height_mm, 1.3 * 1000 * events.capacity_ml / opening_mm2))


def air_column_hz(events: SoundEvents, progress: Floats) -> Floats:
    """The first resonance of the air above a filling: (n,) Hz for (n,) shares of the capacity."""
    air_m = inner_depth_mm(events) / 1000 * (1 - np.clip(progress, 0, 1))
    return SPEED_OF_SOUND_M_S / (4 * (air_m + 0.6 * events.opening_mm / 2000))


def pouring(events: SoundEvents, *, rng: np.random.Generator) -> Samples:
    """The sound of pouring, from its beginning to its end: (n,), at 1 m.

    What has been poured covers the walls, so later grains strike them less.
    """
    pour = Pour.at_random(events, rng)
    samples = max(1, round(pour.duration_s * SAMPLE_RATE_HZ))
    body = body_response(events.material, capacity_ml=events.capacity_ml, rng=rng)
    if events.filling == "water":
        dry = _poured_water(pour, rng=rng, samples=samples)
        struck = np.float32(0.15) * dry
    else:
        dry = _poured_grains(events, pour, rng=rng, samples=samples)
        struck = dry * (0.25 + 0.75 * pour.at(np.exp(-pour.progress / 0.3), samples))
    walls = ring(struck, body)
    mouth = _air_column(dry + walls, air_column_hz(events, pour.progress), rng.uniform(7, 14))
    return np.float32(0.45) * dry + np.float32(0.6) * walls + np.float32(rng.uniform(1.5, 2.5)) * mouth


def shaking(events: SoundEvents, *, rng: np.random.Generator) -> Samples:
    """The sound of a box being shaken: (n,), at 1 m; of an empty one, its walls flexing.

    Each turn of the hand throws the grains at a wall. The room above the filling decides how they arrive: with more
    of it they fly longer and hit harder, with less of it they slide against each other, shorter and duller.
    """
    duration_s = events.end_s - events.start_s
    samples = max(1, round(duration_s * SAMPLE_RATE_HZ))
    body = body_response(events.material, capacity_ml=events.capacity_ml, rng=rng)
    turns_s = np.cumsum(rng.normal(1, 0.08, 4 + round(12 * duration_s)).clip(0.6)) / (2 * rng.uniform(3, 5))
    turns_s = turns_s[turns_s < duration_s]
    strengths = rng.lognormal(0, 0.25, len(turns_s)) * np.where(np.arange(len(turns_s)) % 2, rng.uniform(0.5, 1), 1)
    flex = _turns(turns_s, strengths, 0.03, samples) * rng.standard_normal(samples, dtype=np.float32)
    walls = np.float32(rng.uniform(0.0007, 0.003)) * ring(flex, body)
    if events.filling == "none":
        return walls
    grains = _shaken_grains(events, turns_s, strengths, rng=rng)
    return walls + np.float32(0.5) * grains + np.float32(0.8) * ring(grains, body)


def _poured_grains(events: SoundEvents, pour: Pour, *, rng: np.random.Generator, samples: int) -> Samples:
    """Grains as they fall, before any wall rings."""
    grain = _GRAINS[events.filling]
    count = events.capacity_ml * float(pour.progress[-1]) / grain.volume_ml
    heard = max(1, rng.poisson(min(count, grain.rate_max_hz * pour.duration_s)))
    when, size = pour.draw(heard, rng), rng.lognormal(0, 0.5, heard)
    # a grain on the bare bottom bounces several times, one on others hardly
    bareness = np.exp(-np.interp(when, np.linspace(0, 1, len(pour.progress)), pour.progress) / 0.2)
    bounces = rng.poisson(0.4 + 2.2 * bareness) if events.filling == "pasta" else (rng.random(heard) < bareness / 2) * 1
    again = np.repeat(np.arange(heard), bounces)
    later = rng.gamma(2.0, 0.02 if events.filling == "pasta" else 0.008, len(again))
    onsets = np.concatenate([when * pour.duration_s, when[again] * pour.duration_s + later]) * SAMPLE_RATE_HZ
    sizes = np.concatenate([size, size[again] * rng.uniform(0.15, 0.7, len(again))])
    pitch = rng.uniform(0.85, 1.15)
    bank = click_bank(rng, centre_hz=grain.centre_hz * pitch, spread=grain.spread, decay_s=grain.decay_s)
    # more grains than are heard one by one are heard as louder ones
    gain = grain.gain * min(2.0, (count / heard) ** 0.25)
    return scatter(bank, onsets, gain * sizes, samples=samples, rng=rng)


def _poured_water(pour: Pour, *, rng: np.random.Generator, samples: int) -> Samples:
    """A jet's hissing and its bubbles; each rings at 3.26 m/s over its radius (Minnaert), a little upwards."""
    flow = pour.at(pour.flow, samples)
    band = signal.butter(1, (350.0, 6500.0), "bandpass", fs=SAMPLE_RATE_HZ, output="sos")
    flutter = np.repeat(rng.exponential(1.0, samples // 512 + 1), 512)[:samples].astype(np.float32)
    hiss = signal.sosfilt(band, rng.standard_normal(samples, dtype=np.float32)) * flow * (0.5 + 0.5 * flutter)
    radii_m = np.exp(rng.normal(np.log(1.6e-3), 0.35, 40)).clip(0.6e-3, 4e-3)
    times_s = np.arange(round(0.018 * SAMPLE_RATE_HZ)) / SAMPLE_RATE_HZ
    pitch_hz = 3.26 / radii_m[:, None] * (1 + rng.uniform(0, 6, (40, 1)) * times_s)
    decay = np.exp(-times_s * rng.uniform(150, 400, (40, 1))) * (1 - np.exp(-times_s / 4e-4))
    bank = decay * np.sin(2 * np.pi * pitch_hz * times_s) * (radii_m[:, None] / 1.6e-3)
    count = rng.poisson(rng.uniform(70, 200) * pour.duration_s)
    onsets = pour.draw(count, rng) * samples
    bubbles = scatter(bank, onsets, 0.018 * rng.lognormal(0, 0.6, count), samples=samples, rng=rng)
    return (np.float32(rng.uniform(0.009, 0.018)) * hiss + bubbles).astype(np.float32)


def _shaken_grains(events: SoundEvents, turns_s: Floats, strengths: Floats, *, rng: np.random.Generator) -> Samples:
    """Grains thrown at the walls of a box at every turn."""
    grain = _GRAINS[events.filling]
    headspace = 1 - LEVEL_FRACTIONS[events.level] + rng.normal(0, 0.06)
    headspace = float(np.clip(headspace, 0.03, 0.6))
    moving = 25 * rng.uniform(0.6, 1.5) if events.filling == "pasta" else 130 * rng.uniform(0.6, 1.5)
    burst = np.repeat(np.arange(len(turns_s)), rng.poisson(moving, len(turns_s)))
    flight_s = 0.1 * np.sqrt(headspace) * rng.uniform(0.7, 1.4)
    onsets_s = turns_s[burst] + flight_s * rng.beta(2.0, 4.0, len(burst))
    sizes = strengths[burst] * rng.lognormal(0, 0.6, len(burst)) * (0.35 + headspace)
    softening = 0.5 + 0.8 * headspace
    bank = click_bank(
        rng, centre_hz=grain.centre_hz * softening * rng.uniform(0.85, 1.15), spread=grain.spread, decay_s=grain.decay_s
    )
    samples = max(1, round((events.end_s - events.start_s) * SAMPLE_RATE_HZ))
    return scatter(bank, onsets_s * SAMPLE_RATE_HZ, 0.8 * grain.gain * sizes, samples=samples, rng=rng)


def _turns(turns_s: Floats, strengths: Floats, width_s: float, samples: int) -> Samples:
    """An envelope that swells at every turn: (samples,)."""
    clock = np.linspace(0, samples / SAMPLE_RATE_HZ, max(2, samples // 64))
    bumps = strengths * np.exp(-(((clock[:, None] - turns_s) / width_s) ** 2))
    at = np.linspace(0, len(clock) - 1, samples)
    return np.interp(at, np.arange(len(clock)), bumps.sum(axis=1)).astype(np.float32)


def _air_column(sound: Samples, resonance_hz: Floats, quality: float) -> Samples:
    """Let a sound (n,) excite an air column whose first resonance moves along (m,) over it: (n,)."""
    padded = np.pad(sound, (_WINDOW, 2 * _WINDOW))
    window = np.hanning(_WINDOW + 1)[:-1].astype(np.float32)
    frames = np.lib.stride_tricks.sliding_window_view(padded, _WINDOW)[::_HOP] * window
    centres = np.arange(len(frames)) * _HOP - _WINDOW / 2
    at = np.interp(centres, np.linspace(0, len(sound), len(resonance_hz)), resonance_hz)
    frequencies = np.fft.rfftfreq(_WINDOW, 1 / SAMPLE_RATE_HZ).astype(np.float32)
    spectrum = np.fft.rfft(frames) * _resonances(frequencies, at.astype(np.float32), np.float32(quality))
    filtered = np.fft.irfft(spectrum, _WINDOW).astype(np.float32) * window
    return _overlap(filtered)[_WINDOW : _WINDOW + len(sound)]


def _resonances(
    frequencies: NDArray[np.float32], first_hz: NDArray[np.float32], quality: np.float32
) -> NDArray[np.complex64]:
    """Complex gain (m, k) at k frequencies of a quarter-wave tube with first resonances (m,)."""
    gain = np.zeros((len(first_hz), len(frequencies)), dtype=np.complex64)
    for order in (1, 3, 5):
        ratio = frequencies / (order * first_hz[:, None])
        tuning = 1j * ratio / quality
        gain += tuning / (1 - ratio**2 + tuning) / np.float32(order)
    return gain


def _overlap(frames: Samples) -> Samples:
    """Overlap-add frames (m, window) a hop apart; Hann windows, used twice, add up to 1.5."""
    parts = _WINDOW // _HOP
    blocks = np.zeros((len(frames) + parts - 1, _HOP), dtype=np.float32)
    for part in range(parts):
        blocks[part : part + len(frames)] += frames[:, part * _HOP : (part + 1) * _HOP]
    return blocks.ravel() / np.float32(1.5)
