"""Which masks are used, and opening the editor."""

import streamlit as st

from corsmal.parameters import METHOD_VIEWS
from corsmal.stages.by_hand import masks_by_view
from corsmal.ui import session, shared
from corsmal.ui.opened import OpenedRecording


def masks_control(opened: OpenedRecording) -> None:
    """Choose which masks are used on all pages, if the recording has masks by hand or the address names some."""
    found, used = masks_by_view(opened.recording, store=shared.store()), session.choice().masks
    if any(found.values()) or used is not None:
        st.session_state["masks_control"] = used == "by-hand"
        st.toggle(
            "Masks by hand",
            key="masks_control",
            on_change=lambda: session.choose(masks=None if used == "by-hand" else "by-hand"),
            help="Use masks by hand in the frames that have them, on all pages. Off: the detected ones.",
        )


def edit_control(view: str, *, frame: int, key: str) -> None:
    """A button that opens the editor of masks on *Frames* for a view of a frame."""
    if st.button(f"Correct the mask of {view}", icon=":material/draw:", key=key):
        session.open_page("frames", edited=view, frame=frame)


def editor_control(opened: OpenedRecording, view: str) -> None:
    """Open or close the editor, at first of a view; nothing where there is nothing to edit."""
    if not any(name in opened.recording.views for name in METHOD_VIEWS):
        return
    edited = session.choice().edited
    st.button(
        "Correct",
        icon=":material/draw:",
        key="edit_masks",
        type="secondary" if edited is None else "primary",
        on_click=lambda: session.choose(edited=view if edited is None else None),
        help="Correct masks by hand: draw the container's outline where the detector erred, and see what the estimate "
        "would be. What was detected stays; *Masks by hand* says which are used. Pressed again it closes the editor.",
    )
