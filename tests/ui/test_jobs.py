import subprocess
import sys
import threading
import time

import pytest

from corsmal.errors import FileError
from corsmal.ui.job import Job, Priority, progress_text
from corsmal.ui.jobs import Jobs, Viewer


def finished(job: Job) -> Job:
    """Wait for a job."""
    deadline = time.monotonic() + 10
    while job.active:
        assert time.monotonic() < deadline
        time.sleep(0.001)
    return job


def test_work_runs_and_says_how_far_it_is():
    jobs = Jobs()
    job = jobs.start("a", "Counting", lambda job: (job.advance(0, 4), job.advance(3, 4)))
    finished(job)
    assert (job.state, job.done, job.total) == ("done", 3, 4)
    assert job.seconds_left is not None
    assert Job("new").seconds_left is None


def test_a_forecast_takes_the_place_of_the_pace_so_far():
    job = Job("Making", done=1, total=4, started_s=time.monotonic() - 10)
    assert job.seconds_left == pytest.approx(30, abs=1)
    job.forecast(None)
    assert job.seconds_left is None
    assert progress_text(job, "%") == "Making: 25 %"
    job.forecast(60)
    assert job.seconds_left == pytest.approx(60, abs=1)
    job.forecast(-5)
    assert job.seconds_left == 0
    assert progress_text(job, "%") == "Making: 25 %, taking longer than expected"
    job.forecast(60.4, is_at_most=True)
    assert progress_text(job, "%") == "Making: 25 %, at most 60 s left"


def test_the_part_of_a_step_moves_the_bar_and_a_clock_stands_still_while_others_go_first():
    job = Job("Making", done=1, total=4, part=0.5)
    assert job.fraction == 0.375
    before_s = job.worked_s()
    job.waited(100)
    assert job.worked_s() == pytest.approx(before_s - 100, abs=1)


def test_the_same_work_asked_for_twice_is_one_job():
    jobs, gate, runs = Jobs(), threading.Event(), []

    def work(job):
        runs.append(job)
        gate.wait(10)

    first, second = jobs.start("a", "x", work), jobs.start("a", "x", work)
    assert first is second
    assert first.active
    gate.set()
    finished(first)
    assert len(runs) == 1
    assert jobs.start("a", "x", work) is not first


def test_cancelled_work_says_so():
    jobs, gate = Jobs(), threading.Event()
    job = jobs.start("a", "x", lambda _: gate.wait(10))
    job.cancel()
    gate.set()
    assert finished(job).state == "cancelled"
    assert job.cancelled()


def test_work_that_fails_leaves_a_sentence_and_the_next_one_runs():
    def expected(_):
        raise FileError("weights.pth", "is not there")

    def unexpected(_):
        raise ZeroDivisionError("x")

    jobs = Jobs()
    first, second = jobs.start("a", "Detecting", expected), jobs.start("b", "Detecting", unexpected)
    finished(first)
    finished(second)
    assert (first.state, first.problem) == ("failed", "weights.pth: is not there")
    assert second.state == "failed"
    assert "Detecting stopped unexpectedly" in second.problem


class Steps:
    """Work that takes steps when it is told to, and notes them in a list that others share."""

    def __init__(self, name: str, noted: list[str]) -> None:
        self.name, self.noted = name, noted
        self.gate = threading.Semaphore(0)

    def __call__(self, job: Job) -> None:
        for step in range(3):
            if job.cancelled():
                return
            assert self.gate.acquire(timeout=10)
            self.noted.append(f"{self.name}{step}")
            job.advance(step + 1, 3)


def until(condition) -> None:
    deadline = time.monotonic() + 10
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.001)


def test_jobs_of_one_priority_run_one_after_the_other_as_they_were_started():
    jobs, noted = Jobs(), []
    works = [Steps(name, noted) for name in "ab"]
    first, second = (jobs.start(work.name, f"Job {work.name}", work) for work in works)
    for work in works:
        work.gate.release(3)
    finished(second)
    assert first.state == second.state == "done"
    assert noted == ["a0", "a1", "a2", "b0", "b1", "b2"]


