"""The hull: fitted while the sliders move, in 3D, as a profile and over the pictures it was fitted to."""

import streamlit as st

from corsmal.parameters import SHAPE_PRESETS
from corsmal.ui import session
from corsmal.ui.detecting import open_detected
from corsmal.ui.linked_plot import plot_event
from corsmal.ui.opened import OpenedRecording, show_panel
from corsmal.ui.pair_and_frame import frame_control, pair_control
from corsmal.ui.pins import pin_button
from corsmal.ui.shape.measures import annotated, annotated_profile_mm, hull_downloads, measures, recording_measures
from corsmal.ui.shape.parameters import apply_sliders, compared_preset, other_parameters, preset_control
from corsmal.ui.shape.plots import hull_pins, hull_plots, reprojections

st.title("Shape")
opened = open_detected()
truth = annotated(opened.recording)
left, second, middle, right = st.columns([3, 2, 4, 4])
with left:
    preset_control()
with second:
    compared = compared_preset()
with middle:
    best = pair_control(opened)
with right:
    frame = frame_control(best, frames=opened.frames)


def fit_panel(opened: OpenedRecording) -> None:
    event = plot_event("hull")
    apply_sliders(event)
    shape = session.choice().shape
    fit = opened.fit(best, frame, shape, is_settled=event.settled)
    beside = None if compared is None else (compared, opened.fit(best, frame, SHAPE_PRESETS[compared]))
    measures(fit, truth=truth, is_inspected=opened.is_inspected(fit.pair, frame), beside=beside)
    if fit.hull.ok:
        hull = None if beside is None else (beside[0], beside[1].hull)
        hull_plots(opened, fit, beside=hull, truth_mm=annotated_profile_mm(truth))
    reprojections(opened, best, fit, frame=frame, points=shape.points)
    if fit.hull.ok:
        hull_downloads(opened.id, fit)
        pin_button("the hull", lambda: hull_pins(opened, fit), key="hull")


show_panel(fit_panel, opened)
if st.toggle("Estimate over the whole recording, with intervals", help="Preset `tuned`, several frames together."):
    found = opened.estimate("tuned")
    recording_measures(found, truth=truth)
    if found.fit is not None:
        number, pair = found.fit.frame, found.fit.pair
        st.button(
            f"Go to the best-fitting frame ({number})",
            icon=":material/center_focus_strong:",
            disabled=number == frame,
            on_click=lambda: session.choose(frame=number, pair=pair),
        )
other_parameters()
