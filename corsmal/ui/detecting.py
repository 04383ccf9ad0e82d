"""Detecting in a recording: choose a detector, start it, watch it."""

from contextlib import suppress

import streamlit as st

from corsmal.errors import CorsmalError
from corsmal.parameters import METHOD_VIEWS
from corsmal.stages.detections import DetectionSet, detect_recording
from corsmal.stages.settings import SEARCH_STEP, Method, find_detector
from corsmal.ui import session, shared
from corsmal.ui.following import follow
from corsmal.ui.jobs import Job
from corsmal.ui.messages import plain
from corsmal.ui.opened import OpenedRecording

DETECTORS: dict[Method, str] = {"coco": "Mask R-CNN, COCO weights", "demo": "small Mask R-CNN of the demo"}


def open_detected() -> OpenedRecording:
    """The chosen recording, under what there is to say and to do about its detections."""
    opened = OpenedRecording(session.opened()[1])
    is_running = follow(opened.job_key, unit="frames")  # first: what it keeps from here on makes the page run again
    _notes(opened.detections)
    if not is_running:
        _offer(opened)
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
    return shared.jobs().is_active(opened.job_key)


def detection_control(opened: OpenedRecording) -> None:
    """Offer to detect where frames have not been inspected yet, or show how far the job is."""
    if not follow(opened.job_key, unit="frames"):
        _offer(opened)


def _offer(opened: OpenedRecording) -> None:
    """Offer to detect where frames have not been inspected yet."""
    recording, found = opened.recording, opened.detections
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
    with left:
        detector = detector_control(is_synthetic=recording.is_synthetic, key="detector")
    searches = middle.button(
        "Find the best frame",
        type="primary",
        icon=":material/search:",
        help=f"Every {SEARCH_STEP}th frame, then from coarse to fine around the best.",
        width="stretch",
    )
    inspects_all = right.button("Inspect all frames", icon=":material/select_all:", width="stretch")
    if searches or inspects_all:
        store, settings = shared.store(), find_detector(detector, every=1 if inspects_all else SEARCH_STEP)

        def work(job: Job) -> None:
            detect_recording(
                recording,
                settings.open(),
                store=store,
                every=settings.every,
                progress=job.advance,
                kept=job.keep,
                cancelled=job.cancelled,
            )

        shared.jobs().start(opened.job_key, "Detecting containers", work)
        st.rerun()


def detector_control(*, is_synthetic: bool, key: str) -> Method:
    """Choose one of ``DETECTORS``; at first the one for such recordings."""
    names = list(DETECTORS)
    first = names.index("demo" if is_synthetic else "coco")
    return st.selectbox("Detector", names, first, format_func=DETECTORS.__getitem__, key=key)


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
