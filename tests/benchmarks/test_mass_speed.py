"""Restoring and weighing one container in a 1280x720 image. Compare the rows of one run."""

import cv2
import numpy as np
import pytest
import torch

from corsmal.mass import MassPredictor, restore_mask
from corsmal.weights import bundled_path
from tests.mass.made import CUP, container, gripped

restoring = pytest.mark.benchmark(group="restore", max_time=0.4)
weighing = pytest.mark.benchmark(group="weigh", max_time=0.4)
SIZES = {"width_top_mm": 98.0, "width_bottom_mm": 61.0, "height_mm": 119.0, "mm_per_px": 0.7}


@pytest.fixture(scope="module")
def mask():
    """A cup of 240 x 300 pixels that a hand half hides."""
    pose = {"base": (640, 560), "tilt_deg": 6}
    profile = tuple((2 * width, 2 * height) for width, height in CUP)
    return gripped(container(profile, size=(720, 1280), **pose), low=80, high=220, **pose)


@restoring
@pytest.mark.parametrize("axis", ["base", "whole"])
def test_restore_a_mask_of_1280x720(benchmark, mask, axis):
    assert benchmark(restore_mask, mask, axis=axis).ok


@restoring
def test_bare_contours_and_mirror_image_of_the_box(benchmark, mask):
    def mirrored():
        x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
        part = np.ascontiguousarray(mask[y : y + height, x : x + width]).view(np.uint8)
        cv2.findContours(part, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
        return cv2.warpAffine(part, np.array([[-1.0, 0.1, width], [0.1, 1.0, 0.0]]), (width, height))

    assert benchmark(mirrored).any()


@pytest.fixture(scope="module")
def predictor():
    return MassPredictor(bundled_path("mass"))


@weighing
def test_mass_of_a_mask_of_1280x720(benchmark, predictor, mask):
    assert benchmark(predictor.predict, mask, **SIZES).ok


@weighing
def test_bare_forward_pass_of_the_mass_network(benchmark, predictor, mask):
    image = torch.from_numpy(predictor.predict(mask, **SIZES).network_input)[None, None]
    numbers = torch.ones(1, predictor.config.numbers)

    @torch.inference_mode()
    def forward():
        return predictor.model(image, numbers)

    assert benchmark(forward) > 0
