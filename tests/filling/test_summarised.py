"""What the recurrent and the convolutional network share."""

import pytest
import torch

from corsmal.errors import ArgumentError
from corsmal.filling.config import ConvolvedConfig, RecurrentConfig
from corsmal.filling.network import build_model
from tests.filling.made import made_features


@pytest.fixture(params=[RecurrentConfig, ConvolvedConfig])
def model(request):
    return build_model(request.param(channels=3, features=16, hidden=4)).eval()


def test_durations_are_standardised(model):
    model.learn_statistics([made_features(2, channels=3), made_features(8, channels=3)])
    assert float(model.duration_mean) == pytest.approx(1.3863, abs=1e-4)  # log 4
    assert float(model.duration_std) == pytest.approx(0.6931, abs=1e-4)  # log 2
    model.learn_statistics([made_features(4, channels=3)] * 2)
    assert float(model.duration_std) == 1


def test_wrong_features_are_refused(model):
    features, mask = torch.rand(1, 3, 4, 16), torch.ones(1, 4, dtype=torch.bool)
    for given in ((features[:, :2], None), (features[..., :8], None), (features, mask[:, :2]), (features, ~mask)):
        with pytest.raises(ArgumentError):
            model(*given)
