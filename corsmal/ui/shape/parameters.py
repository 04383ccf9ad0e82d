"""Controls for the parameters of the fit."""

from dataclasses import replace
from typing import Any

import streamlit as st

from corsmal.errors import ArgumentError
from corsmal.parameters import SHAPE_PRESETS, HeightRange, ShapeMethod
from corsmal.ui import session
from corsmal.ui.linked_plot import PlotEvent, Slider
from corsmal.ui.messages import say_later, say_what_waits
from corsmal.ui.url import HEIGHT_LIMIT_MM, PARAMETERS, Number, Options

LIVE: dict[ShapeMethod, tuple[str, ...]] = {
    "circumferences": ("circumferences", "max_difference_mm"),
    "outlines": ("tilt_deg", "wall_mm"),
}
"""The parameters that refit while they are dragged."""
QUIET: dict[ShapeMethod, tuple[str, ...]] = {
    "circumferences": ("points", "radii", "radius_max_mm", "radius_min_mm", "fit_rule", "width_rule", "height_range"),
    "outlines": ("boxes", "all_views"),
}
NOTHING = "nothing"


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
    return [
        Slider(name, number.label, number.low, number.high, number.step, getattr(shape, name), number.unit)
        for name, number in _live_numbers()
    ]


def apply_sliders(event: PlotEvent) -> None:
    """Take over what the user dragged, within the limits; the address is written when the dragging ends."""
    values: dict[str, Any] = {
        name: number.kind(min(max(event.values[name], number.low), number.high))
        for name, number in _live_numbers()
        if name in event.values
    }
    session.choose(settled=event.settled, **({"shape": replace(session.choice().shape, **values)} if values else {}))


def _live_numbers() -> list[tuple[str, Number]]:
    parameters = [(name, PARAMETERS[name]) for name in LIVE[session.choice().shape.method]]
    return [(name, number) for name, number in parameters if isinstance(number, Number)]


def other_parameters() -> None:
    """The parameters that are changed seldom, in an expander."""
    say_what_waits()
    shape, state = session.choice().shape, st.session_state
    with st.expander("More parameters", icon=":material/tune:"):
        for name in QUIET[shape.method]:
            parameter, key = PARAMETERS[name], f"shape_{name}"
            if name == "height_range":
                _height_range(shape.height_range)
                continue
            state[key] = getattr(shape, name)
            follow: dict[str, Any] = {"key": key, "on_change": _changed, "args": (name,)}
            if isinstance(parameter, Number):
                label = f"{parameter.label} ({parameter.unit})" if parameter.unit else parameter.label
                st.slider(label, parameter.low, parameter.high, step=parameter.step, **follow)
            elif isinstance(parameter, Options):
                names = parameter.options
                st.selectbox(parameter.label, list(names), format_func=names.__getitem__, **follow)
            else:
                st.toggle(parameter.label, **follow)


def _height_range(value: HeightRange) -> None:
    for part in ("reference", "low_mm", "high_mm"):
        st.session_state[f"shape_{part}"] = getattr(value, part)
    rule, limit = PARAMETERS["height_range"], HEIGHT_LIMIT_MM
    if isinstance(rule, Options):
        names = rule.options
        st.selectbox(
            rule.label, list(names), key="shape_reference", format_func=names.__getitem__, on_change=_height_changed
        )
    for column, part, label in zip(st.columns(2), ("low_mm", "high_mm"), ("from (mm)", "to (mm)"), strict=True):
        column.number_input(label, -limit, limit, step=5.0, key=f"shape_{part}", on_change=_height_changed)


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
