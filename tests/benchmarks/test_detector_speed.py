"""The demo's detector on one 640x360 frame, beside its network alone. Compare the rows of one run."""

import pytest
import torch

from corsmal.demo import DETECTOR_WEIGHTS
from corsmal.demo.rendering import render_frame
from corsmal.demo.scene import training_scene
from corsmal.detection import SmallDetector

pytestmark = [
    pytest.mark.skipif(not DETECTOR_WEIGHTS.is_file(), reason="the demo's detector was not trained"),
    pytest.mark.benchmark(group="one 640x360 frame"),
]


@pytest.fixture(scope="module")
def detector():
    return SmallDetector(DETECTOR_WEIGHTS)


@pytest.fixture(scope="module")
def image():
    return render_frame(training_scene(1), "view3", 10).image


def test_rendering(benchmark):
    scene = training_scene(1)
    benchmark(render_frame, scene, "view3", 10)


def test_detecting(benchmark, detector, image):
    assert benchmark(detector.detect, [image])


def test_bare_cost_the_forward_pass(benchmark, detector, image):
    batch = [torch.from_numpy(image).permute(2, 0, 1) / 255]

    @torch.inference_mode()
    def forward():
        return detector._network(batch)

    assert benchmark(forward)
