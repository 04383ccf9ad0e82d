"""What all pages have: one stylesheet for what Streamlit's theme has no setting for, and the keys of the picker."""

from pathlib import Path
from typing import Final

import streamlit as st
from streamlit.delta_generator import DeltaGenerator

HERE: Final = Path(__file__).parent
STYLESHEET: Final = HERE / "look.css"
PICKER_KEYS: Final = f"<script>{(HERE / 'picker_keys.js').read_text(encoding='utf-8')}</script>"


def heading(title: str) -> DeltaGenerator:
    """A page's title.

    Returns:
        Where the page's own controls go: beside the title.
    """
    left, controls = st.columns([1, 4])
    left.title(title)
    return controls


def apply() -> None:
    """Apply the stylesheet; it takes no place on the page."""
    st.html(STYLESHEET)


def picker_keys() -> None:
    """Let ``[`` and ``]`` press the buttons that step through the recordings."""
    st.html(PICKER_KEYS, unsafe_allow_javascript=True)
