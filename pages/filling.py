"""What the filling network heard, and what it makes of it: the answer follows the crop."""

import streamlit as st

from corsmal.ui import session
from corsmal.ui.filling import sound, timeline
from corsmal.ui.filling.downloads import downloads
from corsmal.ui.frames import longest_view
from corsmal.ui.linked_plot import plot_event
from corsmal.ui.shape.measures import guarded

st.title("Filling")
_, recording = session.opened()
clock = sound.frame_clock(recording)
if clock is not None:
    session.keep_frame_within(longest_view(recording))


@st.fragment
@guarded()
def listen() -> None:
    event = plot_event(timeline.TIMELINE)
    picture = sound.picture(recording, channel=session.choice().channel)
    crop_s = timeline.followed_crop(event, picture)
    cursor = timeline.followed_frame(event, clock)
    if event.settled:
        session.write_address()
    left, right = st.columns([2, 5], gap="medium")
    with left:
        prediction = timeline.predicted(recording, crop_s)
        if prediction is not None:
            timeline.answer(recording, prediction, crop_s=crop_s)
        timeline.frame_picture(recording, cursor)
    with right:
        timeline.controls(recording, crop_s=crop_s, settled=event.settled)
        timeline.timeline(picture, recording=recording, prediction=prediction, crop_s=crop_s, cursor=cursor)
    downloads(recording, crop_s=crop_s, has_answer=prediction is not None)


timeline.weights_note(recording)
listen()
