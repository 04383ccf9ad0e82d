import numpy as np
import pytest
import torch

from corsmal.errors import ArgumentError
from corsmal.mass import MassConfig, MassModel
from corsmal.mass.sensitivity import mass_sensitivity, weigh

IMAGE = np.random.default_rng(0).random((112, 112)).astype(np.float32)
NUMBERS = {3: (90.0, 60.0, 120.0), 4: (90.0, 60.0, 120.0, 1.1)}


def made(config):
    torch.manual_seed(0)
    model = MassModel(config)
    numbers = torch.tensor([NUMBERS[config.numbers], [50.0, 40.0, 200.0, 0.7][: config.numbers]])
    model.learn_statistics(numbers, torch.tensor([134.0, 40.0]))
    return model.eval()


@pytest.fixture(params=[MassConfig.paper(), MassConfig.tuned()], ids=["paper", "tuned"])
def model(request):
    return made(request.param)


@torch.inference_mode()
def asked_one_by_one(model, rows):
    image = torch.from_numpy(IMAGE)[None, None]
    return [float(model(image, torch.tensor([row], dtype=torch.float32))) for row in rows]


def test_many_sets_of_numbers_are_weighed_like_each_alone(model):
    rows = np.array(NUMBERS[model.config.numbers]) * np.linspace(0.5, 2, 5)[:, None]
    one_by_one = asked_one_by_one(model, rows.tolist())
    np.testing.assert_allclose(weigh(model, IMAGE, rows), one_by_one, rtol=1e-5)


def test_weighing_leaves_the_network_as_it_was(model):
    before = asked_one_by_one(model, [NUMBERS[model.config.numbers]])
    weigh(model, IMAGE, [NUMBERS[model.config.numbers]])
    assert asked_one_by_one(model, [NUMBERS[model.config.numbers]]) == before


def test_each_row_changes_one_number_alone(model):
    numbers, changes = NUMBERS[model.config.numbers], (-0.3, 0.0, 0.2)
    curves = mass_sensitivity(model, IMAGE, numbers, changes=changes)
    assert curves.shape == (len(numbers), 3)
    for index, curve in enumerate(curves):
        rows = [tuple(v * (1 + change) if i == index else v for i, v in enumerate(numbers)) for change in changes]
        np.testing.assert_allclose(curve, asked_one_by_one(model, rows), rtol=1e-5)


def test_numbers_of_the_wrong_count_are_refused(model):
    with pytest.raises(ArgumentError, match=rf"numbers must be \(n, {model.config.numbers}\), got \(1, 2\)"):
        weigh(model, IMAGE, [(1.0, 2.0)])
