"""The demo's sound: a recording of eight microphones, generated from what happens in it.

Nothing in it states the filling's level: half and full differ in how long is poured, at a pace that varies from
person to person, in how high the air column's pitch has risen in the end, and in how freely a box rattles.
"""

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset.annotation import LEVEL_FRACTIONS
from corsmal.synthetic.sound.events import SAMPLE_RATE_HZ, SoundEvents
from corsmal.synthetic.sound.impacts import body_response, cloth, ring, tap
from corsmal.synthetic.sound.room import Emission, Room, room_noise
from corsmal.synthetic.sound.sources import pouring, shaking

FULL_SCALE = 0.99
NOISE_DBFS = (-57.0, -49.0)
"""Range of the room's level; the real recording that was measured has -52."""

_STATION_M, _STATION_STEP_S, _FADE_S = 0.04, 0.1, 0.02
_SLEEVE_M = np.array([0.0, -0.3, 0.2])
"""Where the sleeves are, seen from the container: behind and above it, towards the person."""


def recording_sound(events: SoundEvents, *, rng: np.random.Generator) -> NDArray[np.float32]:
    """The sound of one recording at the array's eight microphones, (8, round(duration_s · 44100)) within ±0.99.

    All that ``events`` leaves open is drawn: the unsteady hand, the grains, the container's modes, room and noise.
    """
    samples = round(events.duration_s * SAMPLE_RATE_HZ)
    room = Room.at_random(rng)
    emissions = [*_filling(events, rng), *_taps(events, rng), *_sleeves(events, rng)]
    heard = room.render(emissions, samples=samples) * np.float32(10 ** (rng.normal(0, 2.5) / 20))
    heard += room_noise(rng, samples=samples, level_dbfs=rng.uniform(*NOISE_DBFS))
    return np.clip(heard, -FULL_SCALE, FULL_SCALE)


def _filling(events: SoundEvents, rng: np.random.Generator) -> list[Emission]:
    """Pouring or shaking, heard from the container's way in steps of 4 cm, cross-faded."""
    if events.action == "handle":
        return []
    sound = pouring(events, rng=rng) if events.action == "pour" else shaking(events, rng=rng)
    clock_s = np.arange(events.start_s, events.start_s + len(sound) / SAMPLE_RATE_HZ, _STATION_STEP_S)
    positions = events.position_m(clock_s)
    stations = [0]
    for step in range(1, len(positions)):
        if np.linalg.norm(positions[step] - positions[stations[-1]]) > _STATION_M:
            stations.append(step)
    fade = round(_FADE_S * SAMPLE_RATE_HZ)
    ramp = np.linspace(0, 1, fade, dtype=np.float32)
    cuts = [round(step * _STATION_STEP_S * SAMPLE_RATE_HZ) for step in stations] + [len(sound)]
    emissions = []
    for station, first, last in zip(stations, cuts[:-1], cuts[1:], strict=True):
        piece = sound[first : last + fade].copy()
        if first:
            piece[:fade] *= ramp[: len(piece)]
        if last < len(sound):
            piece[last - first :] *= 1 - ramp[: len(piece) - (last - first)]
        start = round(events.start_s * SAMPLE_RATE_HZ) + first
        emissions.append(Emission(piece, start, positions[station]))
    return emissions


def _taps(events: SoundEvents, rng: np.random.Generator) -> list[Emission]:
    """The container's contacts, and now and then a knock on the table or, while pouring, the jug on the brim."""
    body = body_response(events.material, capacity_ml=events.capacity_ml, rng=rng)
    times_s = list(events.contacts_s)
    if rng.random() < 0.4:
        times_s.append(rng.uniform(0, events.duration_s))
    if events.action == "pour" and rng.random() < 0.4:
        times_s.append(rng.uniform(events.start_s, events.end_s))
    loudness = rng.uniform(0.5, 1.5)
    emissions = []
    for time_s in times_s:
        # what is filled in damps the walls
        share = LEVEL_FRACTIONS[events.level] if time_s > events.end_s else 0.0
        damping = np.exp(-np.arange(len(body)) / SAMPLE_RATE_HZ * 150 * share).astype(np.float32)
        strength = 0.008 * loudness * rng.lognormal(0, 0.6)
        sound = tap(body * damping, rng=rng, strength=strength)
        emissions.append(Emission(sound, round(time_s * SAMPLE_RATE_HZ), events.position_m(time_s)[0]))
    return emissions


def _sleeves(events: SoundEvents, rng: np.random.Generator) -> list[Emission]:
    """Cloth, and the wall of a soft container giving way under the fingers."""
    body = body_response(events.material, capacity_ml=events.capacity_ml, rng=rng)
    emissions = []
    for _ in range(1 + rng.poisson(0.5 * events.duration_s)):
        start_s, length_s = rng.uniform(0, events.duration_s), rng.uniform(0.2, 1.0)
        sound = cloth(rng, duration_s=length_s, strength=0.002 * rng.lognormal(0, 0.6))
        if events.material != "glass" and rng.random() < 0.3:
            crackle = sound * (rng.random(len(sound)) < 0.02)
            sound = 4 * crackle + 6 * ring(crackle, body)
        place = events.position_m(start_s)[0] + _SLEEVE_M + rng.normal(0, 0.05, 3)
        emissions.append(Emission(sound, round(start_s * SAMPLE_RATE_HZ), place))
    return emissions
