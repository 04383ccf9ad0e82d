from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy.special import erf

from corsmal.errors import ArgumentError
from corsmal.filling import read_filling, save_filling
from corsmal.filling.config import ConvolvedConfig, RecurrentConfig
from corsmal.filling.convolved import ConvolvedModel
from corsmal.filling.recurrent import RecurrentModel
from tests.filling.made import made_features

SMALL = ConvolvedConfig(channels=3, features=16, hidden=4)


def model(config=SMALL):
    torch.manual_seed(0)
    return ConvolvedModel(config).eval()


def batch(*rows, seed=0):
    """Recordings of these lengths, and their mask."""
    features, mask = torch.zeros(len(rows), 3, max(rows), 16), torch.zeros(len(rows), max(rows), dtype=torch.bool)
    for index, count in enumerate(rows):
        features[index, :, :count] = torch.from_numpy(made_features(count, seed=seed + index, channels=3))
        mask[index, :count] = True
    return features, mask


def gelu(x):
    return x * (1 + erf(x / np.sqrt(2))) / 2


def slow_level(network, array):
    """The level's logits of one channel, (T, features), row by row in NumPy."""
    values = {name: value.double().numpy() for name, value in network.state_dict().items()}
    rows = [(row - row.mean()) / np.sqrt(row.var() + 1e-5) for row in array.astype(float)]
    for layer in range(network.config.layers):
        weight, bias = values[f"convolutions.{layer}.weight"], values[f"convolutions.{layer}.bias"]
        zero = np.zeros_like(rows[0])
        padded = [zero, *rows, zero]
        rows = [
            gelu(bias + sum(weight[:, :, step] @ padded[place + step] for step in range(3)))
            for place in range(len(rows))
        ]
    total = np.sum(rows, axis=0)
    z = np.concatenate([total / len(rows), np.max(rows, axis=0), total / 8, [np.log(len(rows))]])
    return values["level_head.weight"] @ z + values["level_head.bias"]


@pytest.mark.parametrize("rows", [1, 6])
def test_level_is_that_of_a_slow_reading_row_by_row(rows):
    network = model(replace(SMALL, channels=1))
    array = made_features(rows, channels=1)
    found = network(torch.from_numpy(array)[None])[1][0].detach().numpy()
    assert found == pytest.approx(slow_level(network, array[0]), abs=1e-5)


def test_shapes_and_shares_of_rows():
    features, mask = batch(5, 2)
    types, levels, peaks = model().explain(features, mask)
    assert (types.shape, levels.shape, peaks.shape) == ((2, 4), (2, 3), (2, 5))
    assert torch.allclose(peaks.sum(dim=1), torch.ones(2))
    assert not peaks[1, 2:].any()


def test_recording_is_answered_alike_in_any_batch():
    network = model(replace(SMALL, layers=3, kernel=5))
    features, mask = batch(7, 3)
    features[1, :, 3:] = 9  # what is beyond the end does not matter
    together = network(features, mask)
    alone = network(features[1:, :, :3])
    for one, other in zip(together, alone, strict=True):
        assert torch.allclose(one[1:], other, atol=1e-6)


def test_missing_view_counts_for_nothing():
    network = model()
    features, _ = batch(6)
    features[:, 2] = 0
    with torch.no_grad():
        pooled, _ = network._pooled(features[0], torch.ones(3, 6, dtype=torch.bool))
        expected = network.level_head(torch.cat([pooled[:2].mean(dim=0), torch.log(torch.tensor([6.0]))]))
    assert torch.allclose(network(features)[1][0], expected, atol=1e-6)
    twice = features.clone()
    twice[:, 2] = twice[:, 0]
    assert not torch.allclose(network(twice)[1], network(features)[1], atol=1e-4)


def test_network_is_read_back_beside_one_of_another_form(tmp_path):
    written = [model(), RecurrentModel(RecurrentConfig(channels=3, features=16, hidden=4)).eval()]
    save_filling(tmp_path / "filling.safetensors", written)
    found = read_filling(tmp_path / "filling.safetensors")
    assert [network.config for network in found] == [network.config for network in written]
    features, _ = batch(4)
    for one, other in zip(found, written, strict=True):
        assert torch.equal(one(features)[0], other(features)[0])


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"layers": 0}, "layers"),
        ({"hidden": 2.0}, "hidden"),
        ({"kernel": 4}, "kernel must be odd"),
        ({"dropout": 1.0}, "dropout"),
        ({"network": "recurrent"}, "recurrent"),
    ],
)
def test_wrong_sizes_are_refused(changes, text):
    with pytest.raises(ArgumentError, match=text):
        ConvolvedConfig(**changes)
