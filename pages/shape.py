"""The shape over the recording, and a frame's hull that follows the sliders: in 3D, as a profile, over the pictures."""

import streamlit as st

from corsmal.parameters import SHAPE_PRESETS
from corsmal.ui import session
from corsmal.ui.detecting import open_detected
from corsmal.ui.estimating import estimate_control, shape_estimate
from corsmal.ui.linked_plot import plot_event
from corsmal.ui.look import heading
from corsmal.ui.mask_editor import edit_control
from corsmal.ui.opened import OpenedRecording, show_panel
from corsmal.ui.pair import pair_control
from corsmal.ui.pins import pin_button
from corsmal.ui.shape.measures import annotated, frame_problems, hull_downloads, measured_numbers, measures
from corsmal.ui.shape.parameters import apply_sliders, compared_preset, other_parameters, preset_control
from corsmal.ui.shape.plots import hull_pins, hull_plots, reprojections
from corsmal.ui.time_line import time_line

controls = heading("Shape")
opened = open_detected()
truth = annotated(opened.recording)
found, estimated, estimate_name = (
    shape_estimate(opened),
    session.choice().estimated_shape,
    session.choice().estimate_name,
)
with controls, st.container(horizontal=True, vertical_alignment="bottom"):
    with st.container(width="content"):
        estimate_control()
    with st.container(width="content"):
        preset_control()
    with st.container(width=110):
        compared = compared_preset()
    with st.container(width=125):
        best = pair_control(opened, found, estimated, is_narrow=True)


def fit_panel(opened: OpenedRecording) -> None:
    above, line = st.container(), st.container()  # the hull, its sliders and the measures fit on one screen
    with line:
        frame = time_line(opened, best)
    event = plot_event("hull")
    apply_sliders(event)
    shape = session.choice().shape
    fit = opened.fit(best, frame, shape, is_settled=event.settled)
    beside = None if compared is None else (compared, opened.fit(best, frame, SHAPE_PRESETS[compared]))
    fits = [(session.choice().shape_name, fit), *([] if beside is None else [beside])]
    agreements = opened.agreements(fit, best.centre_rule) if event.settled else {}
    with above:
        measures(found, name=estimate_name, fits=fits, truth=truth)
        frame_problems(fit, agreements, is_inspected=opened.is_inspected(fit.pair, frame), box_odds=found.box_odds)
        hull = None if beside is None else (beside[0], beside[1].hull)
        if fit.hull.ok:
            hull_plots(opened, fit, beside=hull, estimated=estimated)
    reprojections(opened, best, fit, frame=frame, shape=shape, agreements=agreements)
    edit_control(best.pair[0], frame=frame, key="edit_mask")
    if fit.hull.ok:
        hull_downloads(opened.id, fit)
        numbers = measured_numbers(found, name=estimate_name, fits=fits)
        pin_button("the hull", lambda: hull_pins(opened, fit, beside=hull, numbers=numbers), key="hull")


show_panel(fit_panel, opened)
other_parameters()
