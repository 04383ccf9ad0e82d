import numpy as np
import pytest
import soundfile
from scipy import signal

from corsmal.errors import ArgumentError
from corsmal.filling import log_mel
from corsmal.filling.frontend import LogMelParameters

RATE_HZ = 44_100
TONE = 0.9 * np.sin(2 * np.pi * 50 * np.arange(10_000) / RATE_HZ, dtype=np.float32)[None]


def mel(frequency_hz):
    return 2595 * np.log10(1 + frequency_hz / 700)


def hertz(mels):
    return 700 * (10 ** (mels / 2595) - 1)


def slow_log_mel(waveform, parameters):
    """Channel by channel, row by row, band by band, in double precision, with SciPy's windows and NumPy's FFT."""
    n, hop, rate_hz = parameters.window, parameters.hop, parameters.sample_rate_hz
    edges_hz = hertz(np.linspace(0, mel(rate_hz / 2), parameters.mels + 2))
    bins_hz = np.arange(n // 2 + 1) * rate_hz / n
    window = signal.get_window("hann", n)
    values = np.empty((len(waveform), 1 + waveform.shape[1] // hop, parameters.mels))
    for channel, samples in enumerate(waveform.astype(np.float64)):
        padded = np.concatenate([np.zeros(n // 2), samples, np.zeros(n)])
        for row in range(values.shape[1]):
            power = np.abs(np.fft.rfft(window * padded[row * hop : row * hop + n])) ** 2
            for band, (low, middle, high) in enumerate(zip(edges_hz, edges_hz[1:], edges_hz[2:], strict=False)):
                triangle = np.interp(bins_hz, [low, middle, high], [0, 1, 0])
                values[channel, row, band] = np.log(max(triangle @ power, parameters.floor))
    return values


def noise(channels=8, seconds=0.2, seed=0):
    return np.random.default_rng(seed).normal(0, 0.05, (channels, round(seconds * RATE_HZ))).astype(np.float32)


def chirp():
    times = np.arange(RATE_HZ // 4) / RATE_HZ
    return (0.5 * signal.chirp(times, 100, 0.25, 18_000) + noise(1, 0.25)[0] * 0.01).astype(np.float32)[None]


@pytest.mark.parametrize(
    "waveform", [noise(2), chirp(), noise(1) * 1e-4, TONE], ids=["noise", "chirp", "quiet", "tone"]
)
def test_values_are_those_of_the_slow_way(waveform):
    np.testing.assert_allclose(log_mel(waveform), slow_log_mel(waveform, LogMelParameters()), atol=1e-4)


@pytest.mark.parametrize(
    "parameters",
    [
        LogMelParameters(sample_rate_hz=16_000, window=512, hop=160, mels=40, floor=1e-3),
        LogMelParameters(window=1000, hop=1500, mels=20),
        LogMelParameters(window=400, hop=100, mels=16),
    ],
)
def test_other_parameters_too(parameters):
    waveform = noise(1)
    mels = log_mel(waveform, sample_rate_hz=parameters.sample_rate_hz, parameters=parameters)
    np.testing.assert_allclose(mels, slow_log_mel(waveform, parameters), atol=1e-4)


def test_real_recording_agrees_with_the_slow_way(real_dataset_root):
    samples, _ = soundfile.read(real_dataset_root / "audio" / "000618.wav", dtype="float32")
    waveform = samples.T[:2, :40_000]
    np.testing.assert_allclose(log_mel(waveform), slow_log_mel(waveform, LogMelParameters()), atol=1e-4)


def test_eight_channels_are_the_channels_one_by_one():
    waveform = noise(8, 0.5) * np.linspace(0.1, 2, 8, dtype=np.float32)[:, None]
    single = np.concatenate([log_mel(waveform[channel : channel + 1]) for channel in range(8)])
    np.testing.assert_array_equal(log_mel(waveform), single)


@pytest.mark.parametrize(("samples", "rows"), [(1, 1), (1023, 1), (1024, 2), (2047, 2), (44_100, 44), (441_000, 431)])
def test_a_row_per_hop_however_short_the_sound(samples, rows):
    mels = log_mel(np.full((1, samples), 0.1, np.float32))
    assert mels.shape == (1, rows, 128)
    assert mels.dtype == np.float32
    assert np.isfinite(mels).all()
    assert LogMelParameters().rows(samples) == rows


def test_silence_is_the_logarithm_of_the_floor():
    np.testing.assert_allclose(log_mel(np.zeros((8, 5000), np.float32)), np.log(1e-7), rtol=1e-6)


@pytest.mark.parametrize("frequency_hz", [200.0, 1000.0, 5000.0, 15_000.0])
def test_a_tone_is_loudest_in_its_own_band(frequency_hz):
    tone = 0.3 * np.sin(2 * np.pi * frequency_hz * np.arange(RATE_HZ) / RATE_HZ)
    band = log_mel(tone[None])[0, 20].argmax()
    step = mel(RATE_HZ / 2) / 129
    assert abs(mel(frequency_hz) - (band + 1) * step) <= step * 0.6


def test_rows_are_centred_on_their_times():
    parameters = LogMelParameters()
    waveform = np.zeros((1, RATE_HZ), np.float32)
    click_s = 0.5
    waveform[0, round(click_s * RATE_HZ)] = 1
    loudest = log_mel(waveform)[0].sum(axis=1).argmax()
    assert parameters.row_s == pytest.approx(0.02322, abs=1e-5)
    assert abs(loudest * parameters.row_s - click_s) <= parameters.row_s / 2


@pytest.mark.parametrize("rate_hz", [8_000, 16_000, 22_050, 48_000, 96_000, 44_101])
def test_another_rate_gives_the_rows_of_the_same_sound(rate_hz):
    def tones(rate):
        times_s = np.arange(rate // 2) / rate
        return sum(0.1 * np.sin(2 * np.pi * hz * times_s) for hz in (300, 1100, 3000))[None]

    mels, expected = log_mel(tones(rate_hz), sample_rate_hz=rate_hz), log_mel(tones(RATE_HZ))
    assert abs(mels.shape[1] - expected.shape[1]) <= 1
    inner = slice(3, 18)
    loud = expected[:, inner] > 0
    assert loud.sum() > 50
    np.testing.assert_allclose(mels[:, inner][loud], expected[:, inner][loud], atol=0.05)


def test_the_waveform_stays_as_it_is():
    waveform = noise(2)
    before = waveform.copy()
    log_mel(waveform)
    np.testing.assert_array_equal(waveform, before)
    waveform.flags.writeable = False
    log_mel(waveform)


@pytest.mark.parametrize(
    ("waveform", "message"),
    [
        (np.zeros(100, np.float32), r"waveform must have shape \(channels, samples\).*got \(100,\)"),
        (np.zeros((8, 0), np.float32), r"at least 1, got \(8, 0\)"),
        (np.zeros((0, 8), np.float32), r"at least 1, got \(0, 8\)"),
        (np.zeros((1, 8), np.int16), "floating numbers in -1..1, got int16"),
        (np.full((1, 8), np.nan), "finite"),
        (np.full((1, 8), np.inf), "finite"),
    ],
)
def test_what_is_no_waveform_is_said(waveform, message):
    with pytest.raises(ArgumentError, match=message):
        log_mel(waveform)


def test_numbers_out_of_range_are_refused():
    with pytest.raises(ArgumentError, match="sample_rate_hz must be at least 1, got 0"):
        log_mel(noise(1), sample_rate_hz=0)
    for name in ("sample_rate_hz", "window", "hop", "mels"):
        with pytest.raises(ArgumentError, match=f"{name} must be at least 1, got 0"):
            LogMelParameters(**{name: 0})
    with pytest.raises(ArgumentError, match="window must be even, got 401"):
        LogMelParameters(window=401)
    for floor in (-1.0, np.inf, np.nan):
        with pytest.raises(ArgumentError, match="floor must be finite and not negative"):
            LogMelParameters(floor=floor)
