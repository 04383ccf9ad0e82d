"""The container's mass: the mask restored by symmetry, what the network is given, and what its answer hangs on."""

import streamlit as st

from corsmal.mass import AxisRule
from corsmal.ui import data, mass, mass_network, session
from corsmal.ui.detecting import open_detected
from corsmal.ui.linked_plot import plot_event
from corsmal.ui.object_mass import heard_filling, object_mass
from corsmal.ui.shape import parameters
from corsmal.ui.shape.measures import guarded

st.title("Mass")
recording, frames = open_detected()
network = None
with guarded():
    network = mass_network.model()
mass.about_weights(recording, network)


@st.fragment
@guarded()
def mass_panel() -> None:
    mass_network.choose_padding(plot_event("restoration").values.get("padding_px"))
    left, middle, right = st.columns([3, 4, 3])
    with left:
        pair, best = parameters.pair_control(recording)
    with middle:
        frame = parameters.frame_control(best, frames=frames)
    with right:
        axis: AxisRule = mass.axis_control("base" if network is None else network.config.axis)
    shape = session.choice().shape
    fit = data.fit(recording, pair=pair, frame=frame, centre_rule=best.centre_rule, shape=shape, keep=True)
    numbers = mass_network.chosen_numbers(recording, fit)
    mask = data.mask(recording, view=mass_network.MASS_VIEW, frame=frame, centre_rule=best.centre_rule)
    if not mass.shows_container(mask, frame=frame) or mask is None:
        return
    weighed = mass_network.weigh_mask(mask, numbers, network=network, axis=axis, padding=mass_network.padding_px())
    object_mass(recording, weighed.mass_g, heard_filling(recording), capacity_ml=numbers["capacity_ml"])
    mass.problems(fit, weighed, network)
    mass.pictures(recording, mask, weighed, frame=frame)
    left, right = st.columns([2, 3])
    with left:
        mass.number_inputs(recording, fit, numbers, with_scale=network is not None and network.config.with_scale)
    with right:
        mass.sensitivity(recording, weighed, numbers)
    mass.downloads(recording, weighed, frame=frame)


mass_panel()
