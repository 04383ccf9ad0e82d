import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from corsmal.errors import FileError
from corsmal.filling import loop as fitting
from corsmal.filling import read_filling
from corsmal.filling.loop import fit_network, keeps
from tests.filling.made import JOINT, PAPER, SMALL, made_samples, same, state

each_training = pytest.mark.parametrize(
    "training", [PAPER, JOINT, replace(JOINT, schedule="cosine")], ids=["paper", "joint", "cosine"]
)


def fit(folder, training=PAPER, *, seed=0, progress=None):
    samples = made_samples(28)
    return fit_network(
        folder, samples[:21], training=training, index=0, seed=seed, validation=samples[21:], progress=progress
    )


def test_rule_1_on_a_sequence_of_losses():
    losses = [(1.0, 0.5), (0.9, 0.6), (0.7, 0.7), (0.9, 0.05), (0.86, 0.1), (0.2, 0.2), (0.1, 0.1), (0.1, 0.1)]
    lowest, kept = math.inf, []
    for epoch, (level, kind) in enumerate(losses):
        if keeps(lowest, level, kind):
            lowest = level + kind
            kept.append(epoch)
    # 1: 1.5 is not below 1.5. 3: 0.9 + 0.15 is below 1.4, and L becomes 0.95. 4: 0.86 + 0.15 is above that.
    # 6: 0.30 is below 0.4; L becomes 0.2, which 0.30 never is below again.
    assert kept == [0, 2, 3, 5, 6]


def test_rule_1_never_keeps_what_diverged():
    assert not keeps(math.inf, math.nan, 0.1)
    assert not keeps(math.inf, 0.1, math.inf)


def test_folder_has_the_logs_the_checkpoint_and_the_weights(tmp_path):
    shares = []
    model = fit(tmp_path, progress=shares.append)
    assert shares == pytest.approx([1 / 3, 2 / 3, 1])
    header, *lines = (tmp_path / "log" / "version_0" / "metrics.csv").read_text().splitlines()
    for column in ("epoch", "level_loss", "type_loss", "validation_level_loss", "validation_type_loss"):
        assert column in header.split(",")
    assert len(lines) == 6
    assert list((tmp_path / "tensorboard").glob("events.out.tfevents.*"))
    assert (tmp_path / "checkpoints" / "last.ckpt").is_file()
    assert same(state(read_filling(tmp_path / "network.safetensors")[0]), state(model))


def test_weights_are_those_of_the_epoch_that_rule_1_kept(tmp_path, monkeypatch):
    kept = []
    monkeypatch.setattr(fitting, "keeps", lambda lowest, *_: not kept and not kept.append(lowest))
    first = fit(tmp_path / "a")
    assert kept == [math.inf]
    monkeypatch.undo()
    one_epoch = fit(tmp_path / "b", replace(PAPER, epochs=1))
    assert same(state(first), state(one_epoch))


def test_training_stops_when_no_later_epoch_could_be_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(fitting, "LOSS_FLOOR", 10.0)
    shares = []
    fit(tmp_path, progress=shares.append)
    assert shares == pytest.approx([1 / 3])


class KilledError(Exception):
    """Stands for the end of the process."""


@each_training
def test_run_that_was_killed_goes_on_to_the_same_weights(tmp_path, training):
    def killed(share):
        if share > 0.5:
            raise KilledError

    whole = fit(tmp_path / "whole", training)
    with pytest.raises(KilledError):
        fit(tmp_path / "killed", training, progress=killed)
    assert not (tmp_path / "killed" / "network.safetensors").exists()
    shares = []
    resumed = fit(tmp_path / "killed", training, progress=shares.append)
    assert shares[-1] == pytest.approx(1)
    assert len(shares) < 3
    assert same(state(whole), state(resumed))


def test_finished_run_is_not_trained_again(tmp_path):
    first = fit(tmp_path)
    shares = []
    again = fit(tmp_path, progress=shares.append)
    assert shares == []
    assert same(state(first), state(again))


def test_seeds_give_other_networks_and_leave_the_global_generator_alone(tmp_path):
    torch.manual_seed(5)
    before = torch.get_rng_state()
    first, other = fit(tmp_path / "a", JOINT, seed=0), fit(tmp_path / "b", JOINT, seed=1)
    assert torch.equal(before, torch.get_rng_state())
    assert not torch.equal(first.cls, other.cls)


@each_training
def test_diverged_training_says_so(tmp_path, training):
    with pytest.raises(FileError, match="diverged; delete the folder and lower the learning rate"):
        fit(tmp_path, replace(training, rate=1e30, epochs=2))


@pytest.mark.parametrize("content", [b"", b"no checkpoint", b"PK\x03\x04" + bytes(40)])
def test_broken_checkpoint_is_named(tmp_path, content):
    path = tmp_path / "checkpoints" / "last.ckpt"
    path.parent.mkdir()
    path.write_bytes(content)
    with pytest.raises(FileError, match="delete it to begin again") as raised:
        fit(tmp_path)
    assert raised.value.path == path


def test_network_learns_twenty_recordings_by_heart(tmp_path):
    rng = np.random.default_rng(0)
    samples = [
        replace(sample, features=rng.normal(size=sample.features.shape).astype(np.float32))
        for sample in made_samples(20)
    ]
    training = replace(JOINT, networks=(replace(SMALL, dropout=0.0),), epochs=20, batch=2, rate=3e-3)
    model = fit_network(tmp_path, samples, training=training, index=0, seed=0, validation=[])
    for sample in samples:
        types, levels = model(torch.from_numpy(sample.features)[None])
        assert (int(types.argmax()), int(levels.argmax())) == (sample.filling_type, sample.filling_level)
