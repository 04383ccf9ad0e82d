"""Offsets between views, found from the container's motion and compared with those by which the views were shifted."""

from dataclasses import replace

import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.dataset.clock import FrameClock, Matching, ViewFrames
from corsmal.demo.opening import demo_folder, open_demo
from corsmal.estimation import file_detections
from corsmal.estimation.view_offsets import (
    Track,
    ViewOffset,
    _epipolar_misses,
    _fundamental,
    corrected,
    find_offsets,
    offset_between,
)
from corsmal.stages.detections import load_detections
from corsmal.store import Store
from tests.tiny import tiny_cameras

FPS = 30.0
SHIFTS = (-9, 5)


def lifted(times_s):
    """(n, 3) metres: a cup that stands, is lifted, swung and put down elsewhere."""
    up = np.clip(times_s - 0.6, 0, 1.5)
    return np.column_stack([0.05 * np.sin(3 * up), 0.1 * up, 0.08 + 0.12 * np.sin(2 * up) ** 2])


def tracks(later_s, *, seconds=3.0, still=False):
    """What two cameras see, the second of which began to film later, and says nothing of it."""
    cameras = tiny_cameras()
    times_s = np.arange(round(seconds * FPS)) / FPS
    starts_s = {"view3": 0.0, "view1": later_s}
    seen = {}
    for name, start_s in starts_s.items():
        points_m = lifted(np.zeros_like(times_s) if still else times_s + start_s)
        seen[name] = Track(times_s, cameras[name].project(points_m))
    return seen["view3"], seen["view1"], (cameras["view3"], cameras["view1"])


def test_a_point_lies_on_the_epipolar_lines_of_its_images():
    cameras = tiny_cameras()
    points_m = np.random.default_rng(0).uniform(-0.1, 0.3, (20, 3))
    first, second = cameras["view3"], cameras["view2"]
    matrix = _fundamental(first, second)
    misses = _epipolar_misses(matrix, first.project(points_m), second.project(points_m))
    np.testing.assert_allclose(misses, 0, atol=1e-8)
    aside = second.project(points_m) + np.array([0.0, 5.0])
    assert np.abs(_epipolar_misses(matrix, first.project(points_m), aside)).max() > 1


@pytest.mark.parametrize("frames", [0, 1, -6.25, 3.5, 20])
def test_an_offset_is_found_to_a_part_of_a_frame(frames):
    first, second, cameras = tracks(frames / FPS)
    found = offset_between(first, second, cameras, fps=FPS)
    assert found == pytest.approx(frames / FPS, abs=0.3 / FPS)


def test_nothing_is_found_where_nothing_moves_or_too_little_is_seen():
    assert offset_between(*tracks(0.1, still=True), fps=FPS) is None
    assert offset_between(*tracks(0.1, seconds=0.7), fps=FPS) is None
    first, second, cameras = tracks(1.5, seconds=4.0)  # further away than is searched
    assert offset_between(first, second, cameras, fps=FPS) is None
    assert offset_between(first, Track(np.empty(0), np.empty((0, 2))), cameras, fps=FPS) is None


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    store = Store(tmp_path_factory.mktemp("store"))
    open_demo(store=store)
    return open_dataset(demo_folder(store)), store


def shifted(view, frames):
    """Detections of a view that began to film that many frames later."""
    return replace(view, by_frame={frame - frames: view[frame] for frame in view if frame >= frames})


def test_shifts_of_the_demo_are_found_within_a_frame_and_a_half_or_not_at_all(demo):
    dataset, store = demo
    errors, missed = [], 0
    for recording in dataset:
        views = load_detections(recording, store=store).views
        assert find_offsets(recording, views) == (), recording.id  # filmed together
        for frames in SHIFTS:
            late = find_offsets(recording, {**views, "view2": shifted(views["view2"], frames)})
            assert {each.view for each in late} <= {"view2"}, (recording.id, frames)
            errors += [abs(each.offset_s * FPS - frames) for each in late]
            missed += not late
    assert np.median(errors) <= 0.5
    assert max(errors) <= 1.5
    assert len(errors) >= 2 * missed


def test_a_shift_of_the_real_recording_is_found(real_dataset_root):
    recording = open_dataset(real_dataset_root)["000618"]
    views, _ = file_detections(recording)
    assert find_offsets(recording, views) == ()
    [found] = find_offsets(recording, {**views, "view1": shifted(views["view1"], 9)})
    assert (found.view, found.reference) == ("view1", "view3")
    assert found.offset_s * FPS == pytest.approx(9, abs=1.5)
    given = replace(recording, matching=Matching(offsets_s=(("view1", 0.3),)))
    [found] = find_offsets(given, file_detections(given)[0])  # what is wrongly given is found, too
    assert found.offset_s == pytest.approx(-0.3, abs=0.05)
    better = corrected(given.matching, given.clock(), [found])
    assert dict(better.offsets_s)["view1"] == pytest.approx(0, abs=0.05)


def test_offsets_are_added_to_what_was_matched():
    views = {
        "view1": ViewFrames(90, 30.0, 0.05),
        "view2": ViewFrames(90, 30.0, 0.5),
        "view3": ViewFrames(90, 30.0, 0.0),
    }
    clock = FrameClock(np.arange(90) / 30, 30.0, "view3", views=views)
    late = ViewOffset("view1", "view3", 0.2)
    # begins 0.05 s later by its file, which was taken for the encoder's delay
    assert corrected(Matching(), clock, [late]).offsets_s == (("view1", 0.15),)
    assert corrected(Matching(offsets_s=(("view1", 0.1),)), clock, [late]).offsets_s == (("view1", 0.3),)
    found = [ViewOffset("view2", "view3", -0.1)]  # begins half a second later by its file, and was matched so
    assert corrected(Matching(), clock, found).offsets_s == (("view2", -0.1),)
