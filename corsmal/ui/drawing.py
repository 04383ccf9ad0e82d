"""What the browser has drawn of the app that it has just loaded: what may come later waits for it, for a moment."""

from dataclasses import dataclass, field
from threading import Event
from typing import Final, Literal

import streamlit as st

from corsmal.ui.routes import drawn_url

DRAWING: Final = "drawing"
AT_MOST_S: Final = {"numbers": 0.5, "rest": 1.5}
"""For how long to wait, s: until the page's numbers stand, and until the browser rests."""


@dataclass(frozen=True)
class _Drawing:
    """What a browser has said."""

    numbers: Event = field(default_factory=Event)
    rest: Event = field(default_factory=Event)


def begin() -> str | None:
    """Begin to listen to the browser, once in a session.

    Returns:
        The address that it is to call, followed by ``/numbers`` and ``/rest``; None if it was given one before.
    """
    if DRAWING in st.session_state:
        return None
    drawing = st.session_state[DRAWING] = _Drawing()
    return drawn_url({"numbers": drawing.numbers, "rest": drawing.rest})


def let_draw(part: Literal["numbers", "rest"]) -> None:
    """Let the browser draw what it was sent before more follows, which it would draw in one go, or before long work.

    Both need the cores. Nobody waits for what the browser does not say in time, or has said before.

    Args:
        part: ``numbers``: those of the page; ``rest``: all that was sent.
    """
    drawing: _Drawing | None = st.session_state.get(DRAWING)
    if drawing is not None:
        drawn: Event = getattr(drawing, part)
        drawn.wait(AT_MOST_S[part])
        drawn.set()
