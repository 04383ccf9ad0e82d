"""Buttons that copy the address of the page, with all that is chosen."""

from pathlib import Path
from typing import Final

import streamlit as st

from corsmal.ui.linked_plot.assets import read_asset

HERE: Final = Path(__file__).parent

_component = st.components.v2.component(
    "corsmal.copy_link",
    css=read_asset("copy_link.css", folder=HERE),
    js=read_asset("copy_link.js", folder=HERE),
    isolate_styles=False,
)


def copy_link(label: str, *, key: str, has_pins: bool = False) -> None:
    """A button that copies the page's address as it is when the button is pressed.

    Args:
        label: of the button.
        key: of the button.
        has_pins: whether the link opens the visitor's collection of pins; without it whoever opens the link gets a
            collection of their own.
    """
    _component(key=key, data={"label": label, "has_pins": has_pins})
