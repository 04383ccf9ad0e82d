"""A control with several options, of which one is always chosen."""

from collections.abc import Mapping
from functools import partial
from typing import Any, TypeVar

import streamlit as st

from corsmal.ui import session

Option = TypeVar("Option", bound=str)


def one_of(
    label: str,
    options: Mapping[Option, str],
    *,
    key: str,
    default: Option | None = None,
    help_text: str | None = None,
    field: str | None = None,
    forgets: tuple[str, ...] = (),
) -> Option:
    """Choose one of several options that lie side by side; the choice is kept while other pages are shown.

    Args:
        label: of the control; hidden where it is empty.
        options: their labels.
        key: of the control.
        default: chosen at first, and where the earlier choice is no option; default: the first one.
        help_text: what its question mark says.
        field: of ``Choice``, where the address is to say what is chosen; None where the default is.
        forgets: other fields of ``Choice`` that are unset with it.
    """
    first = default or next(iter(options))
    if field is not None:
        session.keep_among(field, options)
        chosen = getattr(session.choice(), field)
        st.session_state[key] = chosen if chosen in options else first
    elif st.session_state.get(key) not in options:
        st.session_state[key] = first
    st.segmented_control(
        label or key,
        list(options),
        key=key,
        required=True,
        format_func=options.__getitem__,
        label_visibility="visible" if label else "collapsed",
        help=help_text,
        persist_state="session",
        on_change="rerun" if field is None else partial(_take_over, field, key, first, forgets),
    )
    shown: Option = st.session_state[key]
    return shown


def _take_over(field: str, key: str, first: str, forgets: tuple[str, ...]) -> None:
    chosen = st.session_state[key]
    changes: dict[str, Any] = {**dict.fromkeys(forgets), field: None if chosen == first else chosen}
    session.choose(**changes)
