"""The hull: fitted while the sliders move, in 3D, as a profile and over the pictures it was fitted to."""

import streamlit as st

from corsmal.figures import hull_figure, profile_figure
from corsmal.ui import data, session
from corsmal.ui.detecting import open_detected
from corsmal.ui.linked_plot import linked_plot, plot_event
from corsmal.ui.pins import pin_hull
from corsmal.ui.recordings import truth, truth_profile_mm
from corsmal.ui.shape import parameters
from corsmal.ui.shape.measures import guarded, hull_downloads, measures, recording_measures, reprojection

st.title("Shape")
recording, frames = open_detected()


@st.fragment
@guarded()
def fit_panel() -> None:
    event = plot_event("hull")
    parameters.apply_sliders(event)
    left, second, middle, right = st.columns([3, 2, 4, 4])
    with left:
        parameters.preset_control()
    with second:
        compared = parameters.beside_control()
    with middle:
        pair, best = parameters.pair_control(recording)
    with right:
        frame = parameters.frame_control(best, frames=frames)
    shape = session.choice().shape
    fit = data.fit(recording, pair=pair, frame=frame, centre_rule=best.centre_rule, shape=shape, keep=event.settled)
    other = data.preset_fit(recording, fit, centre_rule=best.centre_rule, preset=compared)
    measures(fit, truth=truth(recording), beside=other)
    beside = None if other is None else (other[0], other[1].hull)
    if fit.hull.ok:
        left, right = st.columns([3, 2])
        with left:
            scope = parameters.scope_control()
            linked_plot(
                hull_figure(fit.hull, fit.dimensions, cameras=data.cameras(recording), scope=scope, beside=beside),
                key="hull",
                label="Hull, circumferences and cameras in 3D",
                sliders=parameters.live_sliders(),
                height_px=520,
                revision=f"{recording.id} {scope}",
            )
        with right:
            linked_plot(
                profile_figure(fit.hull, fit.dimensions, truth_mm=truth_profile_mm(recording), beside=beside),
                key="profile",
                label="Radius of the circumferences by height",
                height_px=640,
                revision=recording.id,
            )
    for column, view in zip(st.columns(2), pair, strict=True):
        with column, guarded():
            reprojection(recording, view=view, frame=frame, fit=fit, centre_rule=best.centre_rule, points=shape.points)
    if st.toggle("Estimate over the whole recording, with intervals", help="Preset `tuned`, several frames together."):
        found = data.tuned_estimate(recording)
        recording_measures(found, truth=truth(recording))
        if found.fit is not None:
            parameters.explained_frame_control(found.fit, frame=frame)
    parameters.other_parameters()
    hull_downloads(recording, fit)
    pin_hull(recording, fit)


fit_panel()
