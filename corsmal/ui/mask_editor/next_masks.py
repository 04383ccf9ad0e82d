"""Which masks to correct next, in the recording that is edited and in others."""

from functools import partial
from itertools import islice

import streamlit as st

from corsmal.parameters import selection_of
from corsmal.runs.correcting import NO_RUN, masks_to_correct, run_to_correct
from corsmal.selection import BestFrame
from corsmal.stages.hand_comparison import frames_to_correct
from corsmal.ui import session, shared
from corsmal.ui.choice import OF_RECORDING
from corsmal.ui.messages import plain
from corsmal.ui.opened import OpenedRecording

SHOWN = 5


def next_masks(opened: OpenedRecording, best: BestFrame) -> None:
    """Masks whose correction would tell most, on request: several frames are fitted for that.

    Args:
        opened: the recording with its detected masks.
        best: gives the pair of views.
    """
    with st.container(horizontal=True):
        is_asked_here = st.button(
            "Which mask next?",
            icon=":material/search_insights:",
            key="next_mask",
            help="First the frames that the estimate uses, then those in which hull and masks, and so the two views, "
            "agree least.",
        )
        is_asked_elsewhere = st.button(
            "Which recording next?",
            icon=":material/search_insights:",
            key="next_recording",
            help="The other recordings whose estimates are least sure, by the 90 % intervals of the newest run of "
            "*tuned*, each with the frame to correct first.",
        )
    _frames(opened, best, is_asked=is_asked_here)
    _recordings(opened, is_asked=is_asked_elsewhere)


def _frames(opened: OpenedRecording, best: BestFrame, *, is_asked: bool) -> None:
    key = f"next {opened.key} {best.pair}"
    if is_asked:
        shape = session.choice().estimated_shape
        st.session_state[key] = frames_to_correct(
            opened.recording,
            opened.detections,
            pair=best.pair,
            shape=shape,
            selection=selection_of(shape),
            store=shared.store(),
        )
    found = st.session_state.get(key)
    if found is None:
        return
    if not found:
        st.caption("There is none: all frames with detections in both views have masks by hand.")
    for candidate in found[:SHOWN]:
        st.button(
            str(candidate),
            key=f"next {candidate.frame} {candidate.view}",
            type="tertiary",
            on_click=partial(session.choose, frame=candidate.frame, edited=candidate.view),
        )


def _recordings(opened: OpenedRecording, *, is_asked: bool) -> None:
    key = f"next after {opened.key}"
    if is_asked:
        store, (dataset, _) = shared.store(), session.opened()
        run = run_to_correct(dataset, store=store)
        found = (
            None if run is None else list(islice(masks_to_correct(run, dataset, store=store, without=opened.id), SHOWN))
        )
        st.session_state[key] = run, found
    if key not in st.session_state:
        return
    run, found = st.session_state[key]
    if run is None:
        st.caption(f"{NO_RUN} Make it on *Evaluation*, under *New run*.")
    elif not found:
        st.caption(
            plain(f"There is none: run {run.name} has no other recording with 90 % intervals and a frame to correct.")
        )
    else:
        st.caption(plain(f"By the 90 % intervals of run {run.name}:"))
        matching = run.settings.matching
        matched = {"match": None if matching.by == "time" else matching.by, "offsets_s": matching.offsets_s}
        for each in found:
            changes = OF_RECORDING | matched | {"frame": each.candidate.frame, "edited": each.candidate.view}
            if st.button(str(each), key=f"next {each.recording_id}", type="tertiary"):
                session.open_page("frames", recording=each.recording_id, **changes)
