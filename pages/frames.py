"""Every frame's View Score, and the rules and detections behind it."""

import streamlit as st

from corsmal.parameters import SHAPE_PRESETS
from corsmal.ui import session
from corsmal.ui.detecting import open_detected
from corsmal.ui.frame_clock import clock_control
from corsmal.ui.frames import (
    detections_tables,
    picture_pins,
    rules_table,
    score_line,
    score_plot,
    selection_control,
)
from corsmal.ui.look import heading
from corsmal.ui.mask_editor import editor_control, mask_editor, masks_control
from corsmal.ui.opened import OpenedRecording, show_panel
from corsmal.ui.pair import pair_control
from corsmal.ui.pins import pin_button
from corsmal.ui.time_line import ALL_KEYS, time_line

controls = heading("Frames")
opened = open_detected()
shape = SHAPE_PRESETS[session.choice().selection_name]
with controls, st.container(horizontal=True, vertical_alignment="bottom"):
    with st.container(width="content"):
        selection_control()
    with st.container(width="content"):
        best = pair_control(opened, opened.estimate(shape), shape)
    with st.container(width="content"):
        clock_control(opened)
    with st.container(width="content"):
        editor_control(opened, best.pair[0])
    with st.container(width="content"):
        masks_control(opened)


def browse(opened: OpenedRecording) -> None:
    frame = time_line(opened, best, keys=ALL_KEYS, is_large=session.choice().edited is None)
    if mask_editor(opened, best, frame):
        return
    if best.scores:
        score_line(opened, best, frame)
        score_plot(opened, best)
    rules_table(opened, best, frame)
    detections_tables(opened, best, frame)
    pin_button("the pictures", lambda: picture_pins(opened, best, frame), key="frames")


show_panel(browse, opened)
