"""The pair of views that pages are about."""

from collections.abc import Sequence
from typing import Any

import streamlit as st
from streamlit.runtime.scriptrunner import get_script_run_ctx

from corsmal.estimation import Estimate
from corsmal.parameters import Pair, ShapeParameters, all_pairs
from corsmal.selection import BestFrame
from corsmal.ui import session
from corsmal.ui.opened import OpenedRecording


def pair_control(
    opened: OpenedRecording, found: Estimate, shape: ShapeParameters, *, is_narrow: bool = False
) -> BestFrame:
    """Choose the pair of views; at first the one that the estimate takes.

    Args:
        opened: the recording.
        found: an estimate over the recording.
        shape: its parameters.
        is_narrow: whether the control is a list that opens, for pages with many controls.

    Returns:
        The best frame of the pair: where the estimate took the pair, the frame that it took.
    """
    pairs = all_pairs(shape.pairs)
    selections = {pair: opened.best_frame(pair, shape) for pair in pairs}
    if found.best_frame is not None:
        selections[found.best_frame.pair] = found.best_frame
    pair = _among(pairs, session.choice().pair or (pairs[0] if found.best_frame is None else found.best_frame.pair))
    key = _key_showing("pair", pair)
    follow: dict[str, Any] = {"key": key, "on_change": _take_over, "args": ("pair", key)}
    follow["help"] = (
        f"The estimate tries {', then '.join(map(' + '.join, shape.pairs))}. (none): no frame in which both views show "
        "a container."
    )
    none = {pair: "" if selections[pair].ok else " (none)" for pair in pairs}
    if is_narrow:
        st.selectbox(
            "Pair of views", pairs, format_func=lambda pair: f"{pair[0]} + {pair[1][-1]}{none[pair]}", **follow
        )
    else:
        names = {pair: f"{pair[0]} + {pair[1]}{none[pair]}" for pair in pairs}
        st.segmented_control("Pair of views", pairs, required=True, format_func=names.__getitem__, **follow)
    return selections[_among(pairs, session.choice().pair or pair)]


def _among(pairs: Sequence[Pair], wanted: Pair) -> Pair:
    """The one of all pairs that has the wanted views."""
    return next(pair for pair in pairs if set(pair) == set(wanted))


def chosen_best(opened: OpenedRecording) -> BestFrame:
    """The best frame of the chosen pair; where none is chosen, of the first pair that has one, without an estimate."""
    pair, shape = session.choice().pair, session.choice().estimated_shape
    wanted = shape.pairs if pair is None else [_among(all_pairs(shape.pairs), pair)]
    found = [opened.best_frame(each, shape) for each in wanted]
    return next((best for best in found if best.ok), found[0])


def _key_showing(name: str, value: object) -> str:
    """The key for an input that shows a value: a new one on each page, and when something else changed the value.

    What the browser sends under an older key is what it showed a moment ago, not what the user chose.

    Args:
        name: the field of ``Choice`` that the input is for.
        value: what it is to show.
    """
    context = get_script_run_ctx()
    page = "" if context is None else context.page_script_hash
    key, _, shown_on = st.session_state.get(f"{name}_shown", (f"{name}_control.0", None, page))
    if st.session_state.get(key) != value or page != shown_on:
        key = f"{name}_control.{int(key.rpartition('.')[2]) + 1}"
        st.session_state[key] = value
    st.session_state[f"{name}_shown"] = key, value, page
    return key


def _take_over(name: str, key: str) -> None:
    """Take over what an input was set to; its value also arrives after the input is gone."""
    shown_key, shown, _ = st.session_state[f"{name}_shown"]
    if key == shown_key and st.session_state[key] != shown:
        session.choose(**{name: st.session_state[key]})
