from collections import Counter

import numpy as np
import pytest

from corsmal.errors import ArgumentError
from corsmal.synthetic.scene.containers import ANNOTATED_IDS, CONTAINER_IDS, demo_container
from corsmal.synthetic.scene.looks import DEMO_LOOKS
from corsmal.synthetic.scene.scene import make_scene, sound_events, training_scene
from corsmal.synthetic.writing.plan import PlannedRecording, plan_recordings


def test_the_same_seed_gives_the_same_scene():
    first, second = make_scene(4, container=5), make_scene(4, container=5)
    assert first.timing == second.timing
    assert first.look == second.look
    np.testing.assert_array_equal(first.motion.base_m, second.motion.base_m)
    np.testing.assert_array_equal(first.cameras["view1"].projection, second.cameras["view1"].projection)


def test_another_seed_gives_other_cameras_and_ways():
    first, second = make_scene(4, container=5, scenario=1), make_scene(5, container=5, scenario=1)
    assert not np.allclose(first.cameras["view1"].centre_m, second.cameras["view1"].centre_m)
    assert not np.allclose(first.motion.base_m[0], second.motion.base_m[0])


def test_training_scenes_have_looks_that_the_demo_has_not():
    assert all(training_scene(seed).look not in DEMO_LOOKS for seed in range(30))


@pytest.mark.parametrize("container", CONTAINER_IDS)
def test_every_scene_can_be_heard_and_boxes_are_never_poured_into(container):
    for seed in range(6):
        scene = make_scene(seed, container=container)
        events = sound_events(scene)
        assert events.duration_s == pytest.approx(scene.frames / 30)
        if scene.container.kind == "box":
            assert scene.timing.action != "pour"
            assert scene.filling_type != 3


@pytest.mark.parametrize("scenario", [0, 1, 2])
def test_the_container_is_handed_towards_the_robot_in_the_end(scenario):
    scene = make_scene(2, container=1, scenario=scenario)
    robot = scene.cameras["view3"].centre_m
    away = np.linalg.norm(scene.motion.base_m - robot, axis=1)
    assert away[-1] < away[round(30 * scene.timing.handover_start_s)] - 0.05


def test_what_stands_on_the_table_stands_still_until_it_is_lifted():
    scene = make_scene(2, container=1, scenario=0)
    before = scene.motion.base_m[: int(30 * scene.timing.lift_s)]
    np.testing.assert_allclose(before, before[:1].repeat(len(before), axis=0), atol=1e-9)
    assert before[0, 2] == scene.furniture.table_m[4]


def test_nothing_is_filled_before_the_pour_and_all_of_it_after():
    scene = make_scene(2, container=1, scenario=0, filling=(2, 2))
    frames = [int(30 * time) for time in (scene.timing.action_start_s, scene.timing.action_end_s)]
    assert scene.motion.fill[frames[0] - 1] == 0
    assert scene.motion.fill[frames[1] + 2] == pytest.approx(0.9)


def test_the_plan_has_every_container_twice_with_different_feasible_fillings():
    plan = plan_recordings()
    assert [planned.recording_id for planned in plan[:2]] == ["000000", "000001"]
    for container in CONTAINER_IDS:
        fillings = [planned.filling for planned in plan if planned.container_id == container]
        assert len(set(fillings)) == 2
        assert demo_container(container).is_round or all(filling[0] != 3 for filling in fillings)
    assert {planned.scenario for planned in plan} == {0, 1, 2}
    assert len({planned.look for planned in plan}) == 12
    assert len({planned.filling for planned in plan}) == 7


def test_recordings_to_train_on_hold_every_filling_equally_often_and_none_is_the_demos():
    plan = plan_recordings(recordings_per_container=35, training=True)
    counts = Counter((planned.container_id, planned.filling) for planned in plan)
    assert {container for container, _ in counts} == set(ANNOTATED_IDS)
    assert {(demo_container(container).is_round, count) for (container, _), count in counts.items()} == {
        (True, 5),
        (False, 7),
    }
    [scene, *_] = [planned.scene() for planned in plan[:2]]
    assert (scene.container.container_id, (scene.filling_type, scene.filling_level)) == (1, plan[0].filling)
    assert scene.look not in DEMO_LOOKS
    assert plan == plan_recordings(recordings_per_container=35, training=True)
    assert {planned.seed for planned in plan}.isdisjoint(
        planned.seed for planned in plan_recordings(recordings_per_container=35, training=True, seed=1)
    )


@pytest.mark.parametrize("arguments", [{"seed": -1}, {"recordings_per_container": 0}, {"containers": ()}])
def test_a_plan_that_cannot_be_is_refused(arguments):
    with pytest.raises(ArgumentError, match="seed must not be negative"):
        plan_recordings(**arguments)


def test_masses_in_the_annotation_add_up():
    row = PlannedRecording("000007", 1, 1, (2, 2)).annotation()
    assert row["id"] == 7
    assert row["filling mass"] == round(520 * 0.9 * 0.82)
    assert row["object mass"] == row["container mass"] + row["filling mass"]
