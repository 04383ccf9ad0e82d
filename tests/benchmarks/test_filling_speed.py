"""The filling network and its front end. Compare the rows of one run."""

from dataclasses import replace

import numpy as np
import pytest
import soundfile
import torch
from torch.nn.functional import cross_entropy
from torchaudio.transforms import MelSpectrogram

from corsmal.dataset.audio import read_audio
from corsmal.filling import FillingConfig, FillingModel, FillingPredictor, FillingSample, log_mel, save_filling
from corsmal.filling.loop import fit_network
from corsmal.filling.network import sinusoidal_positions
from corsmal.filling.recipe import FillingTraining
from corsmal.filling.samples import Batches

SECONDS, RATE_HZ = 10, 44_100
TRAINING = FillingTraining.paper()
RECORDINGS, FEW = 64, 8
"""An epoch over 684 recordings takes eleven times as long as one over 64, whichever way."""

listening = pytest.mark.benchmark(group="front end", max_time=0.7)
answering = pytest.mark.benchmark(group="inference", max_time=0.7)
learning = pytest.mark.benchmark(group="train")
repeating = pytest.mark.benchmark(group="train an epoch")


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


@listening
def test_log_mel_of_8_channels_of_10_s(benchmark, waveform):
    assert benchmark(log_mel, waveform).shape == (8, 431, 128)


@listening
def test_bare_stft_in_single_precision(benchmark, waveform):
    assert benchmark(bare_stft, waveform).shape == (8, 1025, 431)


def epoch(model, batches):
    optimiser = torch.optim.AdamW(model.parameters(), 3e-4)
    for batch in batches:
        optimiser.zero_grad()
        types, levels = model(batch.features, batch.mask)
        logits, truth = (types, batch.types) if batch.task == "type" else (levels, batch.levels)
        cross_entropy(logits, truth).backward()
        optimiser.step()


def samples_of(features):
    return [FillingSample(f"{number:06d}", 1, features, number % 4, number % 3) for number in range(RECORDINGS)]


class PlainNetwork(torch.nn.Module):
    """The paper's layers as PyTorch has them."""

    def __init__(self, config):
        super().__init__()
        width, classes = config.features, {"types": 4, "levels": 3}
        self.depthwise = torch.nn.Conv2d(config.channels, config.channels, 5, padding=2, groups=config.channels)
        self.pointwise = torch.nn.Conv2d(config.channels, 1, 1)
        self.cls = torch.nn.Parameter(torch.randn(width) * 0.02)
        sizes = {"d_model": width, "nhead": config.heads, "dim_feedforward": config.hidden, "dropout": config.dropout}
        layer = torch.nn.TransformerEncoderLayer(**sizes, activation="gelu", batch_first=True, norm_first=True)
        self.blocks = torch.nn.TransformerEncoder(layer, config.blocks, enable_nested_tensor=False)
        self.heads = torch.nn.ModuleDict(
            {
                name: torch.nn.Sequential(
                    torch.nn.Linear(width, config.head_hidden),
                    torch.nn.GELU(),
                    torch.nn.Dropout(config.dropout),
                    torch.nn.Linear(config.head_hidden, count),
                )
                for name, count in classes.items()
            }
        )

    def forward(self, features, mask):
        x = self.pointwise(self.depthwise(features)).squeeze(1)
        x = torch.cat([self.cls.expand(len(x), 1, -1), x], dim=1)
        padding = torch.cat([mask.new_zeros(len(mask), 1), ~mask], dim=1)
        z = self.blocks(x + sinusoidal_positions(*x.shape[1:]), src_key_padding_mask=padding)[:, 0]
        return self.heads["types"](z), self.heads["levels"](z)


def plain_batches(path, rng):
    """One recording a batch, its sound read and its log-mel rows computed whenever it is seen."""
    mel = MelSpectrogram(RATE_HZ, n_fft=2048, hop_length=1024, n_mels=128)
    for task in TRAINING.tasks:
        for number in range(FEW):
            samples = torch.from_numpy(read_audio(path).samples.copy())
            features = mel(samples).clamp_min(1e-7).log().transpose(1, 2).numpy()
            sample = FillingSample(f"{number:06d}", 1, features, number % 4, number % 3)
            yield from Batches([sample], size=1, tasks=[task], rng=rng)


@pytest.fixture
def model():
    torch.manual_seed(0)
    return FillingModel(FillingConfig.paper())


@learning
def test_train_an_epoch_on_64_recordings_of_10_s(benchmark, waveform, tmp_path):
    """With Lightning, its logs and a checkpoint."""
    samples, numbers = samples_of(log_mel(waveform)), iter(range(10))
    training = replace(TRAINING, epochs=1, keep="last")

    def fit():
        fit_network(tmp_path / str(next(numbers)), samples, training=training, index=0, seed=0, validation=())

    benchmark.pedantic(fit, rounds=3)


@learning
def test_bare_steps_on_batches_that_are_made(benchmark, model, waveform):
    samples = samples_of(log_mel(waveform))
    batches = Batches(samples, size=TRAINING.batch, tasks=TRAINING.tasks, rng=np.random.default_rng(0))
    made = list(batches)
    benchmark.pedantic(lambda: epoch(model, made), rounds=3)


@repeating
@pytest.mark.goal(ratio=0.1)
def test_epoch_on_8_recordings_of_10_s(benchmark, model, waveform):
    """Both tasks, on rows that were computed once."""
    samples = samples_of(log_mel(waveform))[:FEW]
    batches = Batches(samples, size=TRAINING.batch, tasks=TRAINING.tasks, rng=np.random.default_rng(0))
    benchmark.pedantic(lambda: epoch(model, batches), rounds=3, warmup_rounds=1)


@repeating
def test_bare_epoch_that_reads_the_sound_every_time(benchmark, path):
    """With PyTorch's own layers, one recording a batch."""
    network = PlainNetwork(FillingConfig.paper())
    benchmark.pedantic(lambda: epoch(network, plain_batches(path, np.random.default_rng(0))), rounds=1)


@pytest.fixture
def predictor(tmp_path, model):
    save_filling(tmp_path / "filling.safetensors", [model])
    return FillingPredictor(tmp_path / "filling.safetensors")


@answering
def test_filling_of_8_channels_of_10_s(benchmark, predictor, waveform):
    assert benchmark(lambda: predictor.predict(log_mel(waveform))).ok


@answering
def test_bare_stft_and_forward_pass(benchmark, model, waveform):
    batch = torch.from_numpy(log_mel(waveform))[None]
    model.eval()

    @torch.inference_mode()
    def bare():
        bare_stft(waveform)
        return model(batch)

    assert benchmark(bare)
