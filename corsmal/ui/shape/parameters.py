"""Controls for the parameters of the fit."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import streamlit as st

from corsmal.errors import ArgumentError
from corsmal.parameters import SHAPE_PRESETS, HeightRange, Pair, ShapeMethod, ShapeParameters, all_pairs
from corsmal.ui import session
from corsmal.ui.choice import NOTHING, SHOWN
from corsmal.ui.controls import HEIGHT_LIMIT_MM, PARAMETERS, Number, Options, Pairs
from corsmal.ui.linked_plot import PlotEvent, Slider
from corsmal.ui.url import camera_view, value_text

LIVE: dict[ShapeMethod, tuple[str, ...]] = {
    "circumferences": ("circumferences", "max_difference_mm"),
    "outlines": ("tilt_deg", "wall_mm"),
}
"""The parameters that refit while they are dragged."""
CIRCUMFERENCE_RULES = (
    "fit_rule", "width_rule", "height_rule", "angle_rule", "pixel_rule", "triangulation", "height_range",
)  # fmt: skip
QUIET: dict[ShapeMethod, tuple[str, ...]] = {
    "circumferences": ("points", "radii", "radius_max_mm", "radius_min_mm", *CIRCUMFERENCE_RULES, "pairs"),
    "outlines": ("boxes", "all_views", "triangulation", "pairs"),
}
OWN = "own_shape"


def preset_control() -> None:
    """Choose a preset; it sets all parameters of the fit."""
    st.session_state["preset_control"] = session.choice().preset
    st.segmented_control(
        "Preset",
        list(SHAPE_PRESETS),
        key="preset_control",
        required=True,
        on_change=_preset_chosen,
        help="`paper`: the published method. `released`: the authors' program. `lode`: the method that they "
        "are based on. `tuned`: ours, from the masks' outlines.",
    )


def _preset_chosen() -> None:
    if not session.choice().is_preset:
        st.session_state[OWN] = session.choice().shape
    session.choose(shape=SHAPE_PRESETS[st.session_state["preset_control"]])


def own_values(estimated: ShapeParameters) -> None:
    """Steps between a preset and one's own values, and from a frame's fit to the recording's estimate.

    Args:
        estimated: the parameters of the estimate that the page shows.
    """
    current, own = session.choice(), st.session_state.get(OWN)
    if current.shape not in (estimated, *SHAPE_PRESETS.values()) and st.button(
        "Estimate the recording with these values", icon=":material/dynamic_form:", width="stretch"
    ):
        session.choose(estimate=SHOWN)
        st.rerun()
    if not current.is_preset and st.button(f"Back to {current.preset}", icon=":material/undo:", width="stretch"):
        st.session_state[OWN] = current.shape
        session.choose(shape=SHAPE_PRESETS[current.preset])
        st.rerun()
    has_own = current.is_preset and own is not None and own != current.shape
    if has_own and st.button("Back to my values", icon=":material/redo:", width="stretch"):
        session.choose(shape=own)
        st.rerun()


def parameters_note() -> None:
    """Which parameters the chosen preset has, and which belong to others."""
    method = session.choice().shape.method
    ours, others = (
        ", ".join(f"*{PARAMETERS[name].label}*" for name in (*LIVE[each], *QUIET[each]))
        for each in (method, *(other for other in LIVE if other != method))
    )
    names = [name for name, preset in SHAPE_PRESETS.items() if preset.method != method]
    st.caption(f"Parameters of `{session.choice().preset}`: {ours}. Only of {' and '.join(names)}: {others}.")


def chosen_camera() -> dict[str, Any]:
    """The layout of a figure in 3D that is seen as the user turned it; empty as it is at first."""
    camera = session.choice().camera
    if camera is None:
        return {}
    eye, centre = (dict(zip("xyz", camera[start : start + 3], strict=True)) for start in (0, 3))
    return {"scene": {"camera": {"eye": eye, "center": centre}}}


def parameter_texts(shape: ShapeParameters, *, name: str) -> dict[str, str]:
    """The parameters of a fit in words, those that do something only.

    Args:
        shape: the parameters.
        name: of them, for people.
    """
    used = {field: PARAMETERS[field] for field in (*LIVE[shape.method], *QUIET[shape.method])}
    texts = {
        each.label: f"{value_text(getattr(shape, field))} {getattr(each, 'unit', '')}".strip()
        for field, each in used.items()
    }
    return {"preset": name, **texts}


def compared_preset() -> str | None:
    """Choose a preset whose hull is drawn over the fitted one; at first ``tuned`` over the paper's, and the reverse."""
    automatic = "paper" if session.choice().shape.method == "outlines" else "tuned"
    key, shown = f"beside_{automatic}", session.choice().compared or automatic
    st.session_state[key] = shown
    st.selectbox(
        "Compare with",
        [NOTHING, *SHAPE_PRESETS],
        key=key,
        on_change=lambda: session.choose(compared=st.session_state[key]),
        help="A second hull of the same frame, drawn over the first.",
    )
    return None if shown == NOTHING else shown


