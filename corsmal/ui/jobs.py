"""Long work in the background: one job per key, however many sessions ask for it."""

import atexit
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from corsmal.errors import CorsmalError
from corsmal.quantities import duration_text

WORKERS = 2
"""The demo is made beside a detection, not before it."""

FAREWELL_S = 5.0
"""How long a server that is stopped waits for its jobs to notice."""


@dataclass
class Job:
    """One piece of background work, watched by any number of sessions.

    Args:
        label: what it does, for people.
        done: how many steps are done.
        total: how many there are; 0 while unknown.
        state: ``waiting``, ``running``, ``done``, ``cancelled`` or ``failed``.
        problem: why it failed, one sentence.
        results: how many times the work has kept more results.
    """

    label: str
    done: int = 0
    total: int = 0
    state: str = "waiting"
    problem: str = ""
    results: int = 0
    started_s: float = field(default_factory=time.monotonic)
    _has_forecast: bool = False
    _end_s: float | None = None
    _cancel: threading.Event = field(default_factory=threading.Event)

    def advance(self, done: int, total: int) -> None:
        """Say how far the work is."""
        self.done, self.total = done, total

    def forecast(self, left_s: float | None) -> None:
        """Say how long the rest will take, or that it is not known yet, where the pace since the start misleads."""
        self._has_forecast, self._end_s = True, None if left_s is None else time.monotonic() + left_s

    def keep(self) -> None:
        """Say that there are more results to show."""
        self.results += 1

    def cancel(self) -> None:
        """Ask the work to stop; what was done is kept."""
        self._cancel.set()

    def cancelled(self) -> bool:
        """Whether somebody asked the work to stop."""
        return self._cancel.is_set()

    @property
    def active(self) -> bool:
        """Whether the work still waits or runs."""
        return self.state in ("waiting", "running")

    @property
    def fraction(self) -> float:
        """Done of total, 0..1."""
        return self.done / self.total if self.total else 0.0

    @property
    def seconds_left(self) -> float | None:
        """As the work forecasts, else at the rate so far; None where neither is known yet."""
        if self._has_forecast:
            return None if self._end_s is None else max(0.0, self._end_s - time.monotonic())
        if not self.done or not self.total:
            return None
        return (time.monotonic() - self.started_s) / self.done * (self.total - self.done)


def progress_text(job: Job, unit: str) -> str:
    """What a job does, how far it is and how long it will take."""
    if not job.total:
        return f"{job.label} …"
    left_s = job.seconds_left
    time_left = "" if left_s is None else f", about {duration_text(left_s)} left"
    done = f"{100 * job.fraction:.0f} %" if unit == "%" else f"{job.done} of {job.total} {unit}"
    return f"{job.label}: {done}{time_left}"


class Jobs:
    """Runs jobs, two at a time, and remembers the last one of each key; they end with the process.

    An executor would keep a server that is stopped until all its work is done.
    """

    def __init__(self) -> None:
        self._free = threading.Semaphore(WORKERS)
        self._jobs: dict[str, Job] = {}
        self._lock = threading.Lock()
        atexit.register(self._stop)

    def get(self, key: str) -> Job | None:
        """The last job of a key."""
        return self._jobs.get(key)

    def state(self, key: str) -> str:
        """The state of the last job of a key; empty where there was none."""
        job = self.get(key)
        return "" if job is None else job.state

    def is_active(self, key: str) -> bool:
        """Whether a job of a key waits or runs."""
        job = self.get(key)
        return job is not None and job.active

    def start(self, key: str, label: str, work: Callable[[Job], None]) -> Job:
        """Start work, or return the job that already does it.

        Args:
            key: names the work, the same in every session.
            label: what it does, for people.
            work: called with the job in another thread; it calls ``advance`` and heeds ``cancelled``.
        """
        with self._lock:
            job = self._jobs.get(key)
            if job is not None and job.active:
                return job
            job = self._jobs[key] = Job(label)
            threading.Thread(target=self._run, args=(job, work), name=f"corsmal-job {key}", daemon=True).start()
            return job

    def _run(self, job: Job, work: Callable[[Job], None]) -> None:
        with self._free:
            job.state, job.started_s = "running", time.monotonic()
            try:
                work(job)
                job.state = "cancelled" if job.cancelled() else "done"
            except CorsmalError as error:
                job.problem, job.state = str(error), "failed"
            except Exception as error:  # noqa: BLE001 - the thread would swallow it: the page must say that the job died
                job.problem, job.state = f"{job.label} stopped unexpectedly: {error!r}", "failed"

    def _stop(self) -> None:
        jobs, deadline_s = list(self._jobs.values()), time.monotonic() + FAREWELL_S
        for job in jobs:
            job.cancel()
        while any(job.state == "running" for job in jobs) and time.monotonic() < deadline_s:
            time.sleep(0.05)
