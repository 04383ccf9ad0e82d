"""The filling network and its front end against the plain way. Compare the rows of one run."""

import numpy as np
import pytest
import soundfile
import torch
from torch.nn.functional import cross_entropy
from torchaudio.transforms import MelSpectrogram

from corsmal.dataset.audio import read_audio
from corsmal.filling import FillingConfig, FillingModel, FillingPredictor, FillingSample, log_mel, save_filling
from corsmal.filling.recipe import FillingTraining
from corsmal.filling.samples import Batches

SECONDS, RATE_HZ = 10, 44_100
TRAINING = FillingTraining.paper()
RECORDINGS = 16
"""Of the epoch that is measured: one over 684 takes 43 times as long, both ways."""


@pytest.fixture(scope="module")
def waveform():
    return np.random.default_rng(0).normal(0, 0.05, (8, SECONDS * RATE_HZ)).astype(np.float32)


@pytest.fixture(scope="module")
def path(waveform, tmp_path_factory):
    path = tmp_path_factory.mktemp("speed") / "000001.wav"
    soundfile.write(path, waveform.T, RATE_HZ, subtype="PCM_16")
    return path


def bare_stft(waveform):
    window = torch.hann_window(2048)
    return torch.stft(torch.from_numpy(waveform), 2048, 1024, window=window, return_complex=True)


@pytest.mark.benchmark(group="front end, 8 channels of 10 s")
def test_log_mel(benchmark, waveform):
    assert benchmark(log_mel, waveform).shape == (8, 431, 128)


@pytest.mark.benchmark(group="front end, 8 channels of 10 s")
def test_bare_cost_the_stft_alone(benchmark, waveform):
    assert benchmark(bare_stft, waveform).shape == (8, 1025, 431)


def epoch(model, batches):
    optimiser = torch.optim.AdamW(model.parameters(), 3e-4)
    for batch in batches:
        optimiser.zero_grad()
        for part in batch.parts:
            types, levels = model(part.features, part.mask)
            logits, truth = (types, part.types) if batch.task == "type" else (levels, part.levels)
            (cross_entropy(logits, truth, reduction="sum") / len(batch)).backward()
        optimiser.step()


def samples_of(features):
    return [FillingSample(f"{number:06d}", 1, features, number % 4, number % 3) for number in range(RECORDINGS)]


def plain_batches(path, rng):
    """One recording a batch, its sound read and its log-mel rows computed whenever it is seen."""
    mel = MelSpectrogram(RATE_HZ, n_fft=2048, hop_length=1024, n_mels=128)
    for task in TRAINING.tasks:
        for number in range(RECORDINGS):
            samples = torch.from_numpy(read_audio(path).samples.copy())
            features = mel(samples).clamp_min(1e-7).log().transpose(1, 2).numpy()
            sample = FillingSample(f"{number:06d}", 1, features, number % 4, number % 3)
            yield from Batches([sample], size=1, tasks=[task], rng=rng)


@pytest.fixture
def model():
    torch.manual_seed(0)
    return FillingModel(FillingConfig.paper())


@pytest.mark.benchmark(group="an epoch's two passes over 16 recordings of 10 s")
def test_epoch(benchmark, model, waveform):
    samples, rng = samples_of(log_mel(waveform)), np.random.default_rng(0)
    batches = Batches(samples, size=TRAINING.batch, tasks=TRAINING.tasks, rng=rng)
    benchmark.pedantic(epoch, args=(model, batches), rounds=3)


@pytest.mark.benchmark(group="an epoch's two passes over 16 recordings of 10 s")
def test_plain_epoch(benchmark, model, path):
    rng = np.random.default_rng(0)
    benchmark.pedantic(lambda: epoch(model, plain_batches(path, rng)), rounds=3)


@pytest.fixture
def predictor(tmp_path, model):
    save_filling(tmp_path / "filling.safetensors", [model])
    return FillingPredictor(tmp_path / "filling.safetensors")


@pytest.mark.benchmark(group="inference, 8 channels of 10 s")
def test_front_end_and_prediction(benchmark, predictor, waveform):
    assert benchmark(lambda: predictor.predict(log_mel(waveform))).ok


@pytest.mark.benchmark(group="inference, 8 channels of 10 s")
def test_bare_cost_the_stft_and_the_forward_pass(benchmark, model, waveform):
    batch = torch.from_numpy(log_mel(waveform))[None]
    model.eval()

    @torch.inference_mode()
    def bare():
        bare_stft(waveform)
        return model(batch)

    assert benchmark(bare)
