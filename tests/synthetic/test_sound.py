import dataclasses

import numpy as np
import pytest
from scipy import signal
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import cross_val_predict
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from corsmal.synthetic.sound.events import SoundEvents, pour_duration_s
from corsmal.synthetic.sound.impacts import body_response, scatter
from corsmal.synthetic.sound.recording import recording_sound
from corsmal.synthetic.sound.room import MICROPHONES_M, Emission, Room, room_noise
from corsmal.synthetic.sound.sources import air_column_hz

RATE_HZ = 44_100
ANECHOIC = Room(0.0, np.zeros((8, 0), dtype=np.float32))

CUP = SoundEvents("plastic", 520.0, 119.0, 96.0, "water", 2, 2.0, "pour", 0.3, 1.8, (0.0, 0.0, 0.1), (0.1,))
BOX = dataclasses.replace(CUP, material="cardboard", capacity_ml=1240.0, filling="rice", action="shake")
HANDLED = dataclasses.replace(CUP, filling="none", level=0, action="handle")


def sound_of(events: SoundEvents, *, seed: int = 0) -> np.ndarray:
    return recording_sound(events, rng=np.random.default_rng(seed))


def rms(samples: np.ndarray) -> float:
    return float(np.sqrt(np.mean(samples.astype(np.float64) ** 2)))


@pytest.mark.parametrize("filling", ["pasta", "rice", "water"])
@pytest.mark.parametrize("level", [1, 2])
def test_pouring_gives_eight_finite_channels_within_full_scale(filling, level):
    sound = sound_of(dataclasses.replace(CUP, filling=filling, level=level))
    assert sound.shape == (8, 2 * RATE_HZ)
    assert sound.dtype == np.float32
    assert np.isfinite(sound).all()
    assert 0.01 < np.abs(sound).max() < 1


@pytest.mark.parametrize("events", [BOX, dataclasses.replace(BOX, filling="none", level=0), HANDLED])
def test_shaking_and_handling_give_eight_finite_channels(events):
    sound = sound_of(events)
    assert sound.shape == (8, 2 * RATE_HZ)
    assert np.isfinite(sound).all()
    assert np.abs(sound).max() < 1


@pytest.mark.parametrize("events", [CUP, BOX, HANDLED])
def test_very_short_events_work(events):
    short = dataclasses.replace(events, duration_s=0.02, start_s=0.01, end_s=0.0101, contacts_s=(0.02,))
    assert sound_of(short).shape == (8, 882)


def test_same_state_gives_the_same_samples_and_another_seed_others():
    assert np.array_equal(sound_of(BOX, seed=3), sound_of(BOX, seed=3))
    assert not np.array_equal(sound_of(BOX, seed=3), sound_of(BOX, seed=4))


def test_microphones_lie_on_a_circle_of_15_cm():
    opposite = np.linalg.norm(MICROPHONES_M[:4] - MICROPHONES_M[4:], axis=1)
    np.testing.assert_allclose(opposite, 0.15)
    neighbours = np.linalg.norm(MICROPHONES_M - np.roll(MICROPHONES_M, 1, axis=0), axis=1)
    np.testing.assert_allclose(neighbours, 0.15 * np.sin(np.pi / 8))


