"""What all pages have: one stylesheet for what Streamlit's theme has no setting for, and two scripts."""

from pathlib import Path
from typing import Final

import streamlit as st
from streamlit.delta_generator import DeltaGenerator

HERE: Final = Path(__file__).parent
STYLESHEET: Final = HERE / "look.css"
SCRIPTS: Final = "".join(
    f"<script>{(HERE / name).read_text(encoding='utf-8')}</script>" for name in ("history.js", "picker_keys.js")
)


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


def run_scripts() -> None:
    """Let a page be one step of the browser's history, and ``[`` and ``]`` step through the recordings."""
    st.html(SCRIPTS, unsafe_allow_javascript=True)
