"""What was known when: computed in the background, drawn as it is found."""

from collections.abc import Callable, Sequence

import streamlit as st

from corsmal.errors import CorsmalError
from corsmal.estimation import Estimate
from corsmal.figures.known_when import known_when_figure
from corsmal.figures.sound import SoundPicture
from corsmal.stages.estimates import Predictors
from corsmal.stages.moments import Moment, coarse_to_fine, known_since_s, known_when
from corsmal.store import Store
from corsmal.ui import session, shared
from corsmal.ui.estimating import times_s
from corsmal.ui.filling import sound
from corsmal.ui.following import follow, shows
from corsmal.ui.job import Job, Priority
from corsmal.ui.linked_plot import linked_plot
from corsmal.ui.opened import OpenedRecording

PART = "known when"
"""Of the page, as ``following.shows`` has it."""

ANSWERS = {
    "filling_type": "type",
    "filling_level": "level",
    "capacity_ml": "capacity (within 10 %)",
    "container_mass_g": "container mass (within 10 %)",
}


def begin(opened: OpenedRecording, networks: Predictors) -> Job | None:
    """Compute in the background what the store lacks; what this session showed before is stopped.

    Returns:
        The job, where one is needed; one that failed or was stopped does not begin again by itself.
    """
    key = _key(opened, networks)
    shows(PART, key)
    if len(moments(opened, networks)) == len(times_s(opened)):
        return None
    job = shared.jobs().get(key)
    is_new = job is None or (job.is_left and job.state == "cancelled")
    return _start(opened, networks) if is_new else job


def _start(opened: OpenedRecording, networks: Predictors) -> Job:
    work = _work(opened, networks, times_s(opened), shared.store())
    key = _key(opened, networks)
    return shared.jobs().start(
        key, "What was known when", work, priority=Priority.NOW, is_automatic=True, is_for_guests=True
    )


def _restart(opened: OpenedRecording, networks: Predictors) -> None:
    _start(opened, networks)


def _key(opened: OpenedRecording, networks: Predictors) -> str:
    return f"known when {opened.key} {opened.detections.key} {networks.key}"


def _work(opened: OpenedRecording, networks: Predictors, times: Sequence[float], store: Store) -> Callable[[Job], None]:
    """The work of the job, which calls nothing of Streamlit."""
    recording, detections, order = opened.recording, opened.detections, coarse_to_fine(times)

    def compute(job: Job) -> None:
        job.advance(0, len(order))
        for done, _ in enumerate(known_when(recording, detections, networks, order, store=store), 1):
            job.advance(done, len(order))
            if job.cancelled():
                return

    return compute


def moments(opened: OpenedRecording, networks: Predictors) -> list[Moment]:
    """What the store has by now, ascending in time."""
    kept = known_when(
        opened.recording, opened.detections, networks, times_s(opened), store=shared.store(), only_kept=True
    )
    return list(kept)


def panel(opened: OpenedRecording, networks: Predictors, found: Estimate, job: Job | None) -> None:
    """The curves, drawn again while a job computes them."""

    def draw() -> None:
        known = moments(opened, networks)
        if known:
            _curves(opened, found, known)

    if job is not None and follow(_key(opened, networks), unit="times", show=draw):
        return
    if job is not None and job.state == "cancelled":
        st.button("Compute the rest", icon=":material/play_arrow:", on_click=_restart, args=(opened, networks))
    draw()


def _curves(opened: OpenedRecording, found: Estimate, known: Sequence[Moment]) -> None:
    figure = known_when_figure.parts(
        known,
        end_s=times_s(opened)[-1],
        picture=_picture(opened),
        annotation=opened.recording.annotation,
        best=_best(opened, found),
        preset=session.choice().estimate_preset,
    )
    linked_plot(
        figure,
        key="overview_known_when",
        label=f"What was known when, recording {opened.id}",
        height_px=figure["layout"]["height"],
        frame_on_x=opened.seconds_per_frame,
        revision=opened.id,
    )
    since = [f"{ANSWERS[name]} from {moment_s:.1f} s" for name, moment_s in known_since_s(known).items()]
    st.caption(
        "At each time: the estimate had the recording ended then, from the inspected frames and the sound until then."
        + (f" Answers that do not change any more: {', '.join(since)}." if since else "")
    )


def _picture(opened: OpenedRecording) -> SoundPicture | None:
    try:
        return sound.picture(opened, session.choice().channel)
    except CorsmalError:  # its place in the figure is left out; the Sound part says why
        return None


def _best(opened: OpenedRecording, found: Estimate) -> tuple[float, str] | None:
    """The moment of the fitted frame, and its name."""
    if found.fit is None or found.fit.frame is None or not opened.fps:
        return None
    return found.fit.frame / opened.fps, f"frame {found.fit.frame}"
