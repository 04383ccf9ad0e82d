"""One piece of long work in the background: how far it is, how long it will take, and whether it is to stop."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum

from corsmal.quantities import duration_text


class Priority(IntEnum):
    """Whose turn it is: what takes seconds, what an open page waits for, runs, the demo."""

    NOW = 0
    SHOWN = 1
    RUN = 2
    DEMO = 3


@dataclass(eq=False)
class Job:
    """One piece of background work, watched by any number of sessions.

    Args:
        label: what it does, for people.
        priority: jobs of a higher one (a lower number) go first.
        is_automatic: nobody asked for it: it ends when no session shows its results any more.
        done: how many steps are done.
        total: how many there are; 0 while unknown.
        part: how much is done of the step that is being done, 0 to 1.
        state: ``waiting``, ``running``, ``done``, ``cancelled`` or ``failed``.
        problem: why it failed, one sentence.
        results: how many times the work has kept more results.
        waits_for: the label of the job that goes first; empty where there is none.
        place: in the queue, 1 for the next; 0 where it does not wait.
        is_left: no session shows its results any more.
        is_at_most: whether the time left will rather be shorter than it is said to be.
        detail: what each stage of the work has done, one sentence; empty where there is one stage.
    """

    label: str
    priority: Priority = Priority.RUN
    is_automatic: bool = False
    done: int = 0
    total: int = 0
    part: float = 0.0
    state: str = "waiting"
    problem: str = ""
    results: int = 0
    waits_for: str = ""
    place: int = 0
    is_left: bool = False
    detail: str = ""
    is_at_most: bool = False
    started_s: float = field(default_factory=time.monotonic)
    _asked_s: float = field(default_factory=time.monotonic)
    _waited_s: float = 0.0
    _idle_s: float = 0.0
    _began: tuple[int, float] | None = None
    _has_forecast: bool = False
    _end_s: float | None = None
    _cancel: threading.Event = field(default_factory=threading.Event)
    _turn: Callable[["Job"], None] = lambda _job: None

    def advance(self, done: int, total: int) -> None:
        """Say how far the work is. The pace counts from the first call on, not from while networks were loaded."""
        if not self.total:
            self._began = done, time.monotonic()
            self._waited_s = 0.0
        self.done, self.total = done, total

    def forecast(self, left_s: float | None, *, is_at_most: bool = False) -> None:
        """Say how long the rest will take, or that it is not known yet, where the pace since the start misleads."""
        self.is_at_most = is_at_most
        self._has_forecast, self._end_s = True, None if left_s is None else time.monotonic() + left_s

    def keep(self) -> None:
        """Say that there are more results to show."""
        self.results += 1

    def cancel(self) -> None:
        """Ask the work to stop; what was done is kept."""
        self._cancel.set()

    def cancelled(self) -> bool:
        """Whether the work is to stop. It asks between its steps, and waits here while another job goes first."""
        self._turn(self)
        return self._cancel.is_set()

    @property
    def active(self) -> bool:
        """Whether the work still waits or runs."""
        return self.state in ("waiting", "running")

    @property
    def rank(self) -> Priority:
        """The priority, which a job loses that no session shows any more; one that ends keeps it to free the cores."""
        return max(self.priority, Priority.RUN) if self.is_left and not self._cancel.is_set() else self.priority

    @property
    def fraction(self) -> float:
        """Done of total, 0..1."""
        return min(1.0, (self.done + self.part) / self.total) if self.total else 0.0

    @property
    def seconds_left(self) -> float | None:
        """As the work forecasts, else at the rate so far; None where neither is known yet."""
        if self._has_forecast:
            return None if self._end_s is None else max(0.0, self._end_s - time.monotonic())
        first, began_s = self._began or (0, self.started_s)
        if self.done <= first:
            return None
        return (time.monotonic() - began_s - self._waited_s) / (self.done - first) * (self.total - self.done)

    def worked_s(self) -> float:
        """A clock that stands still while other jobs go first."""
        return time.monotonic() - self._idle_s

    def times_s(self) -> tuple[float, float]:
        """For how long it had its turn, and for how long others had it, since it was asked for."""
        return time.monotonic() - self._asked_s - self._idle_s, self._idle_s

    def waited(self, seconds: float) -> None:
        """Leave out of the pace and the forecast what was spent waiting for others."""
        self._waited_s, self._idle_s = self._waited_s + seconds, self._idle_s + seconds
        self._end_s = None if self._end_s is None else self._end_s + seconds


def progress_text(job: Job, unit: str) -> str:
    """What a job does, how far it is and how long it will take."""
    if job.waits_for:
        return f"{job.label}: place {job.place} in the queue, waits for “{job.waits_for}”"
    if not job.total:
        return f"{job.label} …"
    left_s, time_left = job.seconds_left, ""
    if left_s is not None and job.done < job.total:
        how = "at most" if job.is_at_most else "about"
        time_left = f", {how} {duration_text(left_s)} left" if left_s else ", taking longer than expected"
    done = f"{100 * job.fraction:.0f} %" if unit == "%" else f"{job.done} of {job.total} {unit}"
    return f"{job.label}: {done}{time_left}"
