"""Long work in the background: one job per key, however many sessions ask for it, one after the other."""

import atexit
import logging
import threading
import time
from collections.abc import Callable
from weakref import WeakSet

from corsmal.errors import CorsmalError
from corsmal.ui.folders import check_may_change
from corsmal.ui.job import Job, Priority

LOG = logging.getLogger(__name__)
"""Which jobs ran, how long, and how long they waited for others."""

TURN_S = 0.2
"""A job that waits for its turn looks this often whether it was asked to stop."""

FAREWELL_S = 4.0
"""How long a server that is stopped waits for its jobs to notice; it ends within five seconds."""


class Viewer:
    """One session, and the keys of the jobs whose results it shows, by the part of the page that shows them."""

    def __init__(self) -> None:
        self.shown: dict[str, str] = {}


class Jobs:
    """Runs jobs and remembers the last one of each key; they end with the process.

    One job at a time has the cores: the one of the highest priority, of several the one that was started first. One of
    a lower priority that is running waits after its step; the other one does not wait for that.
    An executor would keep a server that is stopped until all its work is done.
    """

    def __init__(self) -> None:
        self._jobs: dict[str, Job] = {}
        self._order: list[Job] = []
        self._viewers: WeakSet[Viewer] = WeakSet()
        self._changed = threading.Condition()
        atexit.register(self.stop)

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

    def start(
        self,
        key: str,
        label: str,
        work: Callable[[Job], None],
        *,
        priority: Priority = Priority.RUN,
        is_automatic: bool = False,
        is_for_guests: bool = False,
    ) -> Job:
        """Start work, or return the job that already does it.

        Args:
            key: names the work, the same in every session.
            label: what it does, for people.
            work: called with the job in another thread; it calls ``advance`` and heeds ``cancelled``.
            priority: whose turn it is.
            is_automatic: whether it ends when no session shows its results any more, see ``show``.
            is_for_guests: whether a read-only server does it, too: what a page cannot be seen without.

        Raises:
            RefusedError: the server is read-only.
        """
        if not is_for_guests:
            check_may_change()
        with self._changed:
            job = self._jobs.get(key)
            if job is not None and job.active:
                return job
            job = self._jobs[key] = Job(label, priority, is_automatic=is_automatic, _turn=self._wait_for_turn)
            self._order.append(job)
            self._changed.notify_all()
            threading.Thread(target=self._run, args=(job, work), name=f"corsmal-job {key}", daemon=True).start()
            return job

    def show(self, viewer: Viewer, part: str, key: str) -> None:
        """Say that a session shows the results of a job in a part of its page, and those of no other one there.

        A job that no session shows any more loses its priority; an automatic one is cancelled.
        """
        with self._changed:
            self._viewers.add(viewer)
            left, viewer.shown[part] = viewer.shown.get(part, ""), key
            shown = {each for other in self._viewers for each in other.shown.values()}
            job = self._jobs.get(left)
            if job is not None and job.active and left not in shown:
                job.is_left = True
                if job.is_automatic:
                    job.cancel()
            job = self._jobs.get(key)
            if job is not None and job.active and not job._cancel.is_set():
                job.is_left = False
            self._changed.notify_all()

    def _run(self, job: Job, work: Callable[[Job], None]) -> None:
        try:
            self._wait_for_turn(job)
            job.started_s, job._waited_s = time.monotonic(), 0.0
            if not job._cancel.is_set():
                work(job)
            job.state = "cancelled" if job._cancel.is_set() else "done"
        except CorsmalError as error:
            job.problem, job.state = str(error), "failed"
        except Exception as error:  # noqa: BLE001 - the thread would swallow it: the page must say that the job died
            job.problem, job.state = f"{job.label} stopped unexpectedly: {error!r}", "failed"
        finally:
            with self._changed:
                self._order.remove(job)
                self._changed.notify_all()
            LOG.info("%s: %s; had the cores for %.1f s, waited %.1f s", job.label, job.state, *job.times_s())

    def _wait_for_turn(self, job: Job) -> None:
        """Wait while another job goes first, unless this one is to stop."""
        with self._changed:
            if not job.active:
                return
            began_s = time.monotonic()
            while not job._cancel.is_set() and (ahead := self._ahead_of(job)):
                job.state, job.waits_for, job.place = "waiting", ahead[0].label, len(ahead)
                self._changed.wait(TURN_S)
            job.state, job.waits_for, job.place = "running", "", 0
            job.waited(time.monotonic() - began_s)

    def _ahead_of(self, job: Job) -> list[Job]:
        """The jobs that go before one, in their order."""
        queue = sorted(self._order, key=lambda each: each.rank)
        return queue[: queue.index(job)]

    def stop(self) -> None:
        """Cancel all jobs, and wait for those that are running, a few seconds at most."""
        jobs, deadline_s = list(self._jobs.values()), time.monotonic() + FAREWELL_S
        for job in jobs:
            job.cancel()
        while any(job.state == "running" for job in jobs) and time.monotonic() < deadline_s:
            time.sleep(0.05)
