"""The Mass page's numbers: those of the fit, typed over by the user, and what the page says about that."""

from typing import TYPE_CHECKING

import streamlit as st

from corsmal.estimation import Fit
from corsmal.ui import session
from corsmal.ui.controls import TYPED, TYPED_HIGH, TYPED_LOW
from corsmal.ui.messages import plain
from corsmal.ui.opened import OpenedRecording

if TYPE_CHECKING:
    from corsmal.mass import MassPredictor

Numbers = dict[str, float | None]

FITTED, REFUSED = "mass_fitted", "mass_refused"
LABELS = {
    "width_top_mm": "top width (mm)",
    "width_bottom_mm": "bottom width (mm)",
    "height_mm": "height (mm)",
    "mm_per_px": "scale (mm per pixel)",
    "capacity_ml": "capacity (mL), for the filling",
}
INPUTS = {name: (symbol, LABELS[name]) for name, symbol in TYPED.items()}


def chosen_numbers(opened: OpenedRecording, fit: Fit, fitted: Numbers) -> Numbers:
    """The numbers as the user typed them over the fit's; those of another fit are forgotten."""
    known, is_linked = st.session_state.get(FITTED), session.is_linked("numbers")
    st.session_state[FITTED] = now = (opened.id, fit.pair, fit.frame, tuple(fitted.values()))
    if session.choice().numbers and known not in (None, now) and not is_linked:
        session.choose(settled=False, numbers=())
        session.write_address()
    return fitted | dict(session.choice().numbers)


def number_notes(numbers: Numbers, fitted: Numbers, *, network: "MassPredictor | None") -> bool:
    """Say which numbers are refused, empty or typed instead of the fit's.

    Returns:
        Whether none was emptied.
    """
    if refused := st.session_state.pop(REFUSED, None):
        st.warning(plain(refused), icon=":material/edit_off:")
    needed = [name for name in INPUTS if name != "mm_per_px" or (network is not None and network.config.with_scale)]
    emptied = [_words(name) for name in needed if numbers[name] is None and fitted[name] is not None]
    if emptied:
        st.info(
            f"Empty: {', '.join(emptied)}. What depends on it is unknown: type a number, or go *Back to the fit*.",
            icon=":material/edit:",
        )
    typed = [
        f"{_words(name)} {numbers[name]:g} (fit {'unknown' if fitted[name] is None else f'{fitted[name]:.4g}'})"
        for name in needed
        if numbers[name] is not None and numbers[name] != fitted[name]
    ]
    if typed:
        st.caption(f":material/edit: Typed instead of the fit's: {plain(', '.join(typed))}.")
    return not emptied


def number_inputs(numbers: Numbers, fitted: Numbers, *, with_scale: bool) -> None:
    """The numbers that the masses depend on, to be typed over."""
    st.markdown("**What the mass estimates depend on**")
    state = st.session_state
    for name, (symbol, label) in INPUTS.items():
        if name == "mm_per_px" and not with_scale:
            continue
        key, value = f"mass_{name}", numbers[name]
        state[key] = None if value is None else min(max(float(value), TYPED_LOW), TYPED_HIGH)
        st.number_input(
            f"{symbol}, {label}",
            value=None,
            step=0.01 if name == "mm_per_px" else 1.0,
            format="%.2f" if name == "mm_per_px" else "%.1f",
            key=key,
            placeholder="missing: the fit failed",
            on_change=_take_over,
            args=(name, key),
        )
    st.button(
        "Back to what was measured",
        icon=":material/undo:",
        disabled=numbers == fitted,
        on_click=lambda: session.choose(numbers=()),
        width="stretch",
    )


def _take_over(name: str, key: str) -> None:
    """Take over a number that was typed, or say why not."""
    state = st.session_state
    value = state[key]
    if value is not None and not TYPED_LOW <= value <= TYPED_HIGH:
        limits = f"{TYPED_LOW:g} and {TYPED_HIGH:,.0f}"
        state[REFUSED] = f"{value:g} is not used for the {_words(name)}: it must lie between {limits}."
        return
    session.choose(numbers=tuple((dict(session.choice().numbers) | {name: value}).items()))


def _words(name: str) -> str:
    """A number of ``INPUTS`` in words."""
    return INPUTS[name][1].partition(" (")[0]
