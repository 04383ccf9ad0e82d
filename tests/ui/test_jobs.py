import subprocess
import sys
import threading
import time

import pytest

from corsmal.errors import FileError
from corsmal.ui.jobs import Job, Jobs, progress_text


def finished(job: Job) -> Job:
    """Wait for a job."""
    deadline = time.monotonic() + 10
    while job.active:
        assert time.monotonic() < deadline
        time.sleep(0.001)
    return job


def test_work_runs_and_says_how_far_it_is():
    jobs = Jobs()
    job = jobs.start("a", "Counting", lambda job: job.advance(3, 4))
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


def test_two_jobs_run_at_a_time_and_the_third_waits():
    jobs, gate, begun = Jobs(), threading.Event(), threading.Barrier(3)

    def work(_):
        begun.wait(10)
        gate.wait(10)

    running = [jobs.start(name, "x", work) for name in "ab"]
    begun.wait(10)
    third = jobs.start("c", "x", lambda _: None)
    assert [job.state for job in (*running, third)] == ["running", "running", "waiting"]
    assert third.active
    gate.set()
    assert [finished(job).state for job in (*running, third)] == ["done"] * 3


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
        (10, 10, 20, "Detecting: 10 of 10 frames, about 0 s left"),
    ],
)
def test_progress_is_said_in_a_sentence(monkeypatch, done, total, elapsed_s, expected):
    monkeypatch.setattr(time, "monotonic", lambda: 1000.0)
    job = Job("Detecting", started_s=1000.0 - elapsed_s)
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
