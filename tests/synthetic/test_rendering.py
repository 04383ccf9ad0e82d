import numpy as np
import pytest

from corsmal.errors import ArgumentError, NotFoundError
from corsmal.synthetic.render.frame import render_frame
from corsmal.synthetic.render.tracing import limb_entry, profile_crossings
from corsmal.synthetic.scene.cameras import VIEWS
from corsmal.synthetic.scene.containers import CONTAINER_IDS, demo_container
from corsmal.synthetic.scene.scene import make_scene
from tests.tiny import silhouette

SIZE = (320, 180)


def test_a_ray_along_x_enters_and_leaves_a_cylinder_at_its_radius():
    cylinder = np.array([[0.0, 0.1], [0.03, 0.03]])
    start, entry, end, leaving = profile_crossings((-1.0, 0.0, 0.05), (1.0, 0.0, 0.0), cylinder, 0.03)
    assert (start, end) == pytest.approx((0.97, 1.03))
    assert entry == pytest.approx((-1, 0, 0))
    assert leaving == pytest.approx((1, 0, 0))


def test_a_ray_from_above_enters_at_the_mouth_and_leaves_at_the_base():
    cone = np.array([[0.0, 0.1], [0.02, 0.04]])
    start, entry, end, leaving = profile_crossings((0.01, 0.0, 0.5), (0.0, 0.0, -1.0), cone, 0.04)
    assert (start, end) == pytest.approx((0.4, 0.5))
    assert (entry, leaving) == ((0, 0, 1), (0, 0, -1))


def test_a_ray_that_passes_the_widest_part_but_not_the_waist_misses():
    waist = np.array([[0.0, 0.05, 0.1], [0.04, 0.01, 0.04]])
    assert profile_crossings((-1.0, 0.02, 0.05), (1.0, 0.0, 0.0), waist, 0.04)[0] == np.inf


@pytest.mark.parametrize(("height", "expected"), [(0.05, 0.97), (0.1, 0.97), (0.125, 1 - np.sqrt(0.03**2 - 0.025**2))])
def test_a_limb_is_a_cone_with_a_sphere_at_each_end(height, expected):
    assert limb_entry((-1.0, 0.0, height), (1.0, 0.0, 0.0), 0.1, (0.03, 0.03))[0] == pytest.approx(expected)


@pytest.mark.parametrize("container", [1, 4, 5, 6])
@pytest.mark.parametrize("view", VIEWS)
def test_the_amodal_mask_is_the_silhouette_of_the_profile(container, view):
    scene = make_scene(3, container=container, scenario=0)
    outer = scene.container.outer
    expected = silhouette(scene.camera(view, SIZE), (outer.heights_mm, outer.radii_mm), scene.motion.base_m[0])
    found = render_frame(scene, view, 0, size=SIZE).amodal
    # the expected one is a polygon of 180 corners, so that a few pixels at the edge differ
    assert (found ^ expected).sum() <= 0.01 * expected.sum() + 2
    assert expected.sum() > 100


def test_the_amodal_mask_of_a_box_is_the_hull_of_its_corners():
    scene = make_scene(3, container=7, scenario=1)
    frame, half = scene.frames - 1, np.array([193.0, 69.0, 241.0]) / 2000
    corners = np.array([[x, y, z + 1] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    camera = scene.camera("view3", SIZE)
    points = camera.project(scene.motion.base_m[frame] + corners @ scene.motion.rotation[frame].T)
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    inside = np.ones(x.shape, dtype=bool)
    for start in points:
        for end in points:
            side = (points - start) @ np.array([start[1] - end[1], end[0] - start[0]])
            if (side >= -1e-6).all() and np.ptp(side) > 1e-6:
                inside &= (x - start[0]) * (start[1] - end[1]) + (y - start[1]) * (end[0] - start[0]) >= 0
    found = render_frame(scene, "view3", frame, size=SIZE).amodal
    assert inside.sum() > 500
    assert (found ^ inside).sum() <= 2


@pytest.mark.parametrize("container", CONTAINER_IDS)
def test_what_is_visible_is_part_of_the_silhouette(container):
    scene = make_scene(9, container=container)
    for frame in (0, scene.frames // 2, scene.frames - 1):
        truth = render_frame(scene, "view3", frame, size=SIZE)
        assert truth.image.shape == (180, 320, 3)
        assert truth.image.dtype == np.uint8
        assert not (truth.visible & ~truth.amodal).any()


def test_nothing_hides_a_container_on_the_table_and_fingers_hide_a_part_of_a_held_one():
    scene = make_scene(3, container=1, scenario=0, filling=(0, 0))
    alone, held = (render_frame(scene, "view3", frame, size=SIZE) for frame in (0, scene.frames - 1))
    np.testing.assert_array_equal(alone.visible, alone.amodal)
    assert 0.4 < held.visible.sum() / held.amodal.sum() < 0.97


@pytest.mark.parametrize("container", CONTAINER_IDS)
def test_the_robot_sees_a_good_part_of_what_is_handed_over(container):
    scene = make_scene(3, container=container, scenario=1)
    truth = render_frame(scene, "view3", scene.frames - 1, size=SIZE)
    assert truth.amodal.sum() > 300
    assert truth.visible.sum() > 0.4 * truth.amodal.sum()


def test_the_same_frame_is_drawn_alike_twice_and_others_differ():
    first, second = (make_scene(3, container=5, scenario=2) for _ in range(2))
    one, two = render_frame(first, "view1", 40, size=SIZE), render_frame(second, "view1", 40, size=SIZE)
    np.testing.assert_array_equal(one.image, two.image)
    np.testing.assert_array_equal(one.visible, two.visible)
    assert (one.image != render_frame(first, "view1", 41, size=SIZE).image).any()


def test_one_sees_through_a_glass_but_not_through_the_red_cup():
    colours = []
    for container in (1, 3):
        scene = make_scene(3, container=container, scenario=0, filling=(0, 0), look=0)
        truth = render_frame(scene, "view3", 0, size=SIZE)
        colours.append(np.median(truth.image[truth.amodal].astype(float), axis=0))
    assert colours[0][0] > 2.5 * colours[0][1]
    assert np.abs(colours[1][0] - colours[1][1]) < 40


def test_a_filled_glass_looks_fuller_than_an_empty_one():
    outer = demo_container(3)
    scene = make_scene(3, container=3, scenario=1, filling=(1, 2))
    before, after = (render_frame(scene, "view3", frame, size=SIZE) for frame in (0, scene.frames - 1))
    yellow = [
        (truth.image[truth.visible].astype(float) @ (1, 0, -1)).mean() / outer.height_mm for truth in (before, after)
    ]
    assert yellow[1] > yellow[0] + 0.2


@pytest.mark.parametrize("frame", [-1, 10_000])
def test_a_frame_that_is_not_there_is_named(frame):
    with pytest.raises(NotFoundError, match=f"there is no frame {frame}"):
        render_frame(make_scene(0, container=1), "view1", frame, size=SIZE)


def test_a_size_of_other_proportions_is_refused():
    with pytest.raises(ArgumentError, match=r"proportions 16 to 9, got \(100, 100\)"):
        render_frame(make_scene(0, container=1), "view1", 0, size=(100, 100))
