from dataclasses import replace

import numpy as np
import pytest
import torch

from corsmal.errors import ArgumentError
from corsmal.filling import read_filling, save_filling
from corsmal.filling.config import PooledConfig
from corsmal.filling.pooled import PooledModel, _pooled
from tests.filling.made import made_features

SMALL = PooledConfig(channels=3, features=8, hidden=4)


def model():
    torch.manual_seed(0)
    return PooledModel(SMALL).eval()


def recording(rows, *, seed=0):
    return torch.from_numpy(made_features(rows, seed=seed, channels=3, width=8))[None]


def test_statistics_are_those_of_the_normalised_rows():
    features = recording(5)
    x = features[0].numpy().astype(np.float64)
    x = (x - x.mean(axis=-1, keepdims=True)) / np.sqrt(x.var(axis=-1, keepdims=True) + 1e-5)
    expected = np.concatenate([x.mean(axis=1), x.max(axis=1), x.std(axis=1)], axis=1)
    found = _pooled(features, torch.ones(1, 5, dtype=torch.bool))[0].numpy()
    assert found == pytest.approx(expected, abs=1e-5)


def test_recording_is_answered_alike_in_any_batch():
    network = model()
    features, mask = torch.zeros(2, 3, 7, 8), torch.ones(2, 7, dtype=torch.bool)
    features[0], features[1, :, :3] = recording(7)[0], recording(3, seed=1)[0]
    mask[1, 3:] = False
    types, levels, rows = network.explain(features, mask)
    alone = network(recording(3, seed=1))
    assert torch.allclose(types[1:], alone[0], atol=1e-6)
    assert torch.allclose(levels[1:], alone[1], atol=1e-6)
    assert rows[1].tolist() == pytest.approx([1 / 3] * 3 + [0] * 4)


def test_statistics_are_standardised_and_a_missing_view_is_an_average_one():
    network = model()
    given = [made_features(rows, seed=rows, channels=3, width=8) for rows in (3, 5, 9)]
    network.learn_statistics(given)
    values = torch.cat([_pooled(torch.from_numpy(x)[None], torch.ones(1, x.shape[1], dtype=torch.bool)) for x in given])
    assert torch.allclose(network.pooled_mean, values.mean(dim=0), atol=1e-6)
    assert torch.allclose(network.pooled_std, values.std(dim=0, correction=0), atol=1e-6)
    missing = recording(4)
    missing[:, 1] = 0
    x = (_pooled(missing, torch.ones(1, 4, dtype=torch.bool)) - network.pooled_mean) / network.pooled_std
    x[:, 1] = 0
    expected = network.level_head(torch.nn.functional.gelu(network.first(x.flatten(1))))
    assert torch.allclose(network(missing)[1], expected, atol=1e-6)


def test_what_never_changes_is_not_enlarged():
    network = model()
    network.learn_statistics([made_features(4, channels=3, width=8)] * 2)
    assert (network.pooled_std == 1).all()


def test_network_is_read_back(tmp_path):
    written = model()
    written.learn_statistics([made_features(rows, channels=3, width=8) for rows in (3, 5)])
    save_filling(tmp_path / "filling.safetensors", [written])
    [found] = read_filling(tmp_path / "filling.safetensors")
    assert found.config == SMALL
    assert torch.equal(found(recording(4))[1], written(recording(4))[1])


@pytest.mark.parametrize("changes", [{"hidden": 0}, {"dropout": 1.0}, {"features": 2.0}, {"network": "recurrent"}])
def test_wrong_sizes_are_refused(changes):
    with pytest.raises(ArgumentError):
        replace(SMALL, **changes)
