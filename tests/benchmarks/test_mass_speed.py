"""Restoring and weighing one container in a 1280x720 image. Compare the rows of one run."""

import numpy as np
import pytest

from corsmal.demo import MASS_WEIGHTS
from corsmal.mass import MassPredictor, restore_mask
from tests.mass.made import CUP, container, gripped

pytestmark = pytest.mark.benchmark(group="one mask of 1280x720")
SIZES = {"width_top_mm": 98.0, "width_bottom_mm": 61.0, "height_mm": 119.0, "mm_per_px": 0.7}


@pytest.fixture(scope="module")
def mask():
    """A cup of 240 x 300 pixels that a hand half hides."""
    pose = {"base": (640, 560), "tilt_deg": 6}
    profile = tuple((2 * width, 2 * height) for width, height in CUP)
    return gripped(container(profile, size=(720, 1280), **pose), low=80, high=220, **pose)


@pytest.mark.parametrize("axis", ["base", "whole"])
def test_restoring(benchmark, mask, axis):
    assert benchmark(restore_mask, mask, axis=axis).ok


def test_bare_cost_a_copy_of_the_mask_and_a_search_for_its_box(benchmark, mask):
    assert benchmark(lambda: np.argwhere(mask.copy().any(axis=0))).size


@pytest.mark.skipif(not MASS_WEIGHTS.is_file(), reason="the demo's mass network was not trained")
def test_predicting(benchmark, mask):
    predictor = MassPredictor(MASS_WEIGHTS)
    assert benchmark(predictor.predict, mask, **SIZES).ok
