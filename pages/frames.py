"""Every frame's View Score, and the detections behind it."""

import streamlit as st

from corsmal.parameters import SHAPE_PRESETS
from corsmal.ui import session
from corsmal.ui.detecting import open_detected
from corsmal.ui.frames import picture_pins, score_line, score_plot, stepped, view_pictures
from corsmal.ui.linked_plot import plot_event
from corsmal.ui.opened import OpenedRecording, show_panel
from corsmal.ui.pair_and_frame import frame_control, pair_control
from corsmal.ui.pins import pin_button

st.title("Frames")
opened = open_detected()
paper = SHAPE_PRESETS["paper"]
best = pair_control(opened, opened.estimate(paper), paper)


def browse(opened: OpenedRecording) -> None:
    event, current = plot_event("scores"), session.choice().frame
    frame = stepped(best.frame or 0 if current is None else current, event, frames=opened.frames)
    moved = event.click is not None or event.key is not None
    session.choose(settled=event.settled, **({"frame": frame} if moved else {}))
    if best.scores:
        score_line(best, frame, frames=opened.frames)
    else:
        frame = frame_control(best, frames=opened.frames)
    view_pictures(opened, best, frame)
    if best.scores:
        score_plot(opened, best, frame)
    pin_button("the pictures", lambda: picture_pins(opened, best, frame), key="frames")


show_panel(browse, opened)
