"""The microphone that is drawn and played: one choice for all pages."""

import streamlit as st
from streamlit.delta_generator import DeltaGenerator

from corsmal.dataset.audio import CHANNELS
from corsmal.ui import media, session

CONTROL, ALL = "channel_control", -1


def microphone_control(place: DeltaGenerator, label: str, *, help_text: str | None = None) -> int | None:
    """Choose the microphone, or the mean of all.

    Args:
        place: where the control stands.
        label: of the control.
        help_text: what its question mark says.
    """
    channel = session.choice().channel
    st.session_state[CONTROL] = ALL if channel is None else channel
    place.selectbox(
        label,
        [ALL, *range(CHANNELS)],
        key=CONTROL,
        format_func=lambda number: media.channel_name(None if number == ALL else number),
        on_change=_chosen,
        help=help_text,
    )
    return channel


def _chosen() -> None:
    number = st.session_state[CONTROL]
    session.choose(channel=None if number == ALL else number)