def test_delays_and_levels_between_microphones_match_the_geometry():
    position = np.array([-0.1, 0.05, 0.2])
    burst = np.random.default_rng(0).standard_normal(4096).astype(np.float32)
    low_pass = signal.butter(4, 12_000, fs=RATE_HZ, output="sos")
    emission = Emission(signal.sosfilt(low_pass, burst).astype(np.float32), 0, position)
    heard = ANECHOIC.render([emission], samples=8192)
    distances_m = np.sqrt(((MICROPHONES_M - position) ** 2).sum(axis=1))
    oversampling = 32
    spectra = np.fft.rfft(heard, 16_384)
    for microphone in range(1, 8):
        cross = np.fft.irfft(spectra[microphone] * spectra[0].conj(), 16_384 * oversampling)
        shift = int(np.argmax(cross))
        shift -= 16_384 * oversampling * (shift > len(cross) // 2)
        expected = (distances_m[microphone] - distances_m[0]) / 343.0 * RATE_HZ
        assert shift / oversampling == pytest.approx(expected, abs=0.05)
        ratio = rms(heard[microphone]) / rms(heard[0])
        assert ratio == pytest.approx(distances_m[0] / distances_m[microphone], rel=0.01)


def test_direct_sound_comes_first_and_the_room_answers_later():
    room = Room.at_random(np.random.default_rng(0))
    click = Emission(np.ones(1, dtype=np.float32), 0, np.array([0.0, 0.0, 0.1]))
    heard = room.render([click], samples=RATE_HZ // 2)
    bare = ANECHOIC.render([click], samples=RATE_HZ // 2)
    first = np.abs(bare[0]).argmax()
    np.testing.assert_allclose(heard[0, first], bare[0, first], rtol=0.05)
    assert rms(heard[0, RATE_HZ // 10 : RATE_HZ // 5]) > 100 * rms(bare[0, RATE_HZ // 10 : RATE_HZ // 5])
    assert rms(heard[0, : RATE_HZ // 20]) > rms(heard[0, RATE_HZ // 10 : RATE_HZ // 5])


def test_nearer_containers_are_louder():
    far = dataclasses.replace(CUP, source_path_m=(0.0, -0.4, 0.1))
    near = dataclasses.replace(CUP, source_path_m=(0.1, 0.4, 0.1))
    active = slice(RATE_HZ // 2, 3 * RATE_HZ // 2)
    assert rms(sound_of(near)[:, active]) > 2 * rms(sound_of(far)[:, active])


def test_a_moving_container_gets_louder_on_its_way_to_the_robot():
    path = np.linspace((0.0, -0.6, 0.1), (0.15, 0.45, 0.1), 20)
    moving = dataclasses.replace(BOX, filling="pasta", source_path_m=path, times_s=np.linspace(0.3, 1.8, 20))
    louder = [
        rms(sound[:, round(1.4 * RATE_HZ) : round(1.8 * RATE_HZ)])
        > 1.5 * rms(sound[:, round(0.35 * RATE_HZ) : round(0.75 * RATE_HZ)])
        for sound in (sound_of(moving, seed=seed) for seed in range(3))
    ]
    assert all(louder)


def test_air_column_is_the_quarter_wave_of_the_remaining_air():
    # 100 mm high: 97 mm deep inside; end correction 0.6 x 30 mm = 18 mm
    tube = dataclasses.replace(CUP, capacity_ml=300.0, height_mm=100.0, opening_mm=60.0)
    frequencies = air_column_hz(tube, np.array([0.0, 0.5, 0.9]))
    np.testing.assert_allclose(frequencies, [343 / 0.46, 343 / (4 * 0.0665), 343 / (4 * 0.0277)], rtol=1e-6)


@pytest.mark.parametrize(("level", "least_rise"), [(1, 1.25), (2, 1.9)])
def test_the_pitch_of_a_water_pour_rises(level, least_rise):
    tall = dataclasses.replace(
        CUP, height_mm=160.0, opening_mm=66.0, level=level, duration_s=4.0, start_s=0.2, end_s=3.8, contacts_s=()
    )
    rises = []
    for seed in range(4):
        sound = sound_of(tall, seed=seed).mean(axis=0)
        peaks = []
        for begin_s, end_s in ((0.5, 1.0), (3.2, 3.7)):
            piece = sound[round(begin_s * RATE_HZ) : round(end_s * RATE_HZ)]
            frequencies, power = signal.welch(piece, RATE_HZ, nperseg=1024)
            audible = (frequencies > 350) & (frequencies < 3500)
            peaks.append(frequencies[audible][power[audible].argmax()])
        rises.append(peaks[1] / peaks[0])
    assert np.median(rises) > least_rise


def test_nothing_is_silent_and_the_floor_is_a_quiet_room():
    quiet = dataclasses.replace(HANDLED, duration_s=3.0)
    for seed in range(4):
        blocks = sound_of(quiet, seed=seed)[:, : 60 * 2205].reshape(8, 60, 2205)
        floor_db = 20 * np.log10(np.percentile(blocks.std(axis=2), 10, axis=1))
        assert (blocks.std(axis=2) > 0).all()
        assert ((floor_db > -68) & (floor_db < -45)).all()


def test_noise_has_its_level_and_is_common_to_microphones_at_low_frequencies_only():
    noise = room_noise(np.random.default_rng(0), samples=4 * RATE_HZ, level_dbfs=-52.0)
    assert 20 * np.log10(rms(noise)) == pytest.approx(-52.0, abs=1.5)
    frequencies, coherence = signal.coherence(noise[0], noise[4], RATE_HZ, nperseg=4096)
    assert coherence[(frequencies > 40) & (frequencies < 200)].mean() > 0.8
    assert coherence[(frequencies > 4000) & (frequencies < 12_000)].mean() < 0.15


def test_scattered_sounds_add_up_where_they_start():
    bank = np.array([[1.0, 0.5]])
    track = scatter(
        bank, np.array([0.0, 1.0, 3.0, 9.0]), np.array([1.0, 2.0, 4.0, 1.0]), samples=4, rng=np.random.default_rng(0)
    )
    np.testing.assert_array_equal(track, [1.0, 2.5, 1.0, 4.0])


def test_glass_swings_more_often_than_plastic_and_plastic_than_cardboard():
    swings = []
    for material in ("glass", "plastic", "cardboard"):
        counts = []
        for seed in range(8):
            response = body_response(material, capacity_ml=400.0, rng=np.random.default_rng(seed))
            energy = np.cumsum(response.astype(np.float64) ** 2)
            audible = response[: np.searchsorted(energy, 0.9 * energy[-1])]
            counts.append(np.count_nonzero(np.diff(np.sign(audible))))
        swings.append(np.median(counts))
    assert swings[0] > 2 * swings[1] > 4 * swings[2]


def test_simple_features_tell_the_type_but_not_always_the_level():
    rng = np.random.default_rng(0)
    kinds = [("pasta", 1), ("pasta", 2), ("rice", 1), ("rice", 2), ("water", 1), ("water", 2), ("none", 0)] * 10
    features = []
    for filling, level in kinds:
        pour_s = pour_duration_s(filling, level, 520.0, rng=rng, pace=8.0) or 0.5
        events = dataclasses.replace(
            CUP, filling=filling, level=level, action="pour" if level else "handle", duration_s=pour_s + 0.4,
            start_s=0.2, end_s=pour_s + 0.2,
        )  # fmt: skip
        sound = recording_sound(events, rng=rng)[0]
        power = signal.spectrogram(sound, RATE_HZ, nperseg=1024)[2]
        bands = np.log([part.mean() + 1e-12 for part in np.array_split(power, 16)])
        features.append([*bands, np.log(len(sound))])
    classifier = make_pipeline(StandardScaler(), LogisticRegression(C=0.3, max_iter=500))
    types = np.array([filling for filling, _ in kinds])
    levels = np.array([level for _, level in kinds])
    assert np.mean(cross_val_predict(classifier, features, types, cv=5) == types) > 0.8
    assert 0.5 < np.mean(cross_val_predict(classifier, features, levels, cv=5) == levels) < 0.95
