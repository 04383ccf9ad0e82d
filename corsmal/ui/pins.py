"""Views that were pinned for the report: kept for the session, shown and removed on the Evaluation page."""

from collections.abc import Callable

import streamlit as st

from corsmal.errors import CorsmalError
from corsmal.figures.pins import Pin
from corsmal.ui.messages import plain

KEY = "pins"


def pins() -> list[Pin]:
    """What this session has pinned, in order."""
    found: list[Pin] = st.session_state.setdefault(KEY, [])
    return found


def pin_button(label: str, make: Callable[[], list[Pin]], *, key: str) -> None:
    """A button that pins what a page shows for the report.

    Args:
        label: what is pinned.
        make: called when the button is pressed.
        key: of the button, one per place.
    """
    st.button(
        f"Pin {label}",
        key=f"pin_{key}",
        icon=":material/push_pin:",
        help="Goes into the report that the Evaluation page makes.",
        on_click=_pin,  # first of all, whatever else makes the page run again in the meantime
        args=(make,),
    )


def _pin(make: Callable[[], list[Pin]]) -> None:
    try:
        made = make()
    except CorsmalError as error:
        st.toast(plain(str(error)))
        return
    pins().extend(made)
    st.toast(f"Pinned: {plain('; '.join(pin.title for pin in made))}")
