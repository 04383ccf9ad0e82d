import json
from dataclasses import replace

import numpy as np
import pytest
import safetensors.torch
import torch

from corsmal.errors import ArgumentError, FileError
from corsmal.mass import MassConfig, MassModel, MassPrediction, MassPredictor, read_mass, save_mass
from corsmal.weights import ENTRY
from tests.mass.made import CUP, container, gripped

CONFIG = MassConfig(channels=(2, 3, 4, 5), hidden=(6, 4))
SIZES = {"width_top_mm": 98.0, "width_bottom_mm": 61.0, "height_mm": 119.0}


def made_model(config=CONFIG):
    torch.manual_seed(0)
    model = MassModel(config)
    model.learn_statistics(torch.rand(20, config.numbers) * 40 + 50, torch.rand(20) * 100)
    return model.eval()


@pytest.fixture
def weights(tmp_path):
    path = tmp_path / "mass.safetensors"
    save_mass(path, made_model())
    return path


@pytest.fixture
def mask():
    return gripped(container(CUP))


def test_prediction_is_the_networks_answer(weights, mask):
    found = MassPredictor(weights).predict(mask, **SIZES)
    assert found.ok
    model = read_mass(weights)
    with torch.no_grad():
        expected = model(torch.from_numpy(found.network_input)[None, None], torch.tensor([[98.0, 61.0, 119.0]]))
    assert found.mass_g == pytest.approx(float(expected[0]))
    assert found.restored.added.any()
    assert found.network_input.shape == (112, 112)


def test_the_mass_hangs_on_the_dimensions_and_the_padding(weights, mask):
    predictor = MassPredictor(weights)
    changes = {}, {"height_mm": 60.0}, {"width_top_mm": 50.0}
    masses = {predictor.predict(mask, **{**SIZES, **change}).mass_g for change in changes}
    wider = weights.with_name("wider.safetensors")
    save_mass(wider, made_model(replace(CONFIG, padding_px=40)))
    masses.add(MassPredictor(wider).predict(mask, **SIZES).mass_g)
    assert len(masses) == 4


def test_a_network_with_scale_needs_it(tmp_path, mask):
    path = tmp_path / "mass.safetensors"
    save_mass(path, made_model(replace(CONFIG, with_scale=True, target="log mass", axis="whole", resize="letterbox")))
    predictor = MassPredictor(path)
    assert predictor.predict(mask, **SIZES, mm_per_px=0.8).ok
    found = predictor.predict(mask, **SIZES)
    assert (found.ok, found.mass_g, found.reason) == (False, None, "mm_per_px is missing")


@pytest.mark.parametrize(
    ("value", "reason"), [(None, "height_mm is missing"), (-4.0, "height_mm must be positive, got -4")]
)
def test_missing_or_negative_dimensions_are_a_failed_record(weights, mask, value, reason):
    found = MassPredictor(weights).predict(mask, **{**SIZES, "height_mm": value})
    assert (found.ok, found.mass_g, found.reason) == (False, None, reason)
    assert found.restored.ok
    assert found.network_input is not None


def test_an_empty_mask_is_a_failed_record(weights):
    found = MassPredictor(weights).predict(np.zeros((30, 40), bool), **SIZES)
    assert (found.ok, found.reason, found.network_input) == (False, "the mask is empty", None)


def test_what_is_no_mask_is_an_error(weights):
    with pytest.raises(ArgumentError, match="mask must be an image"):
        MassPredictor(weights).predict(np.zeros((30, 40)), **SIZES)


def test_a_prediction_has_a_mass_or_a_reason():
    with pytest.raises(ArgumentError, match="either a mass or a reason"):
        MassPrediction(None, "", None, None)
    with pytest.raises(ArgumentError, match="either a mass or a reason"):
        MassPrediction(3.0, "the mask is empty", None, None)


def test_weights_survive_the_file_in_half_precision(weights):
    first, second = made_model(), read_mass(weights)
    assert second.config == CONFIG
    assert not second.training
    torch.testing.assert_close(first.numbers_mean, second.numbers_mean, rtol=0, atol=0)
    for (name, value), other in zip(first.named_parameters(), second.parameters(), strict=True):
        torch.testing.assert_close(value, other, rtol=2e-3, atol=1e-4, msg=name)
    assert weights.stat().st_size < 20_000
    assert MassPredictor(weights).digest == MassPredictor(weights).digest


@pytest.mark.parametrize("content", [b"", b"weights", b"\x08\0\0\0\0\0\0\0{}      "])
def test_a_broken_file_is_named(tmp_path, content):
    path = tmp_path / "mass.safetensors"
    path.write_bytes(content)
    with pytest.raises(FileError, match="is not a file of the mass network's weights") as raised:
        MassPredictor(path)
    assert raised.value.path == path


def test_an_absent_file_and_half_a_file_are_errors(weights, tmp_path):
    weights.write_bytes(weights.read_bytes()[:-100])
    for path, words in (
        (weights, "train mass"),
        (tmp_path / "absent.safetensors", "train mass"),
        (tmp_path, "is no file"),
    ):
        with pytest.raises(FileError, match=words):
            MassPredictor(path)


def rewritten(path, *, config=None, kind="mass", **changes):
    """The same file with other metadata or tensors."""
    with safetensors.safe_open(path, "pt") as file:
        content = json.loads(file.metadata()[ENTRY])
        state = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - not a mapping
    config = json.dumps(content["config"]) if config is None else config
    metadata = {ENTRY: f'{{"kind": "{kind}", "config": {config}, "training": {{}}}}'}
    state = {name: changes.get(name.replace(".", "_"), value) for name, value in state.items()}
    safetensors.torch.save_file({name: value for name, value in state.items() if value is not None}, path, metadata)


@pytest.mark.parametrize("config", ["{", "[]", "{}x", '{"colour": 3}', '{"channels": 3}', '{"hidden": [1, 0]}'])
def test_a_config_of_something_else_is_an_error(weights, config):
    rewritten(weights, config=config)
    with pytest.raises(FileError, match="is not a file of the mass network's weights"):
        MassPredictor(weights)


def test_weights_of_another_network_are_an_error(weights):
    rewritten(weights, kind="filling")
    with pytest.raises(FileError, match="is not a file of the mass network's weights"):
        MassPredictor(weights)


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_weights_that_are_not_finite_are_an_error(weights, value):
    rewritten(weights, last_bias=torch.tensor([value]).half())
    with pytest.raises(FileError, match="not finite"):
        MassPredictor(weights)


@pytest.mark.parametrize("value", [None, torch.zeros(7)])
def test_weights_that_do_not_fit_the_config_are_an_error(weights, value):
    rewritten(weights, last_bias=value)
    with pytest.raises(FileError, match="do not fit the sizes it names"):
        MassPredictor(weights)


def test_there_is_no_such_device(weights):
    with pytest.raises(ArgumentError, match="device 'abacus' cannot be used"):
        MassPredictor(weights, device="abacus")
