import numpy as np
import pytest

from corsmal.detection import Detections, detect_view
from corsmal.errors import ArgumentError, FileError


class Frames:
    """Seven 4x6 frames, each filled with its number; ``broken_from`` cannot be read."""

    size = (6, 4)
    frame_count = 7

    def __init__(self, broken_from=7, ends_at=7):
        self.broken_from, self.ends_at = broken_from, ends_at

    def __getitem__(self, index):
        if index >= self.broken_from:
            raise FileError("view1/rgb/000001.mp4", "is truncated")
        return np.full((4, 6, 3), index, dtype=np.uint8)

    def __iter__(self):
        return (self[index] for index in range(self.ends_at))


class Detector:
    """Reports one detection whose box starts at the frame's number, and remembers the batches."""

    name = "a test's detector"
    digest = "1"

    def __init__(self):
        self.batches = []

    def detect(self, frames):
        numbers = [int(frame[0, 0, 0]) for frame in frames]
        self.batches.append(numbers)
        mask = np.ones((1, 4, 6), dtype=bool)
        return [Detections([[number, 0, 9, 9]], [0.5], [47], mask) for number in numbers]


def starts(view):
    return [int(detections.boxes[0, 0]) for detections in view.values()]


def test_all_frames_are_inspected_in_batches():
    detector, calls = Detector(), []
    view = detect_view(Frames(), detector, batch_size=3, progress=lambda *call: calls.append(call))
    assert detector.batches == [[0, 1, 2], [3, 4, 5], [6]]
    assert calls == [(3, 7), (6, 7), (7, 7)]
    assert view.frames == tuple(range(7))
    assert starts(view) == list(range(7))
    assert view.size == (4, 6)
    assert view.source == "a test's detector"
    assert view.problems == ()


def test_chosen_frames_are_inspected_in_order_and_once():
    detector = Detector()
    view = detect_view(Frames(), detector, frames=[5, 2, 5], batch_size=1)
    assert detector.batches == [[2], [5]]
    assert view.frames == (2, 5)
    assert starts(view) == [2, 5]


def test_no_frames_give_an_empty_view():
    assert len(detect_view(Frames(), Detector(), frames=[])) == 0


def test_what_was_done_before_a_cancel_is_kept():
    detector = Detector()
    view = detect_view(Frames(), detector, batch_size=2, cancelled=lambda: len(detector.batches) == 2)
    assert view.frames == (0, 1, 2, 3)
    assert view.problems == ("detection was stopped", "4 of 7 frames were inspected")


@pytest.mark.parametrize("frames", [None, [0, 1, 2, 3, 4, 6]])
def test_what_was_done_before_the_video_breaks_is_kept(frames):
    view = detect_view(Frames(broken_from=5), Detector(), frames=frames, batch_size=2)
    assert view.frames == (0, 1, 2, 3, 4)
    cannot, inspected = view.problems
    assert cannot == "the video cannot be read on: view1/rgb/000001.mp4: is truncated"
    assert inspected == f"5 of {7 if frames is None else 6} frames were inspected"


def test_a_video_that_is_shorter_than_it_says_is_reported():
    view = detect_view(Frames(ends_at=5), Detector())
    assert view.frames == (0, 1, 2, 3, 4)
    assert view.problems == ("5 of 7 frames were inspected",)


@pytest.mark.parametrize("change", [{"frames": [7]}, {"frames": [-1]}, {"batch_size": 0}])
def test_arguments_out_of_range_are_errors(change):
    with pytest.raises(ArgumentError, match=next(iter(change))):
        detect_view(Frames(), Detector(), **change)


def test_a_detector_that_loses_a_frame_is_an_error():
    detector = Detector()
    detector.detect = lambda _frames: []
    with pytest.raises(ArgumentError, match="0 results for 4 frames"):
        detect_view(Frames(), detector)
