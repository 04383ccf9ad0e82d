"""Background jobs on a page: how far one is, why it failed, and a button that stops it."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import streamlit as st

from corsmal.ui import shared
from corsmal.ui.folders import is_read_only
from corsmal.ui.job import Job, progress_text
from corsmal.ui.jobs import Viewer
from corsmal.ui.messages import plain

POLL_S = 0.5
VIEWER, NEXT_S = "viewer", "next_run_s"

RESTS = 8.0
"""A page that shows what a job has found rests that many times as long as its run took: the job needs the cores."""

REST_MIN_S = 4.0
"""And at least so long: the browser draws what the run sent, which takes longer than a short run."""

SOON_S = 3.0
"""A page does not show what a job has found by then that will end so soon: it would end later for it."""


@contextmanager
def timed() -> Iterator[None]:
    """Measure how long a run of a page takes, and when the next may begin."""
    began_s = time.monotonic()
    try:
        yield
    finally:
        ended_s = time.monotonic()
        st.session_state[NEXT_S] = ended_s + max(REST_MIN_S, RESTS * (ended_s - began_s))


def is_due(job: Job | None, shown: int, *, next_s: float) -> bool:
    """Whether the page that shows a job's first ``shown`` results is run again.

    When it ends; and from ``next_s`` on for more results, unless it will end within ``SOON_S`` anyway.
    """
    if job is None or not job.active:
        return True
    left_s = job.seconds_left
    return job.results != shown and time.monotonic() >= next_s and (left_s is None or left_s > SOON_S)


def shows(part: str, key: str) -> bool:
    """Say that this session shows the results of a job in a part of its pages, see ``Jobs.show``.

    Returns:
        Whether it showed others there before.
    """
    viewer = st.session_state.setdefault(VIEWER, Viewer())
    is_other = viewer.shown.get(part, key) != key
    shared.jobs().show(viewer, part, key)
    return is_other


def follow(
    key: str, *, unit: str = "recordings", is_narrow: bool = False, show: Callable[[], None] | None = None
) -> bool:
    """Show how far the job of a key is, or why it failed.

    Args:
        key: of the job.
        unit: what its steps are.
        is_narrow: whether the button that stops it stands below, as in the sidebar.
        show: draws what the job has found by now, again and again while it is running, instead of the whole page.

    Returns:
        Whether it is running; the page is run again when it ends, and from time to time when it has kept more results.
    """
    job = shared.jobs().get(key)
    if job is not None and job.active:
        _watch(key, unit, job.results, is_narrow=is_narrow, show=show)
        return True
    if job is not None and job.state == "failed":
        say, icon = (st.warning, "warning") if job.is_automatic else (st.error, "error")
        say(plain(job.problem), icon=f":material/{icon}:")
    return False


@st.fragment(run_every=POLL_S)
def _watch(key: str, unit: str, shown: int, *, is_narrow: bool, show: Callable[[], None] | None) -> None:
    job = shared.jobs().get(key)
    shown = shown if job is None or show is None else job.results
    if job is None or is_due(job, shown, next_s=st.session_state.get(NEXT_S, 0.0)):
        st.rerun()
    left, right = (st, st) if is_narrow else st.columns([5, 1], vertical_alignment="bottom")
    left.progress(job.fraction, text=progress_text(job, unit))
    right.button(
        "Stop",
        key=f"stop {key}",
        on_click=job.cancel,
        disabled=is_read_only(),
        help="What was done is kept.",
        icon=":material/stop:",
        width="stretch",
    )
    if job.detail:
        st.caption(plain(job.detail))
    if show is not None:
        show()
