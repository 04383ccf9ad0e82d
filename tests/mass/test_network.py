import pytest
import torch

from corsmal.errors import ArgumentError
from corsmal.mass import MassConfig, MassModel

TINY = {"channels": (2, 3, 4, 5), "hidden": (6, 4)}


@pytest.mark.parametrize("config", [MassConfig(**TINY), MassConfig(**TINY, with_scale=True, target="log mass")])
def test_a_batch_of_masks_becomes_masses(config):
    model = MassModel(config)
    masses = model(torch.rand(3, 1, 112, 112), torch.rand(3, config.numbers) + 50)
    assert masses.shape == (3,)
    assert (masses >= 0).all()


def test_layers_are_those_of_the_paper():
    model = MassModel(MassConfig(**TINY))
    kinds = [type(layer).__name__ for layer in model.blocks]
    assert kinds == ["Conv2d", "ReLU", "BatchNorm2d", "MaxPool2d"] * 4
    assert all(
        (layer.kernel_size, layer.padding, layer.stride) == ((3, 3), (1, 1), (1, 1)) for layer in model.blocks[::4]
    )
    assert model.blocks(torch.zeros(2, 1, 112, 112)).shape == (2, 5, 7, 7)
    kinds = [type(layer).__name__ for layer in model.connected]
    assert kinds == ["Flatten", *["Linear", "ReLU", "BatchNorm1d"] * 2]
    assert (model.last.in_features, model.last.out_features) == (4 + 3, 1)


def test_answer_is_the_last_layer_of_u_and_the_standardised_dimensions():
    model = MassModel(MassConfig(**TINY)).eval()
    numbers = torch.tensor([[98.0, 61.0, 119.0], [69.0, 42.0, 72.0], [80.0, 40.0, 131.0]])
    model.learn_statistics(numbers, torch.tensor([10.0, 2.0, 15.0]))
    images = torch.rand(3, 1, 112, 112)
    u = model.connected(model.blocks(images))
    standardised = (numbers - numbers.mean(dim=0)) / numbers.std(dim=0, correction=0)
    by_hand = torch.cat([u, standardised], dim=1) @ model.last.weight[0] + model.last.bias
    spread = torch.tensor([10.0, 2.0, 15.0]).std(correction=0)
    torch.testing.assert_close(model(images, numbers), by_hand.clamp_min(0) * spread)


def test_first_answers_are_near_the_training_sets_mean():
    model = MassModel(MassConfig(**TINY)).eval()
    model.learn_statistics(torch.rand(20, 3) * 50 + 50, torch.full((20,), 40.0) + torch.arange(20))
    with torch.no_grad():
        model.last.weight.zero_()
    torch.testing.assert_close(model(torch.zeros(2, 1, 112, 112), torch.full((2, 3), 70.0)), torch.tensor([49.5, 49.5]))


def test_a_logarithmic_target_makes_equal_shares_equal_losses():
    model = MassModel(MassConfig(**TINY, target="log mass"))
    targets = model.as_target(torch.tensor([0.0, 1.0, 3.0, 99.0, 199.0]))
    assert targets[0] == 0
    assert targets[2] - targets[1] == pytest.approx(float(targets[4] - targets[3]))
    plain = MassModel(MassConfig(**TINY))
    assert plain.as_target(torch.tensor(5.0)) == 5


def test_equal_dimensions_and_masses_leave_finite_statistics():
    model = MassModel(MassConfig(**TINY)).eval()
    model.learn_statistics(torch.full((4, 3), 60.0), torch.full((4,), 12.0))
    assert torch.isfinite(model(torch.zeros(2, 1, 112, 112), torch.full((2, 3), 60.0))).all()


def test_presets_differ_in_what_the_paper_names_as_weak():
    paper, tuned = MassConfig.paper(), MassConfig.tuned()
    assert (paper.resize, paper.with_scale, paper.target, paper.axis) == ("stretch", False, "mass", "base")
    assert (tuned.resize, tuned.with_scale, tuned.target, tuned.axis) == ("letterbox", True, "log mass", "whole")


@pytest.mark.parametrize(
    "change",
    [
        {"channels": (2, 3, 4)},
        {"channels": (2, 3, 4, 0)},
        {"channels": (2, 3, 4, 5.0)},
        {"hidden": (6,)},
        {"resize": "crop"},
        {"target": "volume"},
        {"axis": "left"},
        {"padding_px": -1},
        {"padding_px": 1.5},
        {"with_scale": 1},
    ],
)
def test_a_config_that_cannot_be_is_an_error(change):
    with pytest.raises(ArgumentError):
        MassConfig(**{**TINY, **change})
