"""Controls for the parameters of the fit."""

from dataclasses import replace
from typing import Any

import streamlit as st

from corsmal.errors import ArgumentError
from corsmal.parameters import SHAPE_PRESETS, HeightRange, ShapeMethod
from corsmal.ui import session
from corsmal.ui.linked_plot import PlotEvent, Slider
from corsmal.ui.messages import say_later, say_what_waits
from corsmal.ui.url import HEIGHT_LIMIT_MM, LIMITS

RULES = {
    "fit_rule": (
        "A circumference must fit",
        {"any": "at least one view (paper)", "all": "both views (LoDE)"},
    ),
    "width_rule": (
        "Widths and height",
        {
            "ends": "at the ends of the profile (paper)",
            "widest": "twice the largest radius (LoDE)",
            "whole": "first and last circumference (tuned)",
        },
    ),
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
SWITCHES = {"boxes": "Also fit a box, and keep what agrees better with the masks", "all_views": "Use the third view"}


def preset_control() -> None:
    """Choose a preset; it sets all parameters of the fit."""
    st.session_state["preset_control"] = session.choice().preset
    st.segmented_control(
        "Preset",
        list(SHAPE_PRESETS),
        key="preset_control",
        required=True,
        on_change=lambda: session.choose(shape=SHAPE_PRESETS[st.session_state["preset_control"]]),
        help="`paper`: the published method. `lode`: the method that it is based on. `tuned`: ours, from the masks' "
        "outlines.",
    )


def preset_button() -> None:
    """Where a parameter was changed: return to the preset."""
    current = session.choice()
    if not current.is_preset and st.button(f"Back to {current.preset}", icon=":material/undo:"):
        session.choose(shape=SHAPE_PRESETS[current.preset])
        st.rerun()


def compared_preset() -> str | None:
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


def live_sliders() -> list[Slider]:
    """The sliders that refit while they are dragged, at their present values."""
    shape = session.choice().shape
    sliders = []
    for name, label in LIVE[shape.method].items():
        limits = LIMITS[name]
        value = getattr(shape, name)
        sliders.append(Slider(name, label, limits.low, limits.high, limits.step, value, limits.unit))
    return sliders


def apply_sliders(event: PlotEvent) -> None:
    """Take over what the user dragged, within the limits; the address is written when the dragging ends."""
    shape = session.choice().shape
    values: dict[str, Any] = {}
    for name in LIVE[shape.method]:
        if name in event.values:
            limits = LIMITS[name]
            value = min(max(event.values[name], limits.low), limits.high)
            values[name] = int(value) if limits.is_whole else value
    session.choose(settled=event.settled, **({"shape": replace(shape, **values)} if values else {}))


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
            kind = int if limits.is_whole else float
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
        for name, (label, options) in RULES.items():
            st.session_state[f"shape_{name}"] = getattr(shape, name)
            text = options.__getitem__
            st.selectbox(label, list(options), key=f"shape_{name}", format_func=text, on_change=_changed, args=(name,))
        _height_range(shape.height_range)


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


def _changed(name: str) -> None:
    _try_shape(**{name: st.session_state[f"shape_{name}"]})


def _height_changed() -> None:
    parts = [st.session_state[f"shape_{part}"] for part in ("reference", "low_mm", "high_mm")]
    _try_shape(height_range=lambda: HeightRange(*parts))


def _try_shape(**changes: Any) -> None:
    """Change parameters; values that do not go together are refused with a sentence."""
    try:
        made = {name: value() if callable(value) else value for name, value in changes.items()}
        shape = replace(session.choice().shape, **made)
    except ArgumentError as error:
        say_later(f"Not possible: {error}.")
        return
    session.choose(shape=shape)
