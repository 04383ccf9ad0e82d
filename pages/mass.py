"""The container's mass: the mask restored by symmetry, the network's inputs, and what its prediction depends on."""

import streamlit as st

from corsmal.ui import mass, mass_network, mass_numbers, session
from corsmal.ui.detecting import open_detected
from corsmal.ui.estimating import estimate_control, shape_estimate
from corsmal.ui.linked_plot import plot_event
from corsmal.ui.look import heading
from corsmal.ui.networks import network_note
from corsmal.ui.opened import OpenedRecording, show_panel
from corsmal.ui.pair import pair_control
from corsmal.ui.time_line import time_line

controls = heading("Mass")
opened = open_detected()
network = mass_network.open_network(opened.recording)
found, shape = shape_estimate(opened), session.choice().estimated_shape
with controls, st.container(horizontal=True, vertical_alignment="bottom"):
    with st.container(width="content"):
        estimate_control()
    with st.container(width=125):
        best = mass.best_for_mass(found, pair_control(opened, found, shape, is_narrow=True))
    with st.container(width="content"):
        axis = mass_network.axis_control(network)


def mass_panel(opened: OpenedRecording) -> None:
    frame = time_line(opened, best)
    padding_px = mass_network.dragged_padding_px(plot_event("restoration"), network)
    shown, fit = mass.estimate_in_frame(opened, found, best, frame, shape)
    inputs = mass.network_inputs(opened, shown)
    if inputs is None:
        return
    mask, fitted = inputs
    numbers = mass_numbers.chosen_numbers(opened, fit, fitted)
    prediction, curves_g = mass.predict(mask, numbers, network=network, axis=axis, padding_px=padding_px)
    filling = mass.object_mass(opened, prediction.mass_g, capacity_ml=numbers["capacity_ml"])
    is_complete = mass_numbers.number_notes(numbers, fitted, network=network)
    mass.problems(shown, prediction, is_asked=is_complete and network is not None)
    resize = "stretch" if network is None else network.config.resize
    mass.pictures(opened, mask, prediction, frame=frame, resize=resize, axis=axis, padding_px=padding_px)
    st.caption(filling)
    if network is not None:
        network_note("mass")
        mass_network.trained_otherwise(network, axis=axis, padding_px=padding_px)
    left, right = st.columns([2, 3])
    with left:
        with_scale = network is not None and network.config.with_scale
        mass_numbers.number_inputs(numbers, fitted, with_scale=with_scale)
    with right:
        mass.sensitivity(opened, numbers, curves_g)
    mass.downloads(opened, prediction, frame=frame)


show_panel(mass_panel, opened)
