"""Background jobs on a page: how far one is, why it failed, and a button that stops it."""

import streamlit as st

from corsmal.ui import shared
from corsmal.ui.jobs import progress_text
from corsmal.ui.messages import plain

POLL_S = 0.5


def follow(key: str, *, unit: str = "recordings", is_narrow: bool = False) -> bool:
    """Show how far the job of a key is, or why it failed.

    Args:
        key: of the job.
        unit: what its steps are.
        is_narrow: whether the button that stops it stands below, as in the sidebar.

    Returns:
        Whether it is running; the page is run again when it ends, and when it has kept more results.
    """
    job = shared.jobs().get(key)
    if job is not None and job.active:
        _watch(key, unit, job.results, is_narrow=is_narrow)
        return True
    if job is not None and job.state == "failed":
        st.error(plain(job.problem), icon=":material/error:")
    return False


@st.fragment(run_every=POLL_S)
def _watch(key: str, unit: str, shown: int, *, is_narrow: bool) -> None:
    job = shared.jobs().get(key)
    if job is None or not job.active or job.results != shown:
        st.rerun()
    left, right = (st, st) if is_narrow else st.columns([5, 1], vertical_alignment="bottom")
    left.progress(job.fraction, text=progress_text(job, unit))
    right.button(
        "Stop",
        key=f"stop {key}",
        on_click=job.cancel,
        help="What was done is kept.",
        icon=":material/stop:",
        width="stretch",
    )
