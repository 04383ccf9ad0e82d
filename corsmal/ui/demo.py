"""The built-in demo: made in the background on the first start, and shown while no other folder is named."""

from pathlib import Path

import streamlit as st

from corsmal.engines.processes import Processes
from corsmal.synthetic import DemoProgress, write_demo
from corsmal.ui import shared
from corsmal.ui.folders import demo_folder, is_demo_ready
from corsmal.ui.jobs import Job, progress_text
from corsmal.ui.messages import plain

KEY = "demo"
STEPS = 100
FIRST_POLL_S, POLL_S = 0.5, 2.0
"""Between two looks at the job: until there is something to show, and then."""


def is_coming() -> bool:
    """Whether the demo's first recording is being made."""
    job = shared.jobs().get(KEY)
    return job is not None and job.active and not is_demo_ready()


def begin(processes: Processes | None = None) -> None:
    """Begin to make the demo, in processes that were started ahead where there are any."""
    folder = demo_folder()
    shared.jobs().start(KEY, "Making the demo", lambda job: _work(job, folder, processes))


def make_demo() -> None:
    """Make the demo, or finish one that was stopped half-way; show how far it is, and say that it is synthetic."""
    st.info("The built-in demo: **synthetic** people, containers and sounds.", icon=":material/science:")
    job = shared.jobs().get(KEY)
    if job is None or (job.state == "done" and not is_demo_ready()):  # the latter after somebody deleted it
        begin()
    job = shared.jobs().get(KEY)
    if job is None or job.active:
        st.fragment(_watch, run_every=POLL_S if is_demo_ready() else FIRST_POLL_S)()
    elif job.state == "failed":
        st.error(plain(job.problem), icon=":material/error:")
        st.button("Try again", on_click=begin)


def _watch() -> None:
    """Follow the job; the app is run again when it ends, and when there are more recordings to show."""
    job = shared.jobs().get(KEY)
    shown = st.session_state.setdefault("demo_shown", job.results if job else 0)
    if job is None or not job.active or (job.results and not shown):
        st.session_state["demo_shown"] = job.results if job else 0
        st.rerun()
    st.progress(job.fraction, text=progress_text(job, "%"))


def _work(job: Job, folder: Path, processes: Processes | None) -> None:
    def report(progress: DemoProgress) -> None:
        job.label = f"Making the demo, {progress.done} of {progress.total} recordings"
        job.advance(round(STEPS * progress.fraction), STEPS)
        job.results = progress.done

    try:
        write_demo(folder, progress=report, cancelled=job.cancelled, processes=processes)
    finally:
        if processes is not None:
            processes.stop()
