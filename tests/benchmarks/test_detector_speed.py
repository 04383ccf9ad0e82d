"""The demo's detector beside its network alone. Compare the rows of one run."""

import itertools

import pytest
import torch

from corsmal.dataset import open_dataset
from corsmal.detection import SmallDetector
from corsmal.parameters import METHOD_VIEWS
from corsmal.stages.search import detect_recording
from corsmal.store import Store
from corsmal.synthetic.render.frame import render_frame
from corsmal.synthetic.scene.scene import training_scene
from corsmal.weights import bundled_path
from tests.tiny import write_tiny_dataset

one_frame = pytest.mark.benchmark(group="detect a frame", max_time=1.5)
one_recording = pytest.mark.benchmark(group="detect a recording")
BATCH = 4


@pytest.fixture(scope="module")
def detector():
    return SmallDetector(bundled_path("detector"))


@pytest.fixture(scope="module")
def image():
    return render_frame(training_scene(1), "view3", 10).image


@torch.inference_mode()
def forward(detector, images):
    return detector._network([torch.from_numpy(image).permute(2, 0, 1) / 255 for image in images])


@one_frame
@pytest.mark.goal(ratio=1.15)
def test_detect_in_one_frame_of_640x360(benchmark, detector, image):
    assert benchmark(detector.detect, [image])


@one_frame
def test_bare_forward_pass(benchmark, detector, image):
    assert benchmark(forward, detector, [image])


@pytest.fixture(scope="module")
def bare_recording(tmp_path_factory):
    """A recording without detections: three views of 16 frames."""
    root = write_tiny_dataset(tmp_path_factory.mktemp("bare"), recordings=1, frames=16)
    for path in root.glob("view*/detections/*.json"):
        path.unlink()
    return open_dataset(root)["000000"]


@one_recording
@pytest.mark.goal(ratio=1.15)
def test_detect_in_48_frames_and_keep_it(benchmark, detector, bare_recording, tmp_path):
    """With decoding, from coarse to fine, and what is stored on the way."""
    numbers = itertools.count()

    def detect():
        detect_recording(bare_recording, detector, store=Store(tmp_path / str(next(numbers))))

    benchmark.pedantic(detect, rounds=3)


@one_recording
def test_bare_forward_passes_in_batches_of_4(benchmark, detector, bare_recording):
    images = []
    for view in METHOD_VIEWS:
        with bare_recording.views[view].video() as video:
            images += list(video)
    batches = [images[first : first + BATCH] for first in range(0, len(images), BATCH)]
    benchmark.pedantic(lambda: [forward(detector, batch) for batch in batches], rounds=3)
