from types import SimpleNamespace

import pytest

from corsmal.ui import following
from corsmal.ui.following import is_due
from corsmal.ui.job import Job


def test_a_page_is_run_again_when_its_job_ends_and_meanwhile_only_for_more_results_after_a_rest():
    job = Job("Detecting", results=3)
    cases = {
        "nothing new": is_due(job, 3, next_s=0.0),
        "more, but the page has just run": is_due(job, 2, next_s=1e12),
        "more, and it has rested": is_due(job, 2, next_s=0.0),
    }
    job.state = "done"
    cases["ended"] = is_due(job, 3, next_s=1e12)
    assert cases == {
        "nothing new": False,
        "more, but the page has just run": False,
        "more, and it has rested": True,
        "ended": True,
    }
    assert is_due(None, 0, next_s=1e12)


def test_a_page_waits_for_the_end_of_a_job_that_ends_soon():
    job = Job("Detecting", results=1, state="running")
    job.forecast(20.0)
    assert is_due(job, 0, next_s=0.0)
    job.forecast(1.0)
    assert not is_due(job, 0, next_s=0.0)
    job.forecast(None)
    assert is_due(job, 0, next_s=0.0)


def test_a_page_rests_for_seconds_after_a_short_run_and_longer_after_a_long_one(monkeypatch):
    state, clock = {}, [100.0]
    monkeypatch.setattr(following, "st", SimpleNamespace(session_state=state))
    monkeypatch.setattr(following.time, "monotonic", lambda: clock[0])
    for took_s, rest_s in ((0.1, 4.0), (2.0, 16.0)):
        with following.timed():
            clock[0] += took_s
        assert state[following.NEXT_S] - clock[0] == pytest.approx(rest_s)
