"""Buttons that download what a page shows."""

from collections.abc import Callable, Mapping

import streamlit as st


def download_buttons(files: Mapping[str, tuple[str, Callable[[], bytes] | None]]) -> None:
    """Buttons side by side; a file is made when its button is pressed.

    Args:
        files: by label, a file's name and what makes its content; None where there is nothing to download.
    """
    for column, (label, (name, make)) in zip(st.columns(len(files)), files.items(), strict=True):
        column.download_button(
            label,
            make or b"",
            name,
            key=f"download {name}",
            icon=":material/download:",
            on_click="ignore",
            disabled=make is None,
            width="stretch",
        )
