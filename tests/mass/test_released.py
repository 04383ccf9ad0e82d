"""The authors' mass network: its answers, its masks and images, and what is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest
import torch

from corsmal.errors import ArgumentError
from corsmal.mass import MassConfig, MassModel, MassPredictor, read_mass, released, restore_mask
from corsmal.mass.inputs import mass_input, square_image
from corsmal.weights import RELEASED
from tests.released import random_state, slow_mass, write_released

SIZES = (98.0, 61.0, 119.0)
NAMED = dict(zip(("width_top_mm", "width_bottom_mm", "height_mm"), SIZES, strict=True))


def ellipse(cx, cy, rx, ry):
    y, x = np.mgrid[:112, :112]
    return (((x - cx) / rx) ** 2 + ((y - cy) / ry) ** 2 <= 1).astype(np.float32)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return write_released(tmp_path_factory.mktemp("released"))["mass"]


def silent_file(path):
    """A network whose output is never positive."""
    state = random_state("mass")
    state["linear3.bias"][:] = -1e6
    torch.save(state, path)
    return path


def test_masses_of_ellipses_are_those_of_the_authors_program(shared_root):
    folder = shared_root / "reference" / "released"
    for case in json.loads((folder / "networks_expected.json").read_text())["mass"]:
        found = released.mass_g(folder / "task4_random.pt", ellipse(*case["ellipse"]), case["dims"])
        assert found == pytest.approx(case["mass"], rel=1e-4)


def test_masses_are_those_of_the_slow_way(path):
    image = np.random.default_rng(0).random((112, 112))
    expected = slow_mass(random_state("mass"), image, np.array(SIZES))
    assert expected > 2
    assert released.mass_g(path, image, SIZES) == pytest.approx(expected, rel=1e-4)


def test_an_output_of_nothing_is_the_two_grams_of_the_authors_program_and_flagged(tmp_path):
    path = silent_file(tmp_path / "task4.pt")
    assert released.mass_g(path, ellipse(56, 56, 30, 50), SIZES) == 2
    mask = np.zeros((60, 80), bool)
    mask[10:50, 20:45] = True
    prediction = MassPredictor(path).predict(mask, **NAMED)
    assert prediction.mass_g == 2
    [note] = prediction.notes
    assert note == "the network's output is 0 g: the least mass of its training set stands in"
    assert note.flag == "mass-assumed"


@pytest.mark.parametrize(
    ("image", "dimensions", "message"),
    [
        (np.zeros((112, 111)), SIZES, r"image must be \(112, 112\)"),
        (np.full((112, 112), 255), SIZES, r"image must be \(112, 112\) numbers in 0\.\.1"),
        (np.full((112, 112), np.nan), SIZES, "image must be"),
        (np.zeros((112, 112)), (1.0, 2.0), "dimensions must be 3 positive"),
        (np.zeros((112, 112)), (1.0, 2.0, np.nan), "dimensions must be 3 positive"),
        (np.zeros((112, 112)), (98.0, -1.0, 119.0), "dimensions must be 3 positive"),
    ],
)
def test_other_inputs_are_refused_in_a_sentence(path, image, dimensions, message):
    with pytest.raises(ArgumentError, match=message):
        released.mass_g(path, image, dimensions)


def test_predictor_answers_as_the_function_does_and_names_the_network(path):
    mask = np.zeros((200, 150), bool)
    mask[40:150, 30:90] = True
    mask[100:130, 70:90] = False
    predictor = MassPredictor(path)
    prediction = predictor.predict(mask, **NAMED)
    assert prediction.mass_g == pytest.approx(released.mass_g(path, prediction.network_input, SIZES))
    assert predictor.digest.startswith(f"{RELEASED}mass network ")
    assert "task4.pt" in predictor.name
    assert predictor.trained_on is None
    assert read_mass(path).config == replace(MassConfig.released(), least_mass_g=2.0)


def slow_widened(mask):
    """The authors' restoration, row by row, on the box with 15 pixels around it."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    y0, x0 = max(rows[0] - 15, 0), max(columns[0] - 15, 0)
    crop = mask[y0 : rows[-1] + 16, x0 : columns[-1] + 16].copy()
    axis = None
    for row in crop:
        pixels = [place for place, is_in in enumerate(row) if is_in]
        if not pixels:
            continue
        left, right = pixels[0], pixels[-1]
        if axis is None:
            axis = left + (right - left + 1) // 2
            continue
        to_the_left, to_the_right = axis - left + 1, right - axis + 1
        if left <= axis <= right:
            if to_the_left < to_the_right:
                left -= abs(to_the_right - to_the_left)
            else:
                right += abs(to_the_right - to_the_left)
        elif axis < left:
            left = axis - (right - axis + 1)
        else:
            right = axis + (axis - left + 1)
        for place in range(max(left, 0), min(right, crop.shape[1] - 1) + 1):
            row[place] = True
    return crop


