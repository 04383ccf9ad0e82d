"""Detecting in the recording that is shown: by itself where that is quick, else on request; watched on every page."""

from collections.abc import Sequence
from contextlib import suppress
from math import ceil

import streamlit as st

from corsmal.dataset import Recording
from corsmal.detection.coco_weights import coco_weights_file
from corsmal.errors import CorsmalError
from corsmal.notes import Note
from corsmal.parameters import METHOD_VIEWS
from corsmal.quantities import duration_text
from corsmal.stages.by_hand import FLAG as BY_HAND
from corsmal.stages.search import detect_recording, search_frames
from corsmal.stages.settings import SEARCH_STEP, DetectorSettings, Method, find_detector
from corsmal.ui import session, shared
from corsmal.ui.folders import READ_ONLY, is_read_only
from corsmal.ui.following import follow, shows
from corsmal.ui.job import Job, Priority
from corsmal.ui.messages import plain
from corsmal.ui.opened import OpenedRecording

DETECTORS: dict[Method, str] = {"coco": "Mask R-CNN, COCO weights", "demo": "small Mask R-CNN of the demo (synthetic)"}
SMALL = "small Mask R-CNN"
"""How the name of the demo's detector begins, which stands with its detections."""

BY_ITSELF_S = 30.0
"""A search that takes longer waits for somebody who asks for it."""


def open_detected() -> OpenedRecording:
    """The chosen recording, under what there is to say and to do about its detections."""
    opened = OpenedRecording(session.opened()[1], session.choice().selected_by)
    is_running = watch_detection(opened)  # first: what it keeps from here on makes the page run again
    _notes(opened)
    if not is_running:
        _offer(opened)
    session.keep_frame_within(opened.frames)
    return opened


def watch_detection(opened: OpenedRecording) -> bool:
    """Detect in the recording by itself if it is one that nobody inspected, and show how far a detector is.

    Returns:
        Whether one is running; the page is run again when more was found.
    """
    if shows("detections", opened.job_key):
        shows("known when", "")
    _begin_by_itself(opened)
    is_inspecting = follow(opened.frame_job_key, unit="frames")
    return follow(opened.job_key, unit="frames") or is_inspecting


def detection_control(opened: OpenedRecording) -> None:
    """The same, and offer a search where there was none."""
    if not watch_detection(opened) and not _is_searched(opened):
        _offer(opened)


def is_detecting(opened: OpenedRecording) -> bool:
    """Whether a job searches the recording."""
    return shared.jobs().is_active(opened.job_key)


def automatic_detector(recording: Recording) -> DetectorSettings | None:
    """The detector that begins by itself: the demo's in synthetic recordings, in others Mask R-CNN with COCO weights.

    None where its weights are not there: a network that was trained on synthetic people is not used on real ones
    unless it is chosen by name.
    """
    if recording.is_synthetic:
        settings = find_detector("demo")
        return settings if settings.weights is not None and settings.weights.is_file() else None
    return find_detector("coco") if coco_weights_file().is_file() else None


def can_inspect_frame(opened: OpenedRecording, frame: int) -> bool:
    """Whether a frame of some view could be inspected and was not."""
    views, clock = opened.detections.views, opened.recording.clock()
    return any(
        frame < count and frame not in views.get(name, ()) and clock.own(name, frame) is not None
        for name, count in open_views(opened).items()
    )


def inspect_frame(opened: OpenedRecording, frame: int) -> Job:
    """Inspect one frame of all views in the background, with the detector that the recording's detections are from.

    ``watch_detection`` shows how far it is. While another frame is being inspected, this is the job that does that.
    """
    sources = [view.source for name, view in opened.detections.views.items() if name in open_views(opened)]
    automatic = automatic_detector(opened.recording)
    if sources or automatic is None:
        settings = find_detector("demo" if any(source.startswith(SMALL) for source in sources) else "coco")
    else:
        settings = automatic
    return _start(opened, settings, frames=[frame])


def detector_control(*, is_synthetic: bool, key: str) -> Method:
    """Choose one of ``DETECTORS``; at first the one for such recordings."""
    names = list(DETECTORS)
    first = names.index("demo" if is_synthetic else "coco")
    return st.selectbox("Detector", names, first, format_func=DETECTORS.__getitem__, key=key)


def _notes(opened: OpenedRecording) -> None:
    """Where the detections come from, and what is wrong with them."""
    sources = sorted({view.source for view in opened.detections.views.values()})
    if sources:
        st.caption(f":material/center_focus_strong: Detections: {plain('; '.join(sources))}")
    if not opened.recording.is_synthetic and any(source.startswith(SMALL) for source in sources):
        st.caption(":material/warning: This detector was trained on synthetic recordings only.")
    by_hand = [note for note in opened.detections.notes if isinstance(note, Note) and note.flag == BY_HAND]
    if by_hand:
        st.caption(f":material/draw: {plain('; '.join(by_hand))}.")
    for note in (note for note in opened.detections.notes if note not in by_hand):
        st.warning(plain(note), icon=":material/warning:")


