import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from corsmal.errors import ArgumentError
from corsmal.filling import FillingConfig, FillingModel
from corsmal.filling.network import sinusoidal_positions
from tests.filling.made import SMALL, WIDTH, made_features

CONFIGS = {
    "plain": replace(SMALL, standardise=False),
    "standardised": SMALL,
    "with duration": replace(SMALL, duration_input=True),
    "released": replace(SMALL, encoder="normalised", positions="first", norms="shared", activation="squared relu"),
}


@pytest.fixture(params=CONFIGS.values(), ids=CONFIGS.keys())
def model(request):
    return made_model(request.param)


def made_model(config):
    with torch.random.fork_rng():
        torch.manual_seed(0)
        model = FillingModel(config).eval()
    model.learn_statistics([made_features(rows, seed=rows) * 3 + 5 for rows in (4, 9, 20)])
    return model


def whole(recordings, rows):
    return torch.ones(recordings, rows, dtype=torch.bool)


def padded(recordings, *, filler):
    length = max(features.shape[1] for features in recordings)
    batch = np.full((len(recordings), recordings[0].shape[0], length, WIDTH), filler, np.float32)
    mask = np.zeros((len(recordings), length), dtype=bool)
    for index, features in enumerate(recordings):
        batch[index, :, : features.shape[1]] = features
        mask[index, : features.shape[1]] = True
    return torch.from_numpy(batch), torch.from_numpy(mask)


@torch.inference_mode()
def test_default_network_has_the_papers_shapes():
    model = FillingModel(FillingConfig.paper()).eval()
    types, levels, attention = model.explain(torch.zeros(2, 8, 30, 128))
    assert (types.shape, levels.shape, attention.shape) == ((2, 4), (2, 3), (2, 30))
    assert model.cnn.depthwise.weight.shape == (8, 1, 5, 5)
    assert model.cnn.pointwise.weight.shape == (1, 8)
    assert model.cnn(torch.zeros(2, 8, 30, 128), whole(2, 30)).shape == (2, 30, 128)
    assert (len(model.blocks), model.blocks[0].attention.num_heads, model.cls.shape) == (3, 4, (128,))
    for head, classes in ((model.type_head, 4), (model.level_head, 3)):
        layers = [layer for layer in head if isinstance(layer, torch.nn.Linear)]
        assert (len(layers), layers[-1].out_features) == (2, classes)


@torch.inference_mode()
def test_cnn_encoder_is_a_depthwise_and_a_pointwise_convolution():
    cnn = FillingModel(SMALL).cnn
    for parameter in cnn.parameters():
        torch.nn.init.normal_(parameter)
    x = torch.randn(2, 2, 7, WIDTH)
    encoded = cnn(x, whole(2, 7))
    padded = np.pad(x.double().numpy(), ((0, 0), (0, 0), (2, 2), (2, 2)))
    kernels, weights = cnn.depthwise.weight.double().numpy()[:, 0], cnn.pointwise.weight.double().numpy()[0]
    for place in ((0, 0, 0), (1, 3, 8), (0, 6, WIDTH - 1)):
        batch, row, column = place
        windows = padded[batch, :, row : row + 5, column : column + 5]
        channels = (windows * kernels).sum(axis=(1, 2)) + cnn.depthwise.bias.double().numpy()
        assert encoded[place].item() == pytest.approx(channels @ weights + cnn.pointwise.bias.item(), abs=1e-4)


@torch.inference_mode()
def test_cnn_encoder_starts_near_the_mean_of_the_channels():
    x = torch.rand(2, 8, 7, 128)
    encoded = FillingModel(FillingConfig.paper()).cnn(x, whole(2, 7))
    assert (encoded - x.mean(dim=1)).abs().max() < 0.5
    assert np.corrcoef(encoded.flatten(), x.mean(dim=1).flatten())[0, 1] > 0.9


@torch.inference_mode()
@pytest.mark.parametrize("filler", [0.0, 1e4])
def test_padded_batch_gives_the_same_as_one_by_one(model, filler):
    recordings = [made_features(rows, seed=rows) * 3 + 5 for rows in (1, 2, 7, 30)]
    types, levels, attention = model.explain(*padded(recordings, filler=filler))
    for index, features in enumerate(recordings):
        alone = model.explain(torch.from_numpy(features)[None])
        torch.testing.assert_close(types[index], alone[0][0], atol=1e-5, rtol=0)
        torch.testing.assert_close(levels[index], alone[1][0], atol=1e-5, rtol=0)
        rows = features.shape[1]
        torch.testing.assert_close(attention[index, :rows], alone[2][0], atol=1e-5, rtol=0)
        assert not attention[index, rows:].any()


@torch.inference_mode()
def test_forward_is_what_explain_says_without_the_attention(model):
    features = torch.from_numpy(made_features(9))[None]
    types, levels, attention = model.explain(features)
    for logits, explained in zip(model(features), (types, levels), strict=True):
        assert torch.equal(logits, explained)
    torch.testing.assert_close(attention.sum(dim=1), torch.ones(1))


