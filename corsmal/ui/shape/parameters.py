"""Controls that pages share: the pair of views, the frame, the parameters of the fit."""

from dataclasses import replace
from typing import Any

import streamlit as st

from corsmal.dataset import Recording
from corsmal.errors import ArgumentError
from corsmal.estimation import Fit
from corsmal.figures.hull import Scope
from corsmal.parameters import PAIRS, SHAPE_PRESETS, HeightRange, ShapeMethod, ShapeParameters
from corsmal.selection import BestFrame, Pair
from corsmal.ui import data, session
from corsmal.ui.linked_plot import PlotEvent, Slider
from corsmal.ui.selecting import input_showing, take_over
from corsmal.ui.shape.measures import say_later, say_what_waits
from corsmal.ui.url import HEIGHT_LIMIT_MM, LIMITS, WHOLE

FIT_RULES = {"any": "at least one view (paper)", "all": "both views (LoDE)"}
WIDTH_RULES = {
    "ends": "at the ends of the profile (paper)",
    "widest": "twice the largest radius (LoDE)",
    "whole": "first and last circumference (tuned)",
}
REFERENCES = {"masks": "the axis' extent in the masks", "world": "the table, z = 0", "centroid": "the centroid"}
LIVE: dict[ShapeMethod, dict[str, str]] = {
    "circumferences": {"circumferences": "L, circumferences", "max_difference_mm": "d_max"},
    "outlines": {"tilt_deg": "expected tilt", "wall_mm": "wall"},
}
"""The parameters that refit while they are dragged."""
QUIET = {
    "points": "N, points per circumference",
    "radii": "Radii tried",
    "radius_max_mm": "r_max",
    "radius_min_mm": "r_min",
}
NOTHING = "nothing"
SWITCHES = {"boxes": "Fit a box too, and take what explains the masks better", "all_views": "Let the third view join"}


def pair_control(recording: Recording) -> tuple[Pair, BestFrame]:
    """Choose the pair of views; at first the one that the estimate takes.

    Returns:
        The pair and its best frame.
    """
    selections = {pair: data.best_frame(recording, pair=pair) for pair in PAIRS}
    automatic = data.estimated_pair(recording)
    key = input_showing("pair", session.choice().pair or automatic)
    st.segmented_control(
        "Pair of views",
        PAIRS,
        key=key,
        required=True,
        format_func=lambda pair: f"{pair[0]} + {pair[1]}" + ("" if selections[pair].ok else " (none)"),
        on_change=take_over,
        args=("pair", key),
        help="The method tries the frontal view with the left one first, then with the right one. (none): no frame "
        "in which both views show a container.",
    )
    pair = session.choice().pair or automatic
    return pair, selections[pair]


def frame_control(best: BestFrame, *, frames: int) -> int:
    """Choose the frame; at first the best one.

    Returns:
        The frame index.
    """
    chosen = session.choice().frame
    automatic = best.frame if best.frame is not None else 0
    frame = min(automatic if chosen is None else chosen, frames - 1)
    key = input_showing("frame", frame)
    left, right = st.columns([3, 2], vertical_alignment="bottom")
    left.number_input(
        f"Frame (0 to {frames - 1})",
        0,
        frames - 1,
        key=key,
        on_change=take_over,
        args=("frame", key),
    )
    right.button(
        f"Best: {automatic}" if best.ok else "No best frame",
        icon=":material/star:",
        disabled=frame == automatic,
        on_click=lambda: session.choose(frame=None),
        width="stretch",
    )
    return frame


def explained_frame_control(fit: Fit, *, frame: int) -> None:
    """Go to the frame of an estimate over several frames in which its hull explains the masks best."""
    st.button(
        f"Frame {fit.frame}: its masks are explained best",
        icon=":material/center_focus_strong:",
        disabled=frame == fit.frame,
        on_click=lambda: session.choose(frame=fit.frame, pair=fit.pair),
    )


def preset_control() -> None:
    """Choose a preset; it sets all parameters of the fit."""
    current = session.choice()
    st.session_state["preset_control"] = current.preset
    st.segmented_control(
        "Preset" if current.is_preset else "Preset (changed)",
        list(SHAPE_PRESETS),
        key="preset_control",
        required=True,
        on_change=_preset_chosen,
        help="`paper`: the published method. `lode`: the method that it was made from. `tuned`: ours, from the masks' "
        "outlines.",
    )
    if not current.is_preset:
        st.button(f"Back to {current.preset}", on_click=_preset_chosen, icon=":material/undo:")