def _begin_by_itself(opened: OpenedRecording) -> None:
    """Search a recording that nobody inspected, unless that was stopped, failed or is too slow here."""
    job = shared.jobs().get(opened.job_key)
    is_new = job is None or (job.is_left and job.state == "cancelled")
    if not is_new or is_read_only() or _is_searched(opened):
        return
    settings = automatic_detector(opened.recording)
    if settings is not None and (_expected_s(opened, settings) or 0.0) <= BY_ITSELF_S:
        _start(opened, settings, is_automatic=True)


def _offer(opened: OpenedRecording) -> None:
    """Offer to detect where frames have not been inspected yet."""
    recording, found = opened.recording, opened.detections
    lacking = [name for name, count in _matched(opened).items() if len(found.views.get(name, ())) < count]
    if not lacking:
        return
    if is_read_only():
        st.caption(f":material/lock: Not every frame of {', '.join(lacking)} was inspected. {READ_ONLY}")
        return
    never = [name for name in lacking if name not in found.views and name not in found.lost]
    if never:
        path = recording.views[never[0]].video_path
        place = f"{path.parent.parent.name}/detections/{path.stem}.json"
        weights = "" if automatic_detector(recording) else _why_not(recording)
        st.info(
            f"No detections yet in {', '.join(never)}. {weights}Run a detector, or put COCO results in `{place}`.",
            icon=":material/search:",
        )
    left, middle, right = st.columns([2, 1.5, 1.1], vertical_alignment="bottom")
    with left:
        detector = detector_control(is_synthetic=recording.is_synthetic, key="detector")
    settings = find_detector(detector)
    expected_s = _expected_s(opened, settings)
    searches = middle.button(
        "Find the best frame" + ("" if expected_s is None else f" (about {duration_text(expected_s)})"),
        type="primary",
        icon=":material/search:",
        help=f"Every {SEARCH_STEP}th frame, then from coarse to fine around the best.",
        width="stretch",
    )
    inspects_all = right.button("Inspect all frames", icon=":material/select_all:", width="stretch")
    if searches or inspects_all:
        _start(opened, find_detector(detector, every=1) if inspects_all else settings)
        st.rerun()


def _why_not(recording: Recording) -> str:
    """Why no detector begins by itself."""
    if recording.is_synthetic:
        return "The weights of the demo's detector are missing. "
    return (
        f"None starts by itself, because the COCO weights of Mask R-CNN are not in {plain(str(coco_weights_file()))}; "
        "they are downloaded when it is run. "
    )


def _start(
    opened: OpenedRecording,
    settings: DetectorSettings,
    *,
    frames: Sequence[int] | None = None,
    is_automatic: bool = False,
) -> Job:
    """Detect in the background; what begins by itself ends after its first frames if it turns out to be slow."""
    recording, store, inspector = opened.recording, shared.store(), shared.inspector(settings)
    is_quick = is_automatic or frames is not None

    def work(job: Job) -> None:
        def is_to_stop() -> bool:
            is_slow = is_automatic and (inspector.frame_s or 0.0) * (job.total - job.done) > BY_ITSELF_S
            return job.cancelled() or is_slow

        detect_recording(
            recording,
            inspector,
            store=store,
            every=settings.every,
            frames=frames,
            progress=job.advance,
            kept=job.keep,
            cancelled=is_to_stop,
        )

    return shared.jobs().start(
        opened.job_key if frames is None else opened.frame_job_key,
        "Detecting containers" if frames is None else f"Inspecting frame {frames[0]}",
        work,
        priority=Priority.NOW if is_quick else Priority.SHOWN,
        is_automatic=is_automatic,
    )


def _expected_s(opened: OpenedRecording, settings: DetectorSettings) -> float | None:
    """How long a search will take, if this detector was used here before."""
    frame_s = shared.inspector(settings).frame_s
    return None if frame_s is None else frame_s * search_frames(open_views(opened).values(), settings.every)


def open_views(opened: OpenedRecording) -> dict[str, int]:
    """How many frames the views have that a detector can inspect; a view with a file of its own is done."""
    counts = {}
    for name in METHOD_VIEWS:
        view = opened.recording.views.get(name)
        if view is not None and view.detections_path is None:
            with suppress(CorsmalError):
                counts[name] = opened.video(name).frame_count
    return counts


def _is_searched(opened: OpenedRecording) -> bool:
    """Whether at least as many frames were inspected as a search begins with."""
    found = opened.detections.views
    return all(len(found.get(name, ())) >= ceil(count / SEARCH_STEP) for name, count in _matched(opened).items())


def _matched(opened: OpenedRecording) -> dict[str, int]:
    """How many of the recording's frames the views have in which a detector can inspect them."""
    clock = opened.recording.clock()
    return {name: clock.matched(name) for name in open_views(opened)}