@torch.inference_mode()
def test_last_block_gives_for_the_cls_embedding_alone_what_it_gives_for_all_rows():
    block = made_model(SMALL).blocks[-1]
    x, padding = torch.randn(3, 12, WIDTH), torch.zeros(3, 12, dtype=torch.bool)
    padding[1, 5:] = True
    everything, _ = block(x, padding)
    cls, weights = block(x, padding, cls_only=True)
    torch.testing.assert_close(cls[:, 0], everything[:, 0], atol=1e-5, rtol=0)
    # The weights are a softmax of q k / sqrt(d) per head, worked out from the layer's own matrices.
    keys = block.norm_attention(x)
    projected = keys @ block.attention.in_proj_weight.T + block.attention.in_proj_bias
    q, k, _ = projected.reshape(3, 12, 3, SMALL.heads, WIDTH // SMALL.heads).unbind(dim=2)
    scores = torch.einsum("bhd,bthd->bht", q[:, 0], k) / math.sqrt(WIDTH // SMALL.heads)
    expected = scores.masked_fill(padding[:, None], -math.inf).softmax(dim=-1).mean(dim=1)
    torch.testing.assert_close(weights[:, 0], expected, atol=1e-5, rtol=0)


def test_positions_are_sines_and_cosines():
    positions = sinusoidal_positions(5, 8)
    assert positions.shape == (5, 8)
    for row in range(5):
        for pair in range(4):
            angle = row / 10_000 ** (2 * pair / 8)
            assert positions[row, 2 * pair].item() == pytest.approx(math.sin(angle), abs=1e-6)
            assert positions[row, 2 * pair + 1].item() == pytest.approx(math.cos(angle), abs=1e-6)


@torch.inference_mode()
@pytest.mark.parametrize("name", ["plain", "standardised", "with duration"])
def test_order_of_the_rows_matters(name):
    model = made_model(CONFIGS[name])
    features = torch.from_numpy(made_features(9))[None]
    assert not torch.allclose(model(features)[0], model(features.flip(2))[0], atol=1e-4)


def test_statistics_are_those_of_all_rows_of_all_channels():
    recordings = [made_features(rows, seed=rows) * 2 + 1 for rows in (3, 8)]
    for features in recordings:
        features[..., 2] = 7.0
    model = FillingModel(SMALL)
    model.learn_statistics(recordings)
    rows = np.concatenate([features.reshape(-1, WIDTH) for features in recordings])
    np.testing.assert_allclose(model.feature_mean, rows.mean(axis=0), rtol=1e-5)
    deviation = rows.std(axis=0)
    deviation[2] = 1.0  # what never changes is not divided by zero
    np.testing.assert_allclose(model.feature_std, deviation, rtol=1e-5)
    assert model.duration_mean.item() == pytest.approx((math.log(3) + math.log(8)) / 2)
    assert model.duration_std.item() == pytest.approx((math.log(8) - math.log(3)) / 2)


def test_features_are_left_alone_where_they_are_not_to_be_standardised():
    model = FillingModel(CONFIGS["plain"])
    model.learn_statistics([made_features(5) * 9])
    assert torch.equal(model.feature_mean, torch.zeros(WIDTH))
    assert torch.equal(model.feature_std, torch.ones(WIDTH))


@torch.inference_mode()
def test_only_a_network_with_a_duration_input_hears_it():
    features = torch.from_numpy(made_features(6))[None]
    for config, differs in ((SMALL, False), (CONFIGS["with duration"], True)):
        model = made_model(config)
        before = model(features)[1]
        model.duration_mean += 1
        assert torch.equal(before, model(features)[1]) is not differs


@pytest.mark.parametrize(
    ("shape", "mask"),
    [
        ((2, 2, 5), None),
        ((2, 1, 5, WIDTH), None),
        ((2, 2, 5, WIDTH + 1), None),
        ((2, 2, 0, WIDTH), None),
        ((2, 2, 5, WIDTH), torch.ones(2, 4, dtype=torch.bool)),
        ((2, 2, 5, WIDTH), torch.ones(2, 5)),
        ((2, 2, 5, WIDTH), torch.tensor([[True] * 5, [False] * 5])),
    ],
)
def test_other_shapes_are_refused(shape, mask):
    with pytest.raises(ArgumentError, match="must"):
        FillingModel(SMALL)(torch.zeros(shape), mask)


@pytest.mark.parametrize(
    "changes",
    [
        {"channels": 0},
        {"blocks": 1.0},
        {"heads": 3},
        {"features": 15, "heads": 5},
        {"dropout": 1.0},
        {"dropout": "0.1"},
        {"standardise": 1},
        {"decoding": "best"},
        {"positions": "last"},
        {"encoder": "bare"},
    ],
)
def test_config_that_makes_no_network_is_refused(changes):
    with pytest.raises(ArgumentError, match=next(iter(changes))):
        replace(SMALL, **changes)
