from dataclasses import replace

import pytest
import torch

from corsmal.errors import ArgumentError
from corsmal.filling import read_filling, save_filling
from corsmal.filling.config import RecurrentConfig
from corsmal.filling.recurrent import RecurrentModel
from tests.filling.made import made_features

SMALL = RecurrentConfig(channels=3, features=16, hidden=4)


def model(config=SMALL):
    torch.manual_seed(0)
    return RecurrentModel(config).eval()


def batch(*rows, seed=0):
    """Recordings of these lengths, and their mask."""
    features, mask = torch.zeros(len(rows), 3, max(rows), 16), torch.zeros(len(rows), max(rows), dtype=torch.bool)
    for index, count in enumerate(rows):
        features[index, :, :count] = torch.from_numpy(made_features(count, seed=seed + index, channels=3))
        mask[index, :count] = True
    return features, mask


def test_shapes_and_shares_of_rows():
    features, mask = batch(5, 2)
    types, levels, peaks = model().explain(features, mask)
    assert (types.shape, levels.shape, peaks.shape) == ((2, 4), (2, 3), (2, 5))
    assert torch.allclose(peaks.sum(dim=1), torch.ones(2))
    assert not peaks[1, 2:].any()


@pytest.mark.parametrize("both_ways", [True, False])
def test_recording_is_answered_alike_in_any_batch(both_ways):
    network = model(replace(SMALL, both_ways=both_ways))
    features, mask = batch(7, 3)
    together = network(features, mask)
    alone = network(features[1:, :, :3])
    for one, other in zip(together, alone, strict=True):
        assert torch.allclose(one[1:], other, atol=1e-6)


def test_missing_view_counts_for_nothing():
    network = model()
    features, _ = batch(6)
    features[:, 2] = 0
    twice = features.clone()
    twice[:, 2] = twice[:, 0]
    with torch.no_grad():
        pooled, _ = network._pooled(features[0], torch.ones(3, 6, dtype=torch.bool))
        expected = network.level_head(torch.cat([pooled[:2].mean(dim=0), torch.log(torch.tensor([6.0]))]))
    assert torch.allclose(network(features)[1][0], expected, atol=1e-6)
    assert not torch.allclose(network(twice)[1], network(features)[1], atol=1e-4)


def test_network_is_read_back(tmp_path):
    written = [model(), model(replace(SMALL, hidden=6))]
    save_filling(tmp_path / "filling.safetensors", written)
    found = read_filling(tmp_path / "filling.safetensors")
    assert [network.config for network in found] == [network.config for network in written]
    features, _ = batch(4)
    assert torch.equal(found[1](features)[0], written[1](features)[0])


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"hidden": 0}, "hidden"),
        ({"dropout": 1.0}, "dropout"),
        ({"both_ways": 1}, "both_ways"),
        ({"network": "x"}, "x"),
    ],
)
def test_wrong_sizes_are_refused(changes, text):
    with pytest.raises(ArgumentError, match=text):
        RecurrentConfig(**changes)