def blob(seed):
    """Rows of different lengths and places, some with holes, some beside the axis, some empty."""
    rng = np.random.default_rng(seed)
    mask = np.zeros((70, 90), bool)
    for row in range(rng.integers(0, 20), 60):
        if rng.random() < 0.9:
            left = rng.integers(5, 60)
            mask[row, left : left + rng.integers(1, 30)] = True
    return mask & (rng.random(mask.shape) < 0.95)


@pytest.mark.parametrize("seed", range(12))
def test_masks_are_restored_as_row_by_row(seed):
    mask = blob(seed)
    found = restore_mask(mask, axis="top")
    np.testing.assert_array_equal(found.cropped, slow_widened(mask))
    np.testing.assert_array_equal(found.added, found.mask & ~mask)
    assert found.axis.tilt_deg == 0


def test_a_gripped_side_comes_back_by_hand():
    mask = np.zeros((8, 11), bool)
    mask[1, 3:8] = True  # the axis is column 5
    mask[2, 3:6] = True  # hidden on the right: 2 pixels come back
    mask[3, 6:9] = True  # beside the axis: from 5 - (8 - 5 + 1) = 1
    mask[4, [3, 7]] = True
    found = restore_mask(mask, axis="top", padding_px=2)
    assert found.axis.point == (5, 1)
    rows = {row: np.flatnonzero(found.mask[row]).tolist() for row in range(1, 5)}
    assert rows == {1: [3, 4, 5, 6, 7], 2: [3, 4, 5, 6, 7], 3: [*range(1, 9)], 4: [3, 4, 5, 6, 7]}


def test_image_is_interpolated_between_the_four_nearest_pixels():
    crop = np.zeros((224, 56), bool)
    crop[:, 20:] = True
    image, _ = square_image(crop, resize="stretch", interpolation="linear")
    # column i of 112 lies at (i + 0.5) / 2 - 0.5 of the 56: 39 at 19.25, a quarter of the way to the first white one
    assert image[50, 38:43].tolist() == [0, 0.25, 0.75, 1, 1]
    one = np.zeros((224, 224), bool)
    one[100:102, 100] = True
    exact, _ = square_image(one, resize="stretch", interpolation="linear")
    assert exact[50, 50] == 0.5


def test_input_and_network_have_the_form_of_the_authors_program():
    mask = blob(3)
    given = mass_input(mask, config=MassConfig.released(), **NAMED)
    expected, _ = square_image(slow_widened(mask), resize="stretch", interpolation="linear")
    np.testing.assert_array_equal(given.image, expected)
    assert given.numbers == SIZES
    torch.manual_seed(0)
    model = MassModel(MassConfig.released())
    numbers = torch.rand(9, 3) * 100 + 50
    model.learn_statistics(numbers, torch.rand(9) * 50 + 20)
    with torch.inference_mode():
        answers = model.eval()(torch.zeros(9, 1, 112, 112), numbers)
    assert (answers > 0).any()  # its last ReLU lets gradients through
    assert torch.equal(model.numbers_std, torch.ones(3))
    assert model.target_std == 1
    assert sum(isinstance(layer, torch.nn.BatchNorm1d) for layer in model.modules()) == 1
    assert MassConfig.paper().channels == MassConfig.released().channels == (32, 64, 64, 128)
