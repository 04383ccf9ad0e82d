import threading

from corsmal.errors import FileError
from corsmal.ui.jobs import Job, Jobs


def finished(jobs: Jobs, job: Job) -> Job:
    """Wait for a job by starting another one behind it: the jobs run one after the other."""
    gate = threading.Event()
    jobs.start("gate", "gate", lambda _: gate.set())
    assert gate.wait(10)
    return job


def test_work_runs_and_says_how_far_it_is():
    jobs = Jobs()
    job = jobs.start("a", "Counting", lambda job: job.advance(3, 4))
    finished(jobs, job)
    assert (job.state, job.done, job.total) == ("done", 3, 4)
    assert job.seconds_left is not None
    assert Job("new").seconds_left is None


def test_the_same_work_asked_for_twice_is_one_job():
    jobs, gate, runs = Jobs(), threading.Event(), []

    def work(job):
        runs.append(job)
        gate.wait(10)

    first, second = jobs.start("a", "x", work), jobs.start("a", "x", work)
    assert first is second
    assert first.active
    gate.set()
    finished(jobs, first)
    assert len(runs) == 1
    assert jobs.start("a", "x", work) is not first


def test_cancelled_work_says_so():
    jobs, gate = Jobs(), threading.Event()
    job = jobs.start("a", "x", lambda _: gate.wait(10))
    job.cancel()
    gate.set()
    assert finished(jobs, job).state == "cancelled"
    assert job.cancelled()


def test_work_that_fails_leaves_a_sentence_and_the_next_one_runs():
    def expected(_):
        raise FileError("weights.pth", "is not there")

    def unexpected(_):
        raise ZeroDivisionError("x")

    jobs = Jobs()
    first, second = jobs.start("a", "Detecting", expected), jobs.start("b", "Detecting", unexpected)
    finished(jobs, second)
    assert (first.state, first.problem) == ("failed", "weights.pth: is not there")
    assert second.state == "failed"
    assert "Detecting stopped unexpectedly" in second.problem
