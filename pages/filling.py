"""What the filling network heard, and what it makes of it: the answer follows the crop."""

import streamlit as st

from corsmal.ui import filling, session, sound
from corsmal.ui.components import guarded
from corsmal.ui.linked_plot import plot_event

st.title("Filling")
_, recording = session.opened()


@st.fragment
@guarded()
def listen() -> None:
    event = plot_event(filling.TIMELINE)
    picture = sound.picture(recording, channel=session.choice().channel)
    crop_s = filling.followed_crop(event, picture)
    cursor = filling.followed_frame(event, sound.frame_clock(recording))
    if event.settled:
        session.write_address()
    prediction = filling.predicted(recording, crop_s)
    if prediction is not None:
        filling.answer(recording, prediction, crop_s=crop_s)
    filling.controls(recording, picture, crop_s=crop_s, settled=event.settled)
    filling.timeline(picture, recording=recording, prediction=prediction, crop_s=crop_s, cursor=cursor)
    filling.downloads(recording, crop_s=crop_s, has_answer=prediction is not None)


filling.weights_note(recording)
listen()
