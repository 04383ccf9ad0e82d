"""What a page says about problems."""

import re
from collections.abc import Iterator
from contextlib import contextmanager

import streamlit as st

from corsmal.errors import CorsmalError, NotFoundError


@contextmanager
def guarded() -> Iterator[None]:
    """Show an error of the library as its sentence, and continue with the rest of the page."""
    try:
        yield
    except CorsmalError as error:
        show_problem(error)


def show_problem(error: CorsmalError, *, before: str = "") -> None:
    """Show an error of the library as its sentence: what is merely absent is not an error, and not red.

    Args:
        error: the error.
        before: a sentence that stands before it.
    """
    show, icon = (st.info, "search_off") if isinstance(error, NotFoundError) else (st.error, "error")
    show(before + plain(str(error)), icon=f":material/{icon}:")


_ADDRESS = re.compile(r"(?<=\bwww)(?=\.)|(?<=:)(?=//(?!download\.pytorch\.org/))", re.IGNORECASE)
"""Where text is taken for an address and shown as a link, whatever is escaped in it; weights' own may be one."""

WORD_JOINER = "\u2060"
"""A sign that is not seen and parts nothing."""


def plain(text: str) -> str:
    """Text for a place that reads Markdown: names of files and what stood in an address are shown as they are."""
    return re.sub(r"([\\`*_{}\[\]()<>#+!|$:~&-])", r"\\\1", _ADDRESS.sub(WORD_JOINER, text))
