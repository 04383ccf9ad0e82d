"""Where the numbers stand on the page, and the links from what is shown to the pages that explain it."""

from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import streamlit as st

from corsmal.estimation import Estimate
from corsmal.ui import drawing, session
from corsmal.ui.linked_plot.assets import read_asset
from corsmal.ui.linked_plot.component import acknowledged, fresh_report, no_callback
from corsmal.ui.overview.numbers import PENDING, Tile

ICONS = {
    "frames": ":material/center_focus_strong:",
    "shape": ":material/deployed_code:",
    "filling": ":material/graphic_eq:",
    "mass": ":material/scale:",
}
HELP = "Open the {page} page with this recording, frame and preset."
KEYS = tuple(f"tiles_{known}" for known in range(len(PENDING) + 1))
"""By how many numbers are known: a run of the page draws an element of a key once."""

HERE: Final = Path(__file__).parent

_component = st.components.v2.component(
    "corsmal.tiles",
    css=read_asset("tiles.css", folder=HERE),
    js=read_asset("reports.js") + read_asset("tiles.js", folder=HERE),
    isolate_styles=False,
)


class Tiles:
    """All numbers side by side; each is filled in when it is known."""

    def __init__(self) -> None:
        self.shown: dict[str, Tile] = {}
        self._opens = next((report["opens"] for key in KEYS if "opens" in (report := fresh_report(key))), None)
        self._place = st.empty()

    def show_pending(self) -> None:
        """Say of all numbers that they are being computed, where that takes a moment; drawing it does, too."""
        self._draw()

    def show(self, tiles: Iterable[Tile], found: Estimate) -> None:
        """Fill in numbers of an estimate, and follow the link of one of them if that was pressed."""
        self.shown |= {tile.label: tile for tile in tiles}
        self._draw()
        if self._opens in self.shown:
            _open_page(self.shown[self._opens].page, found)

    def _draw(self) -> None:
        key = KEYS[len(self.shown)]
        tiles = [_sent(self.shown.get(tile.label, tile), is_known=tile.label in self.shown) for tile in PENDING]
        drawn_url = drawing.begin() if len(self.shown) == len(PENDING) else None
        data = {"tiles": tiles, "acknowledged": acknowledged(key), "drawn_url": drawn_url}
        with self._place:
            _component(key=key, data=data, on_report_change=no_callback)


def _sent(tile: Tile, *, is_known: bool) -> dict[str, Any]:
    """A number as the browser draws it: it leads to its page once it is known."""
    if not is_known:
        return asdict(tile) | {"icon": "", "help": ""}
    icon = ICONS[tile.page].removeprefix(":material/").removesuffix(":")
    return asdict(tile) | {"icon": icon, "help": HELP.format(page=tile.page.capitalize())}


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
        help=HELP.format(page=f"*{page.capitalize()}*"),
    )
    if opens:
        _open_page(page, found)


def _open_page(page: str, found: Estimate | None) -> None:
    fit = None if found is None else found.fit
    session.open_page(
        page,
        shape=session.choice().estimated_shape,
        frame=None if fit is None else fit.frame,
        pair=None if fit is None else fit.pair,
        crop_s=None,
    )
