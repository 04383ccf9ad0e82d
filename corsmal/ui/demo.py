"""The built-in demo in the sidebar: what it is, and making its full version in the background."""

import streamlit as st

from corsmal import synthetic  # the renderer is loaded when the demo is made
from corsmal.synthetic import ANNOTATION_FILE
from corsmal.ui import shared
from corsmal.ui.folders import demo_folder, full_demo_folder, is_read_only
from corsmal.ui.following import follow
from corsmal.ui.job import Job, Priority

KEY = "demo"
STEPS = 100
WORKERS = 1
"""While somebody uses the app, the other cores are theirs."""

MAKE = "Make all thirty recordings"


def show_demo(folder: str, folder_key: str) -> None:
    """Say that the demo is synthetic; make its full version on request, and switch between the two.

    Args:
        folder: the one that is shown.
        folder_key: where the session keeps it.
    """
    st.info("The built-in demo: **synthetic** people, containers and sounds.", icon=":material/science:")
    is_made = (full_demo_folder() / ANNOTATION_FILE).is_file()
    is_shown = folder == str(full_demo_folder())
    is_running, state = follow(KEY, unit="%", is_narrow=True), shared.jobs().state(KEY)
    if (
        not is_running and not is_read_only() and (state != "done" or not is_made)
    ):  # the latter after somebody deleted it
        st.button(
            MAKE,
            on_click=begin,
            icon=":material/movie:",
            width="stretch",
            help="Fifteen containers, twice each, without detections and runs, made in the background in minutes. "
            "That can be stopped and resumed.",
        )
    if is_made or is_shown:
        other = demo_folder() if is_shown else full_demo_folder()
        st.button(
            "Open the ready-made six" if is_shown else "Open the full demo",
            on_click=lambda: st.session_state.update({folder_key: str(other)}),
            icon=":material/science:",
            width="stretch",
        )


def begin() -> None:
    """Begin to make the full demo, or resume."""
    folder = full_demo_folder()

    def work(job: Job) -> None:
        def report(progress: synthetic.DemoProgress) -> None:
            job.label = f"Making the demo, {progress.done} of {progress.total} recordings"
            job.advance(round(STEPS * progress.fraction), STEPS)
            job.forecast(progress.left_s)
            job.results = min(progress.done, 1)  # the first recording makes the page run again

        synthetic.write_demo(folder, progress=report, cancelled=job.cancelled, workers=WORKERS)

    shared.jobs().start(KEY, "Making the demo", work, priority=Priority.DEMO)