def test_a_job_that_waits_says_what_for_and_can_be_cancelled():
    jobs, noted = Jobs(), []
    first, second = Steps("a", noted), Steps("b", noted)
    jobs.start("a", "The first", first)
    waiting = jobs.start("b", "The second", second)
    until(lambda: waiting.waits_for)
    assert (waiting.state, waiting.active) == ("waiting", True)
    assert progress_text(waiting, "frames") == "The second: place 1 in the queue, waits for “The first”"
    waiting.cancel()
    assert finished(waiting).state == "cancelled"
    first.gate.release(3)
    until(lambda: jobs.state("a") == "done")
    assert noted == ["a0", "a1", "a2"]


def test_the_place_in_the_queue_is_that_of_the_priority_and_moves_up():
    jobs, noted = Jobs(), []
    works = [Steps(name, noted) for name in "abcd"]
    a, b, c = (jobs.start(work.name, work.name, work) for work in works[:3])
    until(lambda: (b.place, c.place) == (1, 2))
    d = jobs.start("d", "d", works[3], priority=Priority.SHOWN)
    until(lambda: (d.state, d.place) == ("running", 0))
    until(lambda: (b.place, c.place) == (2, 3))
    for work in (works[3], works[0]):
        work.gate.release(3)
    until(lambda: (b.state, b.place, c.place) == ("running", 0, 1))
    assert progress_text(c, "frames") == "c: place 1 in the queue, waits for “b”"
    for work in works[1:3]:
        work.gate.release(3)
    assert finished(c).state == finished(a).state == "done"


def test_the_log_says_how_long_a_job_had_the_cores_and_waited(caplog: pytest.LogCaptureFixture):
    caplog.set_level("INFO", "corsmal.ui.jobs")
    jobs, gate = Jobs(), threading.Event()
    first = jobs.start("a", "First", lambda _job: gate.wait(10))
    second = jobs.start("b", "Second", lambda _job: None)
    time.sleep(0.3)
    gate.set()
    finished(first)
    finished(second)
    while len(caplog.messages) < 2:
        time.sleep(0.001)
    assert caplog.messages[0].startswith("First: done; had the cores for 0.")
    assert caplog.messages[0].endswith("waited 0.0 s")
    assert caplog.messages[1].startswith("Second: done; had the cores for 0.0 s")
    assert float(caplog.messages[1].split()[-2]) >= 0.3


def test_a_job_of_a_lower_priority_yields_after_its_step_and_then_resumes():
    jobs, noted = Jobs(), []
    run, now = Steps("run", noted), Steps("now", noted)
    lower = jobs.start("run", "A run", run)
    run.gate.release()
    until(lambda: noted == ["run0"])
    higher = jobs.start("now", "A search", now, priority=Priority.NOW)
    run.gate.release()  # the step that was begun
    until(lambda: noted == ["run0", "run1"])
    until(lambda: lower.state == "waiting")
    run.gate.release()
    now.gate.release(3)
    finished(higher)
    finished(lower)
    assert noted == ["run0", "run1", "now0", "now1", "now2", "run2"]
    assert lower.state == "done"


def test_a_job_of_a_higher_priority_does_not_wait_for_the_others_step():
    jobs, noted = Jobs(), []
    run, now = Steps("run", noted), Steps("now", noted)
    lower = jobs.start("run", "A run", run)
    until(lambda: lower.state == "running")
    now.gate.release(3)
    finished(jobs.start("now", "A search", now, priority=Priority.NOW))
    assert noted == ["now0", "now1", "now2"]
    run.gate.release(3)
    finished(lower)


