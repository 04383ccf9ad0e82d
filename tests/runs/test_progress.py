from dataclasses import replace

import pytest

from corsmal.runs import make_run
from corsmal.runs.progress import RunPace, RunProgress, planned_work
from corsmal.stages.settings import DetectorSettings
from tests.fakes import FakeDetector

WORK = {"a": "read", "b": "read", "c": "detect", "d": "detect", "e": "estimate", "f": "estimate"}


class Clock:
    def __init__(self):
        self.now_s = 100.0

    def __call__(self):
        return self.now_s

    def after(self, seconds):
        self.now_s += seconds


def test_the_rest_is_timed_by_what_it_needs_and_not_promised_before():
    clock = Clock()
    pace = RunPace(WORK, clock=clock)
    assert pace.progress == RunProgress(0, 6, {"read": (0, 2), "detect": (0, 2), "estimate": (0, 2)}, None)
    for name, seconds in (("a", 0.1), ("b", 0.1), ("c", 60.0)):
        clock.after(seconds)
        progress = pace.finished(name)
    assert progress.stages == {"read": (2, 2), "detect": (1, 2), "estimate": (0, 2)}
    assert progress.left_s is None  # no estimate without detection was timed
    clock.after(4.0)
    assert pace.finished("e").left_s == pytest.approx(60 + 4)
    clock.after(4.0)
    assert pace.finished("f").left_s == pytest.approx(60)
    clock.after(50.0)
    assert pace.finished("d") == RunProgress(6, 6, {"read": (2, 2), "detect": (2, 2), "estimate": (2, 2)}, 0.0)


def test_with_several_workers_the_pace_is_that_of_all_together():
    clock = Clock()
    pace = RunPace(dict.fromkeys("abcdefgh", "estimate"), workers=2, clock=clock)
    clock.after(10.0)
    assert pace.finished("a").left_s is None
    clock.after(1.0)
    progress = pace.finished("b")
    assert (progress.left_s, progress.is_at_most) == (pytest.approx(6 * 5.5), True)
    clock.after(7.0)
    assert pace.finished("c").left_s == pytest.approx(5 * 18 / 3)
    clock.after(1.0)
    progress = pace.finished("d")
    assert (progress.left_s, progress.is_at_most) == (
        pytest.approx(4 * 8 / 2),
        False,
    )  # two came before without a start


def test_a_single_recording_is_timed_by_its_frames():
    clock = Clock()
    pace = RunPace({"a": "detect", "b": "detect"}, clock=clock)
    clock.after(2.0)
    assert pace.inspected(1, 40).left_s is None
    clock.after(18.0)
    progress = pace.inspected(10, 40)
    assert progress.left_s == pytest.approx(60 + 80)
    assert progress.fraction == pytest.approx(0.125)
    clock.after(80.0)
    assert (pace.finished("a").left_s, pace.progress.frames) == (pytest.approx(100), None)


def test_what_is_to_be_done_is_known_before_a_network_runs(dataset, settings, store):
    predictors = settings.open()
    plan = lambda digest: [planned_work(each, predictors, digest, store=store) for each in dataset]  # noqa: E731
    assert plan("") == ["estimate"] * 3
    make_run("first", dataset, settings, store=store)
    assert plan("") == ["read", "read", "read"]
    assert plan("a detector") == ["read", "read", "detect"]  # the others have detections beside their videos


def test_a_run_tells_how_far_each_stage_is(dataset, settings, store, monkeypatch):
    monkeypatch.setattr(DetectorSettings, "open", lambda _, **_options: FakeDetector())
    seen: list[RunProgress] = []
    make_run("first", dataset, settings, store=store, recordings=["000000"])
    detecting = replace(settings, detector=DetectorSettings(every=6))
    make_run("second", dataset, detecting, store=store, watch=seen.append)
    assert [each.done for each in seen if each.frames is None] == [0, 1, 2, 3]
    inspected = [each.frames for each in seen if each.frames is not None]
    assert inspected
    assert all(0 <= done <= wanted for done, wanted in inspected)
    assert seen[0].stages == {"read": (0, 1), "detect": (0, 1), "estimate": (0, 1)}
    assert seen[-1].stages == {"read": (1, 1), "detect": (1, 1), "estimate": (1, 1)}
    assert seen[-1].left_s == 0
