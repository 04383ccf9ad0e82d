"""What a page says about problems, and what a callback leaves to be said."""

import re
from collections.abc import Iterator
from contextlib import contextmanager

import streamlit as st

from corsmal.errors import CorsmalError

WAITING = "message_waiting"


@contextmanager
def guarded() -> Iterator[None]:
    """Show an error of the library as its sentence, and continue with the rest of the page."""
    try:
        yield
    except CorsmalError as error:
        st.error(plain(str(error)), icon=":material/error:")


def plain(text: str) -> str:
    """Text for a place that reads Markdown: names of files and what stood in an address are shown as they are."""
    return re.sub(r"([\\`*_{}\[\]()<>#+!|$:~&-])", r"\\\1", text)


def say_later(sentence: str) -> None:
    """Leave a sentence to the page: what a callback shows itself would replace the page's first elements."""
    st.session_state[WAITING] = sentence


def say_what_waits() -> None:
    """Show the sentence that a callback left."""
    if (sentence := st.session_state.pop(WAITING, None)) is not None:
        st.toast(sentence)
