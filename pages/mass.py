"""The container's mass: the mask restored by symmetry, what the network is given, and what its answer hangs on."""

import streamlit as st

from corsmal.mass import AxisRule
from corsmal.ui import controls, data, session
from corsmal.ui.components import guarded
from corsmal.ui.detecting import open_detected
from corsmal.ui.linked_plot import plot_event
from corsmal.ui.mass import cached as mass
from corsmal.ui.mass import controls as weighing
from corsmal.ui.mass.object_mass import heard_filling, object_mass

st.title("Mass")
recording, frames = open_detected()
network = None
with guarded():
    network = mass.model()
weighing.about_weights(recording, network)


@st.fragment
@guarded()
def mass_panel() -> None:
    mass.choose_padding(plot_event("restoration").values.get("padding_px"))
    left, middle, right = st.columns([3, 4, 3])
    with left:
        pair, best = controls.pair_control(recording)
    with middle:
        frame = controls.frame_control(best, frames=frames)
    with right:
        axis: AxisRule = weighing.axis_control("base" if network is None else network.config.axis)
    shape = session.choice().shape
    fit = data.fit(recording, pair=pair, frame=frame, centre_rule=best.centre_rule, shape=shape, keep=True)
    numbers = mass.chosen_numbers(recording, fit)
    mask = data.mask(recording, view=mass.MASS_VIEW, frame=frame, centre_rule=best.centre_rule)
    if not weighing.shows_container(mask, frame=frame) or mask is None:
        return
    weighed = mass.weigh_mask(mask, numbers, network=network, axis=axis, padding=mass.padding_px())
    object_mass(recording, weighed.mass_g, heard_filling(recording), capacity_ml=numbers["capacity_ml"])
    weighing.problems(fit, weighed, network)
    weighing.pictures(recording, mask, weighed, frame=frame)
    left, right = st.columns([2, 3])
    with left:
        weighing.number_inputs(recording, fit, numbers, with_scale=network is not None and network.config.with_scale)
    with right:
        weighing.sensitivity(recording, weighed, numbers)
    weighing.downloads(recording, weighed, frame=frame)


mass_panel()
