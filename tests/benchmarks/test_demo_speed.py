"""Drawing the demo's frames. Compare the rows of one run."""

import pytest

from corsmal.synthetic.render.frame import _photographed, _room, render_frame
from corsmal.synthetic.scene.cameras import DEMO_SIZE
from corsmal.synthetic.scene.scene import training_scene

pytestmark = pytest.mark.benchmark(group="render", max_time=0.5)


@pytest.fixture(scope="module")
def scene():
    return training_scene(1)


def test_render_a_frame_of_the_demo(benchmark, scene):
    assert benchmark(render_frame, scene, "view3", 10).visible.any()


def test_bare_room_with_its_blur_and_noise(benchmark, scene):
    room = _room(scene, "view3", DEMO_SIZE)[0]
    benchmark(lambda: _photographed(room.copy(), scene, "view3", 10))
