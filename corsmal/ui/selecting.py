"""Inputs whose values the app itself also changes, while a search goes on or when the user steps back."""

import streamlit as st

from corsmal.ui import session


def input_showing(name: str, value: object) -> str:
    """The key for an input that shows a value: a new one whenever something else than the input changed the value.

    What the browser sends under an older key is what it showed a moment ago, not what the user chose.

    Args:
        name: the field of ``Choice`` that the input is for.
        value: what it is to show.
    """
    key, _ = st.session_state.get(f"{name}_shown", (f"{name}_control.0", None))
    if st.session_state.get(key) != value:
        key = f"{name}_control.{int(key.rpartition('.')[2]) + 1}"
        st.session_state[key] = value
    st.session_state[f"{name}_shown"] = key, value
    return key


def take_over(name: str, key: str) -> None:
    """Take over what an input was set to; its value also arrives after the input is gone.

    Args:
        name: as given to ``input_showing``.
        key: that it returned.
    """
    shown_key, shown = st.session_state[f"{name}_shown"]
    if key == shown_key and st.session_state[key] != shown:
        session.choose(**{name: st.session_state[key]})
