"""The hull in 3D, its profile, and its circumferences over the pictures."""

from collections.abc import Mapping
from typing import Any

import streamlit as st

from corsmal.errors import CorsmalError
from corsmal.estimation import Fit
from corsmal.figures import hull_figure, profile_figure, reprojection_figure
from corsmal.figures.hull import Scope
from corsmal.figures.pins import Pin
from corsmal.parameters import ShapeParameters
from corsmal.selection import BestFrame
from corsmal.shape import Agreement, Hull, KnownProfile
from corsmal.ui import session
from corsmal.ui.linked_plot import linked_plot
from corsmal.ui.messages import guarded
from corsmal.ui.one_of import one_of
from corsmal.ui.opened import OpenedRecording
from corsmal.ui.shape.parameters import chosen_camera, live_sliders, own_values, parameter_texts, parameters_note

SCOPES: dict[Scope, str] = {"container": "container", "cameras": "cameras"}
HEIGHT_PX, SLIDERS_PX = 380, 70
"""Of the hull, and of what is below it: with the measures above they fit a screen."""


def hull_plots(
    opened: OpenedRecording, fit: Fit, *, beside: tuple[str, Hull] | None, estimated: ShapeParameters
) -> None:
    """The hull in 3D with the sliders that refit it, and its profile."""
    preset, known = session.choice().preset, _known(opened, fit)
    left, right = st.columns([3, 2])
    with left:
        scope = _hull_controls(known)
        linked_plot(
            hull_figure.parts(fit.hull, fit.dimensions, **_drawn(opened, beside=beside, known=known)),
            key="hull",
            label="Hull, circumferences and cameras in 3D",
            sliders=live_sliders(),
            height_px=HEIGHT_PX,
            revision=f"{opened.id} {scope}",
            follows_camera=True,
            camera=session.choice().camera,
        )
        parameters_note()
    with right:
        own_values(estimated)
        linked_plot(
            profile_figure.parts(fit.hull, fit.dimensions, preset=preset, known=known, beside=beside),
            key="profile",
            label="Radius of the circumferences by height",
            height_px=HEIGHT_PX + SLIDERS_PX,
            revision=opened.id,
        )


def _known(opened: OpenedRecording, fit: Fit) -> KnownProfile | None:
    with guarded():
        return opened.known_profile(fit.frame or 0)
    return None


def _drawn(opened: OpenedRecording, *, beside: tuple[str, Hull] | None, known: KnownProfile | None) -> dict[str, Any]:
    """How the hull is drawn, as the visitor chose."""
    current = session.choice()
    return {
        "cameras": opened.cameras,
        "preset": current.preset,
        "scope": current.scope or "container",
        "beside": beside,
        "known": known if current.shows_errors else None,
        "has_axes": current.has_axes,
    }


def _hull_controls(known: KnownProfile | None) -> Scope:
    """Choose what is framed, whether errors are coloured, and whether there are axes."""
    scopes, errors, axes = st.columns([5, 4, 3], vertical_alignment="center")
    with scopes:
        scope = one_of("", SCOPES, key="scope", field="scope", forgets=("camera",))
    st.session_state["hull_errors"] = session.choice().shows_errors
    st.session_state["hull_axes"] = session.choice().has_axes
    errors.toggle(
        "Colour errors",
        key="hull_errors",
        on_change=lambda: session.choose(shows_errors=st.session_state["hull_errors"]),
        disabled=known is None,
        help="Each circumference's distance to the true profile of a synthetic container, or else to the annotated "
        "widths and height, in mm: red outside, blue inside."
        if known is not None
        else "Neither a true profile nor annotated sizes are known for this recording.",
    )
    axes.toggle("Axes", key="hull_axes", on_change=lambda: session.choose(has_axes=st.session_state["hull_axes"]))
    return scope


def reprojections(
    opened: OpenedRecording,
    best: BestFrame,
    fit: Fit,
    *,
    frame: int,
    shape: ShapeParameters,
    agreements: Mapping[str, Agreement],
) -> None:
    """The circumferences over both views' pictures and masks.

    Args:
        opened: the recording.
        best: the pair.
        fit: of the frame.
        frame: frame index.
        shape: parameters of the fit.
        agreements: as in ``measures.frame_problems``.
    """
    for column, view in zip(st.columns(2), best.pair, strict=True):
        with column, guarded():
            st.markdown(f"**{view}**, frame {frame}{_explained(agreements.get(view))}")
            try:
                mask, camera = opened.mask(view, frame, best.centre_rule), opened.camera(view)
            except CorsmalError as error:
                st.image(opened.picture(view, frame, best.centre_rule))
                st.caption(f"Nothing to project: {error}.")
                continue
            linked_plot(
                reprojection_figure.parts(opened.image(view, frame), mask, camera, fit.hull, parameters=shape),
                key=f"reprojection_{view}",
                label=f"Circumferences reprojected into {view}",
                height_px=460,
                revision=f"{opened.id} {frame}",
            )


def _explained(found: Agreement | None) -> str:
    return (
        ""
        if found is None
        else f": explains {100 * found.explained:.0f} % of the mask, covers {100 * found.beyond:.0f} % beyond it"
    )


def hull_pins(
    opened: OpenedRecording, fit: Fit, *, beside: tuple[str, Hull] | None, numbers: Mapping[str, str]
) -> list[Pin]:
    """The hull as it is seen, to be pinned: in a report it can be turned."""
    current = session.choice()
    figure = hull_figure(fit.hull, fit.dimensions, **_drawn(opened, beside=beside, known=_known(opened, fit)))
    figure.update_layout(chosen_camera())
    return [
        Pin(
            f"Hull of {opened.id}, {' + '.join(fit.pair)}, frame {fit.frame}, {current.shape_name}",
            figure,
            numbers=numbers,
            parameters=parameter_texts(current.shape, name=current.shape_name),
            recording=opened.id,
            frame=fit.frame,
        )
    ]
