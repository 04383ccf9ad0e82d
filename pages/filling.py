"""What the filling network heard, and what it makes of it: the answer follows the crop."""

import streamlit as st

from corsmal.ui import session
from corsmal.ui.components import guarded
from corsmal.ui.filling import cached as sound
from corsmal.ui.filling import controls as filling
from corsmal.ui.filling.downloads import downloads
from corsmal.ui.linked_plot import plot_event
from corsmal.ui.viewer import longest_view

st.title("Filling")
_, recording = session.opened()
clock = sound.frame_clock(recording)
if clock is not None:
    session.keep_frame_within(longest_view(recording))


@st.fragment
@guarded()
def listen() -> None:
    event = plot_event(filling.TIMELINE)
    picture = sound.picture(recording, channel=session.choice().channel)
    crop_s = filling.followed_crop(event, picture)
    cursor = filling.followed_frame(event, clock)
    if event.settled:
        session.write_address()
    left, right = st.columns([2, 5], gap="medium")
    with left:
        prediction = filling.predicted(recording, crop_s)
        if prediction is not None:
            filling.answer(recording, prediction, crop_s=crop_s)
        filling.frame_picture(recording, cursor)
    with right:
        filling.controls(recording, crop_s=crop_s, settled=event.settled)
        filling.timeline(picture, recording=recording, prediction=prediction, crop_s=crop_s, cursor=cursor)
    downloads(recording, crop_s=crop_s, has_answer=prediction is not None)


filling.weights_note(recording)
listen()
