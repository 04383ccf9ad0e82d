"""Detecting in a recording: choose a detector, start it, watch it."""

from contextlib import suppress

import streamlit as st

from corsmal.dataset import Recording
from corsmal.detection import Detector
from corsmal.errors import CorsmalError
from corsmal.parameters import METHOD_VIEWS
from corsmal.stages.detections import DetectionSet, detect_recording
from corsmal.stages.settings import SEARCH_STEP
from corsmal.store import Store
from corsmal.ui import session, shared
from corsmal.ui.jobs import Job, progress_text
from corsmal.ui.messages import plain
from corsmal.ui.opened import OpenedRecording
from corsmal.weights import find_weights

DETECTORS = {"coco": "Mask R-CNN, COCO weights", "demo": "small Mask R-CNN of the demo"}


def open_detected() -> OpenedRecording:
    """The chosen recording, under what there is to say and to do about its detections."""
    opened = OpenedRecording(session.opened()[1])
    _notes(opened.detections)
    detection_control(opened)
    session.keep_frame_within(opened.frames)
    return opened


def _notes(found: DetectionSet) -> None:
    """Where the detections come from, and what is wrong with them."""
    sources = sorted({view.source for view in found.views.values()})
    if sources:
        st.caption(f":material/center_focus_strong: Detections: {plain('; '.join(sources))}")
    for note in found.notes:
        st.warning(plain(note), icon=":material/warning:")


def is_detecting(opened: OpenedRecording) -> bool:
    """Whether a job detects in the recording."""
    job = shared.jobs().get(opened.job_key)
    return job is not None and job.active


def detection_control(opened: OpenedRecording) -> None:
    """Offer to detect where frames have not been inspected yet, or show how far the job is."""
    recording, found, key = opened.recording, opened.detections, opened.job_key
    job = shared.jobs().get(key)
    if job is not None and job.active:
        _watch(key)
        return
    if job is not None and job.state == "failed":
        st.error(plain(job.problem), icon=":material/error:")
    if opened.has_more_detections:  # the job ended while the page was being drawn
        st.rerun()
    open_views = _uninspected(opened)
    if not open_views:
        return
    if any(name not in found.views for name in open_views):
        st.info(
            f"No detections yet in {', '.join(open_views)}. Run a detector, or put COCO results in "
            f"`{open_views[0]}/detections/{recording.id}.json`.",
            icon=":material/search:",
        )
    left, middle, right = st.columns([2, 1, 1], vertical_alignment="bottom")
    detector = left.selectbox(
        "Detector",
        list(DETECTORS),
        index=list(DETECTORS).index("demo" if recording.is_synthetic else "coco"),
        key="detector",
        format_func=DETECTORS.__getitem__,
    )
    searches = middle.button(
        "Find the best frame",
        type="primary",
        icon=":material/search:",
        help=f"Every {SEARCH_STEP}th frame, then from coarse to fine around the best.",
        width="stretch",
    )
    inspects_all = right.button("Inspect all frames", icon=":material/select_all:", width="stretch")
    if searches or inspects_all:
        every = 1 if inspects_all else SEARCH_STEP
        store = shared.store()
        shared.jobs().start(key, "Detecting containers", lambda job: _detect(job, recording, detector, every, store))
        st.rerun()


def open_detector(name: str) -> Detector:
    """One of ``DETECTORS``. Loads PyTorch; for a job, not for a page.

    Raises:
        FileError: its weights are absent or broken.
    """
    from corsmal.detection import MaskRCNNDetector, SmallDetector  # noqa: PLC0415 - PyTorch takes seconds to import

    return SmallDetector(find_weights("detector").path) if name == "demo" else MaskRCNNDetector()


def _uninspected(opened: OpenedRecording) -> list[str]:
    """Views of the method with frames that a detector could still inspect; a view with a file of its own is done."""
    names = []
    for name in METHOD_VIEWS:
        view = opened.recording.views.get(name)
        if view is not None and view.detections_path is None:
            with suppress(CorsmalError):
                if len(opened.detections.views.get(name, ())) < opened.video(name).frame_count:
                    names.append(name)
    return names


@st.fragment(run_every=0.5)
def _watch(key: str) -> None:
    job = shared.jobs().get(key)
    shown = st.session_state.get(f"{key} shown", 0)
    if job is None or not job.active or job.results != shown:
        st.session_state[f"{key} shown"] = 0 if job is None or not job.active else job.results
        st.rerun()
    st.progress(job.fraction, text=progress_text(job, "frames"))
    st.button("Stop", on_click=job.cancel, help="What was done is kept.", icon=":material/stop:")


def _detect(job: Job, recording: Recording, name: str, every: int, store: Store) -> None:
    detect_recording(
        recording,
        open_detector(name),
        store=store,
        every=every,
        progress=job.advance,
        kept=job.keep,
        cancelled=job.cancelled,
    )
