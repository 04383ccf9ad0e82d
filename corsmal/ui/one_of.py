"""A control with several options, of which one is always chosen."""

from collections.abc import Mapping
from typing import TypeVar

import streamlit as st

Option = TypeVar("Option", bound=str)


def one_of(
    label: str, options: Mapping[Option, str], *, key: str, default: Option | None = None, help_text: str | None = None
) -> Option:
    """Choose one of several options that lie side by side; the choice is kept while other pages are shown.

    Args:
        label: of the control; hidden where it is empty.
        options: their labels.
        key: of the control.
        default: chosen at first, and where the earlier choice is no option; default: the first one.
        help_text: what its question mark says.
    """
    if st.session_state.get(key) not in options:
        st.session_state[key] = default or next(iter(options))
    st.segmented_control(
        label or key,
        list(options),
        key=key,
        required=True,
        format_func=options.__getitem__,
        label_visibility="visible" if label else "collapsed",
        help=help_text,
        persist_state="session",
    )
    chosen: Option = st.session_state[key]
    return chosen
