"""Where the numbers stand on the page, and the links from what is shown to the pages that explain it."""

from collections.abc import Iterable

import streamlit as st
from streamlit.delta_generator import DeltaGenerator

from corsmal.estimation import Estimate
from corsmal.ui import session
from corsmal.ui.messages import plain
from corsmal.ui.overview.numbers import PENDING, Tile

ICONS = {
    "frames": ":material/center_focus_strong:",
    "shape": ":material/deployed_code:",
    "filling": ":material/graphic_eq:",
    "mass": ":material/scale:",
}
PER_ROW = 4


class Tiles:
    """All numbers side by side; each is filled in when it is known."""

    def __init__(self) -> None:
        columns = [
            column
            for first in range(0, len(PENDING), PER_ROW)
            for column in st.columns(len(PENDING[first : first + PER_ROW]), gap="small")
        ]
        self.shown: dict[str, Tile] = {}
        self._slots: dict[str, DeltaGenerator] = {
            tile.label: column.empty() for tile, column in zip(PENDING, columns, strict=True)
        }

    def show_pending(self) -> None:
        """Say of all numbers that they are being computed, where that takes a moment; drawing it does, too."""
        for tile in PENDING:
            with self._slots[tile.label].container(border=True, gap=None, height="stretch"):
                st.button(tile.label, key=f"pending {tile.label}", type="tertiary", disabled=True)
                _number(tile)

    def show(self, tiles: Iterable[Tile], found: Estimate) -> None:
        """Fill in numbers of an estimate."""
        for tile in tiles:
            self.shown[tile.label] = tile
            with self._slots[tile.label].container(border=True, gap=None, height="stretch"):
                page_link(tile.label, tile.page, found)
                _number(tile)


def _number(tile: Tile) -> None:
    st.metric(
        tile.label,
        tile.value,
        tile.interval or None,
        label_visibility="collapsed",
        delta_color="off",
        delta_arrow="off",
    )
    st.caption(plain(tile.verdict) or "&nbsp;")


def page_link(label: str, page: str, found: Estimate | None) -> None:
    """A link to a page, at the frame and pair that an estimate is from and with its parameters.

    Args:
        label: what is explained there.
        page: its file's name.
        found: the estimate; without a fit the page opens at its own best frame.
    """
    opens = st.button(
        label,
        key=f"open {page} {label}",
        type="tertiary",
        icon=ICONS[page],
        help=f"Open the *{page.capitalize()}* page with this recording, frame and preset.",
    )
    if opens:
        fit = None if found is None else found.fit
        session.choose(
            shape=session.choice().estimated_shape,
            frame=None if fit is None else fit.frame,
            pair=None if fit is None else fit.pair,
            crop_s=None,
        )
        st.switch_page(f"pages/{page}.py")
