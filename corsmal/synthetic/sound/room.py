"""The demo's room: eight microphones on a circle, early reflections, a short reverberation, and noise.

World coordinates in metres, z up, table near z = 0, the robot at positive y. Amplitudes are those of a WAV file,
full scale 1; a source's samples are its sound at 1 m.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft, signal

from corsmal.synthetic.sound.events import SAMPLE_RATE_HZ

Samples = NDArray[np.float32]

SPEED_OF_SOUND_M_S = 343.0
ARRAY_CENTRE_M = (0.15, 0.55, 0.03)
"""Where the array lies: on the table, in front of the robot and a little to its side."""
ARRAY_DIAMETER_M = 0.15
MICROPHONES_M: NDArray[np.float64] = np.array(ARRAY_CENTRE_M) + ARRAY_DIAMETER_M / 2 * np.array(
    [(np.cos(angle), np.sin(angle), 0.0) for angle in np.arange(8) * np.pi / 4]
)
"""(8, 3) metres: the microphones, counter-clockwise seen from above, the first towards positive x."""

# axis, position in metres and reflection factor of the table, the walls and the ceiling
_SURFACES = ((2, 0.0, 0.45), (0, -2.1, 0.5), (0, 2.4, 0.5), (1, -2.3, 0.55), (1, 1.9, 0.6), (2, 2.6, 0.45))
_EARLY_S = 0.034
_SINC_TAPS = 32
_NEAREST_M = 0.05
# amplitude of the noise per octave, in dB, as heard in a real recording: mains and air below 100 Hz, flat
# per octave up to 800 Hz, and 12 dB less from 2 kHz on
_NOISE_HZ = (10.0, 45.0, 150.0, 600.0, 1200.0, 2400.0, 19_000.0, 21_500.0)
_NOISE_OCTAVE_DB = (-3.0, 5.0, 2.0, 0.0, -6.0, -11.0, -13.0, -24.0)
_COHERENT_BELOW_HZ = 700.0


@dataclass(frozen=True, eq=False)
class Emission:
    """A sound and where it comes from: ``samples`` (n,) from sample ``start`` on, at ``position_m`` (3,)."""

    samples: Samples
    start: int
    position_m: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Room:
    """How sound travels to the microphones.

    Args:
        reflection: factor on the reflections of table, walls and ceiling; 0 leaves the direct path only.
        tail: (8, n) late reverberation, the response of each microphone to a source anywhere; n may be 0.
    """

    reflection: float
    tail: Samples

    @classmethod
    def at_random(cls, rng: np.random.Generator) -> "Room":
        """A furnished room whose reverberation time lies between 0.25 and 0.5 s."""
        reverberation_s = rng.uniform(0.25, 0.5)
        times_s = np.arange(round(0.2 * SAMPLE_RATE_HZ), dtype=np.float32) / SAMPLE_RATE_HZ
        decay = np.exp(-6.9 * times_s / reverberation_s) * np.clip((times_s - 0.012) / 0.02, 0, 1)
        tail = rng.standard_normal((len(MICROPHONES_M), len(times_s)), dtype=np.float32) * decay
        tail *= rng.uniform(0.35, 0.7) / np.sqrt(float((decay**2).sum()))
        low_pass = signal.butter(1, 4000.0, fs=SAMPLE_RATE_HZ, output="sos")
        return cls(float(rng.uniform(0.5, 1.0)), signal.sosfilt(low_pass, tail).astype(np.float32))

    def response(self, position_m: ArrayLike) -> Samples:
        """The early impulse responses from a position (3,) in metres to the microphones: (8, n)."""
        images, gains = [np.asarray(position_m, dtype=np.float64)], [1.0]
        for axis, at_m, factor in _SURFACES if self.reflection else ():
            image = images[0].copy()
            image[axis] = 2 * at_m - image[axis]
            images.append(image)
            gains.append(factor * self.reflection)
        distances_m = np.linalg.norm(np.array(images)[:, None] - MICROPHONES_M, axis=2).clip(_NEAREST_M)
        delays = distances_m / SPEED_OF_SOUND_M_S * SAMPLE_RATE_HZ
        return _fractional_delays(delays, np.array(gains)[:, None] / distances_m, round(_EARLY_S * SAMPLE_RATE_HZ))

    def render(self, emissions: Sequence[Emission], *, samples: int) -> Samples:
        """What the microphones hear of some sounds: (8, samples), without noise."""
        heard = np.zeros((len(MICROPHONES_M), samples), dtype=np.float32)
        dry = np.zeros(samples, dtype=np.float32)
        for emission in emissions:
            response = self.response(emission.position_m)
            _add(heard, signal.oaconvolve(emission.samples[None], response, axes=1), emission.start)
            _add(dry[None], emission.samples[None], emission.start)
        if self.tail.shape[1] and dry.any():
            heard += signal.oaconvolve(dry[None], self.tail, axes=1)[:, :samples]
        return heard


def room_noise(rng: np.random.Generator, *, samples: int, level_dbfs: float) -> Samples:
    """Hum, air and the microphones' own noise.

    Low frequencies reach all microphones alike and high ones differ, as in a diffuse field; the microphones'
    sensitivities differ by about 1 dB, and the spectrum's tilt by a few dB from recording to recording.

    Returns:
        (8, samples) with an RMS of ``level_dbfs`` relative to full scale.
    """
    length = fft.next_fast_len(samples, real=True)
    shape = (len(MICROPHONES_M) + 1, length // 2 + 1)
    spectra = rng.standard_normal((*shape, 2), dtype=np.float32).view(np.complex64)[..., 0]
    frequencies = np.fft.rfftfreq(length, 1 / SAMPLE_RATE_HZ).astype(np.float32).clip(5.0)
    octave_db = np.interp(np.log(frequencies), np.log(_NOISE_HZ), _NOISE_OCTAVE_DB)
    octave_db += rng.normal(0, 0.6) * np.log2(frequencies / 500.0)
    amplitude = (10 ** (octave_db / 20) / np.sqrt(frequencies)).astype(np.float32)
    common = 1 / (1 + (frequencies / _COHERENT_BELOW_HZ) ** 2)
    mixed = spectra[1:] * (amplitude * np.sqrt(1 - common)) + spectra[0] * (amplitude * np.sqrt(common))
    noise = fft.irfft(mixed, length, axis=1)[:, :samples]
    noise += _hum(rng, samples=samples) * noise.std()
    sensitivity = 10 ** (rng.normal(0, 1.0, (len(MICROPHONES_M), 1)) / 20)
    return (noise * (sensitivity * 10 ** (level_dbfs / 20) / noise.std())).astype(np.float32)


def _hum(rng: np.random.Generator, *, samples: int) -> Samples:
    """The mains' first harmonics, of an RMS between 0.1 and 0.8."""
    times_s = np.arange(samples, dtype=np.float32) / SAMPLE_RATE_HZ
    base_hz, strength = rng.uniform(47.5, 50.5), rng.uniform(0.1, 0.8)
    hum = np.zeros(samples, dtype=np.float32)
    for order, share in ((1, 1.0), (2, rng.uniform(0.1, 0.6)), (3, rng.uniform(0.05, 0.3))):
        phase = np.float32(2 * np.pi * base_hz * order) * times_s + np.float32(rng.uniform(0, 2 * np.pi))
        hum += np.float32(strength * share) * np.sin(phase)
    return hum


def _fractional_delays(delays: NDArray[np.float64], gains: NDArray[np.float64], length: int) -> Samples:
    """Impulse responses (channels, length) of paths with delays (paths, channels) in samples, by windowed sincs."""
    if delays.max() + _SINC_TAPS > length:
        length = int(delays.max()) + _SINC_TAPS
    first = np.floor(delays).astype(int) - _SINC_TAPS // 2 + 1
    taps = first[..., None] + np.arange(_SINC_TAPS)
    offset = taps - delays[..., None]
    values = np.sinc(offset) * np.cos(np.pi * offset / (_SINC_TAPS + 2)) ** 2 * gains[..., None]
    channel = np.broadcast_to(np.arange(delays.shape[1])[None, :, None], taps.shape)
    inside = taps >= 0
    flat = np.bincount((channel * length + taps)[inside], values[inside], minlength=delays.shape[1] * length)
    return flat.reshape(delays.shape[1], length).astype(np.float32)


def _add(track: Samples, sound: Samples, start: int) -> None:
    """Add (c, n) to (c, S) in place from sample ``start`` on, as far as it fits."""
    count = max(0, min(sound.shape[1], track.shape[1] - start))
    track[:, start : start + count] += sound[:, :count]
