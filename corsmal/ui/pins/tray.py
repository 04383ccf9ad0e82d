"""The tray in the sidebar of every page: the open collection's pins in order, with their notes."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

import streamlit as st

from corsmal.errors import ArgumentError, CorsmalError
from corsmal.figures.pin_collections import (
    FIGURE,
    NAME_MAX,
    NOTE_MAX,
    Collection,
    KeptPin,
    change_collection,
    load_collection,
    name_collection,
)
from corsmal.ui import session, shared
from corsmal.ui.base_path import with_base
from corsmal.ui.copy_link import copy_link
from corsmal.ui.folders import check_may_change, is_read_only
from corsmal.ui.linked_plot.assets import read_asset
from corsmal.ui.linked_plot.component import acknowledged, fresh_report, no_callback
from corsmal.ui.messages import guarded, plain
from corsmal.ui.pins.pinning import OWN, OWNED, SAID, collection, fingerprint, named_collections

KINDS = {FIGURE: "figure", "image/jpeg": "picture", "image/png": "picture", "audio/wav": "sound"}
NO_PINS = {
    False: "Nothing is pinned yet: the pages have a *Pin* button under what they show.",
    True: "No pins are open. Guests can open the collections that are listed here, and those whose links they have.",
}
LIST, OPEN, NAME = "pin_list", "pins_open", "pins_name"
ACTIONS_MAX = 100
HERE = Path(__file__).parent

_component = st.components.v2.component(
    "corsmal.pin_list",
    css=read_asset("pin_list.css", folder=HERE),
    js=read_asset("reports.js") + read_asset("pin_list.js", folder=HERE),
    isolate_styles=False,
)


@st.fragment
@guarded()
def tray() -> None:
    """Show the tray, and take over what the visitor did in it."""
    _take_over(fresh_report(LIST))
    shown, is_begun = collection(), session.choice().collection is not None
    if said := st.session_state.pop(SAID, None):
        st.toast(said)
    with st.popover(f"Pins ({len(shown.pins)})", icon=":material/push_pin:", width="stretch", key="pins_tray"):
        _collection_control(shown if is_begun else None)
        if not shown.pins and not shown.removed:
            st.caption(NO_PINS[is_read_only()])
        else:
            _pin_list(shown)
        if shown.pins:
            copy_link("Copy a link to these pins", key="copy_pins", has_pins=True)


def _collection_control(shown: Collection | None) -> None:
    """Open another collection, and give the own one a name."""
    names, state = named_collections(), st.session_state
    others = [*state.get(OWNED, ()), *([] if shown is None else [shown.name])]
    state[OPEN] = None if shown is None else shown.name
    st.selectbox(
        "Collection",
        [*names, *(name for name in dict.fromkeys(others) if name not in names)],
        key=OPEN,
        format_func=lambda name: f"{name} (not named yet)" if name.startswith(OWN) else name,
        placeholder="none yet",
        on_change=_open,
        accept_new_options=not is_read_only(),
        help="Pins are kept on this server for this dataset; whoever has the name of a collection can change it. Type "
        "a new name to begin an empty one. A collection that is not named yet is found only by its address.",
    )
    if shown is not None and shown.pins and not shown.is_named and not is_read_only():
        st.text_input(
            "Name this collection",
            key=NAME,
            max_chars=NAME_MAX,
            placeholder="such as: meeting in May",
            on_change=_name,
            help="By its name it is found again.",
        )


def _open() -> None:
    """Open the collection that was chosen, or begin one of the name that was typed."""
    name = str(st.session_state[OPEN] or "").strip()
    with _saying():
        if name and not load_collection(name, dataset=fingerprint(), store=shared.store()).pins:
            check_may_change()
            change_collection(name, _named, dataset=fingerprint(), store=shared.store())
        session.choose(collection=name or None)


def _named(found: Collection) -> Collection:
    return replace(found, is_named=not found.name.startswith(OWN))


def _name() -> None:
    """Give the open collection the name that was typed."""
    name, old = str(st.session_state[NAME]).strip(), session.choice().collection
    with _saying():
        check_may_change()
        if name and old:
            name_collection(old, name, dataset=fingerprint(), store=shared.store())
            session.choose(collection=name)
            st.session_state[OWNED] = [each for each in st.session_state.get(OWNED, ()) if each != old]


@contextmanager
def _saying() -> Iterator[None]:
    """Say in the next run why something was refused."""
    try:
        yield
    except CorsmalError as error:
        st.session_state[SAID] = plain(str(error))


def _pin_list(shown: Collection) -> None:
    _component(
        key=LIST,
        data={
            "pins": [_listed(pin, shown.name) for pin in shown.pins],
            "removed": shown.removed[-1][1].title if shown.removed else None,
            "can_change": not is_read_only(),
            "note_max": NOTE_MAX,
            "acknowledged": acknowledged(LIST),
        },
        on_report_change=no_callback,
    )


def _listed(pin: KeptPin, collection_name: str) -> dict[str, Any]:
    """A pin as the browser shows it."""
    facts, kind = pin.facts, KINDS[pin.kind]
    numbers = [f"{label} {value}" for label, value in facts["numbers"].items()]
    return {
        "id": pin.id,
        "title": pin.title,
        "note": pin.note,
        "kind": kind,
        "detail": [*([f"run {facts['run']}"] if facts["run"] else []), *numbers],
        "link": f"{with_base('/')}{facts['link']}&pins={quote(collection_name)}" if facts["link"] else None,
    }


def _take_over(report: Mapping[str, Any]) -> None:
    """Change the open collection as the visitor did; what cannot be read is refused."""
    actions = report.get("actions") or []
    if not isinstance(actions, list) or not all(isinstance(each, dict) for each in actions):
        raise ArgumentError("the tray of pins sent a report that cannot be read; reload the page")
    name = session.choice().collection
    if not actions or name is None:
        return
    check_may_change()

    def change(found: Collection) -> Collection:
        for action in actions[:ACTIONS_MAX]:
            found = _changed(found, action)
        return found

    change_collection(name, change, dataset=fingerprint(), store=shared.store())


def _changed(found: Collection, action: Mapping[str, Any]) -> Collection:
    """A collection after one thing that the visitor did."""
    what, pin, order = action.get("do"), str(action.get("id")), action.get("order")
    if what == "order" and isinstance(order, list):
        return found.ordered([str(each) for each in order])
    if what == "note":
        return found.noted(pin, str(action.get("text") or ""))
    if what == "remove":
        return found.without(pin)
    if what == "restore":
        return found.restored()
    raise ArgumentError("the tray of pins sent something that cannot be read; reload the page")
