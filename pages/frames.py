"""Every frame's View Score, and the detections behind it."""

import streamlit as st

from corsmal.figures import score_figure
from corsmal.ui import frames as viewer
from corsmal.ui import session
from corsmal.ui.detecting import open_detected
from corsmal.ui.linked_plot import linked_plot, plot_event
from corsmal.ui.pins import pin_frames
from corsmal.ui.shape import parameters
from corsmal.ui.shape.measures import guarded

st.title("Frames")
recording, frames = open_detected()
pair, best = parameters.pair_control(recording)


@st.fragment
@guarded()
def browse() -> None:
    event = plot_event("scores")
    current = session.choice().frame
    frame = viewer.stepped(best.frame or 0 if current is None else current, event, frames=frames)
    if event.click is not None or event.key is not None:
        session.choose(frame=frame, settled=event.settled)
    if best.scores:
        viewer.score_line(best, frame, frames=frames)
        linked_plot(
            score_figure(best, frame=frame),
            key="scores",
            label=f"Scores of the frames of recording {recording.id}",
            keys=viewer.KEYS,
            height_px=320,
            revision=recording.id,
        )
        st.caption("Click a frame, or step with ← → (one), Page Up and Page Down (ten), Home and End.")
    else:
        frame = parameters.frame_control(best, frames=frames)
    if event.settled:
        session.write_address()
    viewer.view_pictures(recording, frame=frame, best=best)
    pin_frames(recording, pair=pair, frame=frame, centre_rule=best.centre_rule)


browse()
