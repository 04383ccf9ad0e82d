"""The panel of masks by hand on *Frames*: the editor, what the masks change, their versions, what to correct next."""

import uuid
from dataclasses import replace
from functools import partial

import pandas as pd
import streamlit as st

from corsmal.estimation import Fit
from corsmal.parameters import METHOD_VIEWS, SHAPE_PRESETS
from corsmal.quantities import BY_NAME, GEOMETRY
from corsmal.selection import BestFrame
from corsmal.stages.hand_comparison import compare_masks, compare_outlines, mask_sentence
from corsmal.ui import session, shared
from corsmal.ui.folders import is_read_only
from corsmal.ui.linked_plot.component import fresh_report
from corsmal.ui.mask_editor.component import EDITOR, editor_component
from corsmal.ui.mask_editor.edited import EditedFrame
from corsmal.ui.mask_editor.edits import outcome
from corsmal.ui.mask_editor.fits import fits_of
from corsmal.ui.mask_editor.next_masks import next_masks
from corsmal.ui.messages import guarded, plain
from corsmal.ui.opened import OpenedRecording
from corsmal.ui.shape.measures import annotated

SESSION, SAID, COMPARED = "mask_editor_session", "mask_editor_said", "masks_compared"


def mask_editor(opened: OpenedRecording, best: BestFrame, frame: int) -> bool:
    """Show the editor where it is on.

    Args:
        opened: the recording.
        best: gives the pair of views.
        frame: of the recording.

    Returns:
        Whether the editor is open.
    """
    if session.choice().edited is None or opened.recording.views.keys().isdisjoint(METHOD_VIEWS):
        return False
    detected = opened
    if opened.recording.masks != "detected":
        detected = OpenedRecording(replace(opened.recording, masks="detected"), opened.selection)

    @st.fragment
    @guarded()
    def editor() -> None:
        _editor(detected, best, frame)

    if detected is opened:
        editor()  # a stroke changes nothing else on the page
    else:
        _editor(detected, best, frame)
    with guarded():
        next_masks(detected, best)
    return True


def _editor(opened: OpenedRecording, best: BestFrame, frame: int) -> None:
    """The editor, the versions of its mask, and what all masks by hand change."""
    said = _take_over(opened)
    views = [view for view in (*best.pair, *METHOD_VIEWS) if view in opened.recording.views]
    wanted = session.choice().edited
    active = wanted if wanted in views else views[0]
    edited = {view: EditedFrame(opened, view, frame) for view in METHOD_VIEWS if view in opened.recording.views}
    fits = fits_of(edited, best.pair, session.choice().shape)
    truth = annotated(opened.recording)
    said = [*said, *_said_of(fits[1])]
    editor_component(opened, frame, edited, active=active, fits=fits, truth=truth, said=said)
    with guarded():
        _versions(edited[active])
    with guarded():
        _comparison(opened)


def _take_over(opened: OpenedRecording) -> list[str]:
    """Do what the visitor did in the editor.

    Returns:
        What is to be said of it.
    """
    state, report = st.session_state, fresh_report(EDITOR)
    by = state.setdefault(SESSION, uuid.uuid4().hex[:12])
    view = (report.get("values") or {}).get("view")
    if view in opened.recording.views:
        session.choose(edited=view)
    if report.get("actions"):
        state[SAID] = outcome(opened, report["actions"], by=by)
    elif report:
        state[SAID] = []
    said: list[str] = state.get(SAID, [])
    return said


def _said_of(fit: Fit) -> list[str]:
    """Which fit the numbers are of, or why there are none."""
    made = f"Numbers: {session.choice().shape_name}, {' + '.join(fit.pair)}."
    return [made] if fit.ok else [made, f"Nothing fits these masks: {fit.dimensions.reason}."]


def _versions(edited: EditedFrame) -> None:
    """All versions of the frame's mask, by whomever, and taking one up again."""
    history, masks = edited.history, edited.masks
    for problem in masks.problems():
        st.warning(plain(problem), icon=":material/warning:")
    steps = [step for step in history.steps if step.mask is not None]
    with st.expander(
        f"Versions of the mask of {edited.view}, frame {edited.frame} ({len(steps)})", icon=":material/history:"
    ):
        if not steps:
            st.caption("Nothing was drawn here yet.")
            return
        rows = [
            {
                "version": step.number,
                "tool": step.tool,
                "who": step.who or "–",
                "when (UTC)": step.when[:19].replace("T", " "),
                "pixels": 0 if step.mask is None else step.mask.area,
                "beside": "drawn on an older version, not shown" if step.is_beside else "",
            }
            for step in reversed(steps)
        ]
        st.dataframe(pd.DataFrame(rows), hide_index=True, height="content" if len(rows) < 8 else 280)
        if not is_read_only():
            number = st.selectbox("Version", [step.number for step in reversed(steps)], key=f"version {edited.view}")
            st.button(
                "Use this version",
                icon=":material/restore:",
                key="use_version",
                on_click=partial(_restore, edited, number),
            )


def _restore(edited: EditedFrame, number: int) -> None:
    edited.masks.restore(edited.own, number, by=st.session_state[SESSION])


def _comparison(opened: OpenedRecording) -> None:
    """What all masks by hand of the recording change, on request: all presets are estimated for that."""
    if not st.toggle("What do the masks by hand of this recording change?", key=COMPARED):
        return
    store, recording = shared.store(), opened.recording
    table = compare_masks(recording, shapes=SHAPE_PRESETS, store=store)
    if table.empty:
        st.info("It takes masks by hand in two views of a frame.", icon=":material/draw:")
        return
    truth = annotated(recording)
    shown = table.reset_index()[["preset", "masks", *GEOMETRY, "frame", "pair"]]
    if truth:
        shown.loc[len(shown)] = {"preset": "annotation", **truth}
    labels = {name: f"{BY_NAME[name].label} ({BY_NAME[name].unit})" for name in GEOMETRY}
    st.dataframe(shown.rename(columns=labels).style.format(precision=1, na_rep="–"), hide_index=True, height="content")
    st.caption(
        "The same frames and views with the detected masks and with those by hand; each preset chooses among them."
    )
    if truth:
        st.markdown("\n".join(f"- {mask_sentence(table, truth, preset=preset)}" for preset in SHAPE_PRESETS))
    outlines = compare_outlines(recording, store=store)
    st.dataframe(outlines.style.format(precision=3, na_rep="–"), hide_index=True, height="content")
    st.caption("Detected masks against those by hand: overlap (IoU), and the pixels that the detector missed or added.")
