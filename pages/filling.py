"""The sound, and what the filling network predicts from it and the videos: the prediction follows the crop."""

import streamlit as st

from corsmal.ui import session
from corsmal.ui.detecting import watch_detection
from corsmal.ui.filling import fused, sound, timeline
from corsmal.ui.filling.answer import answer, predicted, weights_note
from corsmal.ui.filling.downloads import downloads
from corsmal.ui.filling.network import fused_network
from corsmal.ui.linked_plot import plot_event
from corsmal.ui.networks import network_note
from corsmal.ui.opened import OpenedRecording, show_panel
from corsmal.ui.pair import chosen_best
from corsmal.ui.time_line import time_line

st.title("Filling")
opened = OpenedRecording(session.opened()[1], session.choice().selected_by)
watch_detection(opened)
session.keep_frame_within(opened.frames)
weights_note(opened.recording)


def listen(opened: OpenedRecording) -> None:
    frame = time_line(opened, chosen_best(opened))
    event, is_fused = plot_event(timeline.TIMELINE), fused_network() is not None
    channel = session.choice().channel
    picture = fused.picture_or_note(opened) if is_fused else sound.picture(opened, channel)
    crop_s = None if picture is None else timeline.followed_crop(event, picture)
    left, right = st.columns([3, 7], gap="medium")
    with left:
        prediction = predicted(opened, crop_s)
        if prediction is not None:
            answer(opened, prediction, crop_s=crop_s)
        if is_fused and prediction is not None:
            fused.clip(opened, frame)
    with right:
        if picture is not None:
            timeline.controls(opened, crop_s=crop_s, settled=event.settled)
            heard = None if is_fused else prediction
            timeline.timeline(picture, opened=opened, prediction=heard, crop_s=crop_s)
        if is_fused and prediction is not None:
            fused.over_time(opened)
    network_note("filling")
    if picture is not None:
        downloads(opened, crop_s=crop_s, has_answer=prediction is not None)


show_panel(listen, opened)
