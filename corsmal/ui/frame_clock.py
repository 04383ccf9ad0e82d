"""The frames of a recording's views: how many there are, at which rate, and how they are matched."""

from functools import partial

import pandas as pd
import streamlit as st

from corsmal.dataset.clock import OFFSET_DIGITS, OFFSET_MAX_S, FrameClock, Match, Matching
from corsmal.estimation.view_offsets import ViewOffset, corrected, find_offsets
from corsmal.ui import session
from corsmal.ui.caching import cached
from corsmal.ui.one_of import one_of
from corsmal.ui.opened import OpenedRecording, by_detections

SEARCHED = "offsets_searched"
"""The key of the detections in which this session looked for offsets last."""

WAYS: dict[Match, str] = {"time": "time stamps", "index": "frame number"}


def clock_control(opened: OpenedRecording) -> None:
    """Frame counts, rates and starts of the views, and the choice of how their frames are matched."""
    clock, matching = opened.recording.clock(), opened.recording.matching
    with st.popover(clock_words(clock, matching), icon=":material/schedule:", key="frame_clock"):
        if not clock.views:
            st.caption("No video can be read.")
            return
        st.table(clock_table(clock))
        for note in clock.notes:
            st.caption(f":material/info: {note}.")
        one_of(
            "Match frames by",
            WAYS,
            key="match_control",
            field="match",
            forgets=("frame",),
            help_text="Time stamps count where rates, dropped frames or starts differ. By number: frame 10 of one view "
            "is shown with frame 10 of the others, whatever the files say.",
        )
        _offset_inputs(clock, matching)
        if matching.by == "time":
            _search(opened)


def clock_words(clock: FrameClock, matching: Matching) -> str:
    """The views' frames in a few words."""
    counts, rates = ({getattr(each, name) for each in clock.views.values()} for name in ("count", "fps"))
    if len(counts) == 1 and len({round(fps, 2) for fps in rates}) == 1 and matching == Matching():
        return f"{counts.pop()} frames at {rates.pop():.4g} fps"
    return f"{len(clock)} frames, views matched {matching}"


def clock_table(clock: FrameClock) -> pd.DataFrame:
    """A row per view that can be read: what its file says, and how many of the recording's frames it has."""
    rows = {
        name: {
            "frames": view.count,
            "fps": f"{view.fps:.4g}" if view.fps else "–",
            "starts at": f"{view.start_s:.3f} s",
            "matched": clock.matched(name),
        }
        for name, view in sorted(clock.views.items())
    }
    return pd.DataFrame(rows.values(), index=pd.Index(rows, name="view"))


def _offset_inputs(clock: FrameClock, matching: Matching) -> None:
    """How much later each view was filmed than its file says."""
    known, state, names = dict(session.choice().offsets_s), st.session_state, sorted(clock.views)
    for column, name in zip(st.columns(len(names)), names, strict=True):
        state[_key(name)] = known.get(name)
        column.number_input(
            f"{name} later by (s)",
            -OFFSET_MAX_S,
            OFFSET_MAX_S,
            None,
            step=1 / (clock.fps or 30.0),
            format=f"%.{OFFSET_DIGITS}f",
            placeholder="as the file says",
            key=_key(name),
            disabled=matching.by == "index",
            on_change=partial(_offsets_chosen, names),
        )
    st.caption(
        "How much later a view was filmed than its file says; empty where the file is right. It counts for this "
        "recording on all pages and for runs started from here."
    )


def _search(opened: OpenedRecording) -> None:
    """Look for offsets on request; what is found is only suggested."""
    state, searched = st.session_state, opened.detections.key
    if st.button("Look for offsets", icon=":material/search:", key="search_offsets"):
        state[SEARCHED] = searched
    if state.get(SEARCHED) != searched:
        st.caption("From how the container moves in the views; detections of every few frames are needed.")
        return
    found = _found(opened)
    if not found:
        st.caption(":material/info: None of more than a frame was found: the views agree, or it cannot be told.")
        return
    clock = opened.recording.clock()
    for each in found:
        later = "later" if each.offset_s > 0 else "earlier"
        frames = abs(each.offset_s) * clock.fps
        st.warning(
            f"{each.view} seems to have been filmed {abs(each.offset_s):.2f} s ({frames:.1f} frames) {later} than it "
            f"is matched with {each.reference}. Look at the pictures before you use it.",
            icon=":material/schedule:",
        )
    better = corrected(opened.recording.matching, clock, found)
    st.button("Use what was found", on_click=lambda: session.choose(offsets_s=better.offsets_s, frame=None))


@cached(32, key=by_detections, spinner="Following the container in the views")
def _found(opened: OpenedRecording) -> tuple[ViewOffset, ...]:
    return find_offsets(opened.recording, opened.detections.views)


def _offsets_chosen(names: list[str]) -> None:
    typed = {name: st.session_state[_key(name)] for name in names}
    offsets = tuple((name, round(value, OFFSET_DIGITS)) for name, value in typed.items() if value is not None)
    session.choose(offsets_s=offsets, frame=None)


def _key(view: str) -> str:
    return f"offset {view}"