def test_the_time_spent_waiting_is_no_part_of_the_pace():
    job = Job("Run", done=1, total=2, started_s=time.monotonic() - 100)
    job.forecast(10)
    job.waited(90)
    assert job.seconds_left == pytest.approx(100, abs=1)
    paced = Job("Run", done=1, total=2, started_s=time.monotonic() - 100)
    paced.waited(90)
    assert paced.seconds_left == pytest.approx(10, abs=1)


def test_what_begins_by_itself_ends_when_no_session_shows_it():
    jobs, noted, one, two = Jobs(), [], Viewer(), Viewer()
    work = Steps("a", noted)
    for viewer in (one, two):
        jobs.show(viewer, "detections", "a")
    job = jobs.start("a", "A search", work, priority=Priority.NOW, is_automatic=True)
    jobs.show(one, "detections", "b")
    assert not job.is_left
    jobs.show(two, "known when", "c")  # another part of the page
    assert not job.is_left
    jobs.show(two, "detections", "b")
    assert job.is_left
    work.gate.release(3)
    assert finished(job).state == "cancelled"
    assert len(noted) < 3


def test_what_was_asked_for_loses_its_priority_when_no_session_shows_it():
    jobs, noted, viewer = Jobs(), [], Viewer()
    asked, shown = Steps("asked", noted), Steps("shown", noted)
    jobs.show(viewer, "detections", "asked")
    first = jobs.start("asked", "All frames", asked, priority=Priority.SHOWN)
    until(lambda: first.state == "running")
    jobs.show(viewer, "detections", "shown")
    assert first.rank == Priority.RUN
    second = jobs.start("shown", "All frames", shown, priority=Priority.SHOWN)
    asked.gate.release(3)
    shown.gate.release(3)
    finished(second)
    jobs.show(viewer, "detections", "asked")
    assert finished(first).state == "done"
    assert noted.index("shown2") < noted.index("asked2")


def test_a_session_that_has_ended_shows_nothing():
    jobs, noted, one, gone = Jobs(), [], Viewer(), Viewer()
    work = Steps("a", noted)
    for viewer in (one, gone):
        jobs.show(viewer, "detections", "a")
    del gone, viewer
    job = jobs.start("a", "A search", work, is_automatic=True)
    jobs.show(one, "detections", "b")
    assert job.is_left
    work.gate.release(3)
    assert finished(job).state == "cancelled"


def test_results_are_counted():
    job = Jobs().start("a", "x", lambda job: (job.keep(), job.keep()))
    assert finished(job).results == 2
    assert Job("new").results == 0


@pytest.mark.parametrize(
    ("done", "total", "elapsed_s", "expected"),
    [
        (0, 0, 3, "Detecting …"),
        (0, 10, 3, "Detecting: 0 of 10 frames"),
        (5, 10, 20, "Detecting: 5 of 10 frames, about 20 s left"),
        (1, 10, 20, "Detecting: 1 of 10 frames, about 3 min left"),
        (10, 10, 20, "Detecting: 10 of 10 frames"),
    ],
)
def test_progress_is_said_in_a_sentence(monkeypatch, done, total, elapsed_s, expected):
    clock = [1000.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    job = Job("Detecting", started_s=1000.0 - 60)  # for a minute networks were loaded
    job.advance(0, total)
    clock[0] += elapsed_s
    job.advance(done, total)
    assert progress_text(job, "frames") == expected
    assert job.fraction == (done / total if total else 0)


@pytest.mark.parametrize("heeds", [True, False])
def test_jobs_end_with_the_process_and_are_told_so(heeds):
    program = f"""
import threading
from corsmal.ui import jobs

jobs.FAREWELL_S = 20 if {heeds} else 0.1
begun = threading.Event()

def work(job):
    begun.set()
    while not ({heeds} and job.cancelled()):
        threading.Event().wait(0.01)
    print("told", flush=True)

started = jobs.Jobs()
for name in "abc":
    started.start(name, "x", work)
begun.wait()
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.startswith("told") is heeds
    assert done.stderr == ""
