from dataclasses import replace

import numpy as np
import pytest
import torch

from corsmal.errors import ArgumentError
from corsmal.filling import read_filling, save_filling
from corsmal.filling.config import PooledConfig
from corsmal.filling.pooled import PooledModel, _parts, _pooled, condensed
from corsmal.filling.samples import FillingSample, padded
from tests.filling.made import made_features

SMALL = PooledConfig(channels=3, features=8, hidden=4)


def model():
    torch.manual_seed(0)
    return PooledModel(SMALL).eval()


def recording(rows, *, seed=0):
    return torch.from_numpy(made_features(rows, seed=seed, channels=3, width=8))[None]


def statistics(features):
    """The slow, obvious way, (C, 5 · features) from (C, T, features)."""
    x = features.astype(np.float64)
    x = (x - x.mean(axis=-1, keepdims=True)) / np.sqrt(x.var(axis=-1, keepdims=True) + 1e-5)
    parts = np.array_split(x, 4, axis=1) if x.shape[1] >= 4 else [x] * 4
    first, *later = (part.mean(axis=1) for part in parts)
    changes = [part - first for part in later]
    return np.concatenate([*changes, x.std(axis=1), x.max(axis=1) - x.mean(axis=1)], axis=1)


@pytest.mark.parametrize("rows", [1, 3, 4, 5, 6, 7, 8, 21])
def test_statistics_are_changes_of_the_normalised_rows(rows):
    features = recording(rows)
    found = _pooled(features, torch.ones(1, rows, dtype=torch.bool))[0].numpy()
    assert found == pytest.approx(statistics(features[0].numpy()), abs=1e-5)


def test_what_stays_the_same_over_time_is_not_seen():
    features = recording(8).numpy()
    features /= np.sqrt((features**2).sum(axis=-1, keepdims=True))
    same = np.repeat(features[:, :, :1], 8, axis=2)
    found = _pooled(torch.from_numpy(same), torch.ones(1, 8, dtype=torch.bool))
    assert np.abs(found.numpy()).max() < 1e-3


def test_parts_cover_all_rows_once():
    mask = torch.tensor([[True] * 6 + [False] * 3])
    weights = _parts(mask)[0]
    assert weights.sum(dim=1).tolist() == pytest.approx([1, 1, 1, 1])
    assert [row.nonzero()[:, 0].tolist() for row in weights] == [[0, 1], [2, 3], [4], [5]]


def batch(*samples):
    return padded("both", samples, [(0, sample.rows) for sample in samples])


def losses(network, *samples):
    return network.losses(batch(*condensed(samples)))


def sample(container, *, level=1):
    return FillingSample("0", container, made_features(5, seed=container, channels=3, width=8), 1, level)


def test_levels_in_boxes_are_not_learned_and_kinds_are_where_they_are_known():
    network = model()
    cup, box, other = sample(1), sample(7), sample(99)
    both, one = losses(network, cup, box), losses(network, cup)
    assert torch.allclose(both["level"], one["level"], atol=1e-6)
    assert not torch.allclose(both["type"], one["type"], atol=1e-6)
    assert losses(network, box)["level"] == 0
    assert losses(network, other)["kind"] == 0
    kinds = network.seen(*batch(cup, other)[1:3])[2][:1]
    expected = 0.3 * torch.nn.functional.cross_entropy(kinds, torch.tensor([0]))
    assert torch.allclose(losses(network, cup, other)["kind"], expected, atol=1e-6)


def test_condensed_recordings_are_learned_from_as_their_rows_would_be():
    network = model()
    blind = sample(2).features.copy()
    blind[1] = 0
    given = [sample(1), replace(sample(2, level=2), features=blind), sample(3, level=0)]
    network.learn_statistics([own.features for own in given])
    types, levels, kinds = network.seen(*batch(*given)[1:3])
    cross_entropy, found = torch.nn.functional.cross_entropy, losses(network, *given)
    assert torch.allclose(found["level"], cross_entropy(levels, torch.tensor([1, 2, 0])), atol=1e-6)
    assert torch.allclose(found["type"], 0.5 * cross_entropy(types, torch.tensor([1, 1, 1])), atol=1e-6)
    assert torch.allclose(found["kind"], 0.3 * cross_entropy(kinds, torch.tensor([0, 0, 0])), atol=1e-6)


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