def beside_control() -> str | None:
    """Choose a preset whose hull is drawn over the fitted one; at first ``tuned`` over the paper's, and the reverse."""
    automatic = "paper" if session.choice().shape.method == "outlines" else "tuned"
    names = [NOTHING, *SHAPE_PRESETS]
    name = st.selectbox(
        "Compare with",
        names,
        names.index(automatic),
        key=f"beside_{automatic}",
        help="A second hull of the same frame, drawn over the first.",
    )
    return None if name == NOTHING else name


def scope_control() -> Scope:
    """Choose what the 3D figure frames."""
    scope: Scope = st.segmented_control(
        "Show", ["container", "cameras"], default="container", key="scope", required=True, label_visibility="collapsed"
    )
    return scope


def live_sliders() -> list[Slider]:
    """The sliders that refit while they are dragged, at their present values."""
    shape = session.choice().shape
    return [
        Slider(
            name, label, LIMITS[name].low, LIMITS[name].high, LIMITS[name].step, getattr(shape, name), LIMITS[name].unit
        )
        for name, label in LIVE[shape.method].items()
    ]


def apply_sliders(event: PlotEvent) -> None:
    """Take over what the user dragged, within the limits; the address is written when the dragging ends."""
    values: dict[str, Any] = {}
    for name in LIVE[session.choice().shape.method]:
        if name in event.values:
            value = min(max(event.values[name], LIMITS[name].low), LIMITS[name].high)
            values[name] = int(value) if name in WHOLE else value
    if values:
        session.choose(shape=replace(session.choice().shape, **values), settled=event.settled)
    if event.settled:
        session.write_address()


def other_parameters() -> None:
    """The parameters that are changed seldom, in an expander."""
    say_what_waits()
    shape = session.choice().shape
    with st.expander("More parameters", icon=":material/tune:"):
        if shape.method == "outlines":
            for name, label in SWITCHES.items():
                st.session_state[f"shape_{name}"] = getattr(shape, name)
                st.toggle(label, key=f"shape_{name}", on_change=_changed, args=(name,))
            return
        for name, label in QUIET.items():
            limits = LIMITS[name]
            kind = int if name in WHOLE else float
            st.session_state[f"shape_{name}"] = kind(getattr(shape, name))
            st.slider(
                f"{label} ({limits.unit})" if limits.unit else label,
                kind(limits.low),
                kind(limits.high),
                step=kind(limits.step),
                key=f"shape_{name}",
                on_change=_changed,
                args=(name,),
            )
        _rule("fit_rule", "A circumference must fit", FIT_RULES)
        _rule("width_rule", "Widths and height", WIDTH_RULES)
        _height_range(shape.height_range)


def _rule(name: str, label: str, options: dict[str, str]) -> None:
    st.session_state[f"shape_{name}"] = getattr(session.choice().shape, name)
    st.selectbox(
        label, list(options), key=f"shape_{name}", format_func=options.__getitem__, on_change=_changed, args=(name,)
    )


def _height_range(value: HeightRange) -> None:
    for part in ("reference", "low_mm", "high_mm"):
        st.session_state[f"shape_{part}"] = getattr(value, part)
    st.selectbox(
        "Heights measured from",
        list(REFERENCES),
        key="shape_reference",
        format_func=REFERENCES.__getitem__,
        on_change=_height_changed,
    )
    left, right = st.columns(2)
    for column, part, label in ((left, "low_mm", "from (mm)"), (right, "high_mm", "to (mm)")):
        column.number_input(
            label, -HEIGHT_LIMIT_MM, HEIGHT_LIMIT_MM, step=5.0, key=f"shape_{part}", on_change=_height_changed
        )


def _preset_chosen() -> None:
    session.choose(shape=SHAPE_PRESETS[st.session_state["preset_control"]])


def _changed(name: str) -> None:
    _try_shape(**{name: st.session_state[f"shape_{name}"]})


def _height_changed() -> None:
    state = st.session_state
    try:
        value = HeightRange(state["shape_reference"], state["shape_low_mm"], state["shape_high_mm"])
    except ArgumentError as error:
        say_later(f"Not possible: {error}.")
        return
    _try_shape(height_range=value)


def _try_shape(**changes: Any) -> None:
    try:
        shape: ShapeParameters = replace(session.choice().shape, **changes)
    except ArgumentError as error:
        say_later(f"Not possible: {error}.")
        return
    session.choose(shape=shape)