def live_sliders() -> list[Slider]:
    """The sliders that refit while they are dragged, at their present values."""
    shape = session.choice().shape
    return [
        Slider(name, number.label, number.low, number.high, number.step, getattr(shape, name), number.unit)
        for name, number in _live_numbers()
    ]


def apply_sliders(event: PlotEvent) -> None:
    """Take over what the user dragged or turned, within the limits; the address is written when the dragging ends."""
    values: dict[str, Any] = {
        name: number.kind(min(max(event.values[name], number.low), number.high))
        for name, number in _live_numbers()
        if name in event.values
    }
    changes: dict[str, Any] = {"shape": replace(session.choice().shape, **values)} if values else {}
    session.choose(settled=event.settled, **changes | turned(event))


def turned(event: PlotEvent) -> dict[str, Any]:
    """What changes of the choice when the user turned the hull in 3D."""
    return {} if event.camera is None else {"camera": camera_view(event.camera)}


def _live_numbers() -> list[tuple[str, Number]]:
    parameters = [(name, PARAMETERS[name]) for name in LIVE[session.choice().shape.method]]
    return [(name, number) for name, number in parameters if isinstance(number, Number)]


def other_parameters() -> None:
    """The parameters that are changed seldom, in an expander."""
    shape, state = session.choice().shape, st.session_state
    with st.expander("More parameters", icon=":material/tune:"):
        for name in QUIET[shape.method]:
            parameter, key = PARAMETERS[name], f"shape_{name}"
            state[key] = getattr(shape, name)
            follow: dict[str, Any] = {"key": key, "on_change": _changed, "args": (name, partial(state.get, key))}
            if name == "height_range":
                _height_range(shape.height_range)
            elif isinstance(parameter, Number):
                label = f"{parameter.label} ({parameter.unit})" if parameter.unit else parameter.label
                st.slider(label, parameter.low, parameter.high, step=parameter.step, **follow)
            elif isinstance(parameter, Pairs):
                _pairs(shape.pairs, parameter.label)
            elif isinstance(parameter, Options):
                names = parameter.options
                st.selectbox(parameter.label, list(names), format_func=names.__getitem__, **follow)
            else:
                st.toggle(parameter.label, **follow)


def _pairs(value: tuple[Pair, ...], label: str) -> None:
    st.session_state["shape_pairs"] = list(value)
    st.multiselect(
        label,
        all_pairs(value),
        key="shape_pairs",
        format_func=" + ".join,
        on_change=_changed,
        args=("pairs", lambda: tuple(st.session_state["shape_pairs"])),
        help="Of the estimate over the whole recording. The next pair is tried where one gives no fit.",
    )


def _height_range(value: HeightRange) -> None:
    keys = {part: f"shape_{part}" for part in ("reference", "low_mm", "high_mm")}
    for part, key in keys.items():
        st.session_state[key] = getattr(value, part)
    made = lambda: HeightRange(*(st.session_state[key] for key in keys.values()))  # noqa: E731
    follow: dict[str, Any] = {"on_change": _changed, "args": ("height_range", made)}
    rule, limit = PARAMETERS["height_range"], HEIGHT_LIMIT_MM
    if isinstance(rule, Options):
        names = rule.options
        st.selectbox(rule.label, list(names), format_func=names.__getitem__, key=keys["reference"], **follow)
    left, right = st.columns(2)
    left.number_input("from (mm)", -limit, limit, step=5.0, key=keys["low_mm"], **follow)
    right.number_input("to (mm)", -limit, limit, step=5.0, key=keys["high_mm"], **follow)


def _changed(name: str, made: Callable[[], Any]) -> None:
    """Change a parameter; a value that does not go with the others is refused with a sentence."""
    try:
        session.choose(shape=replace(session.choice().shape, **{name: made()}))
    except ArgumentError as error:
        st.toast(f"Not possible: {error}.")
