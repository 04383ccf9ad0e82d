"""The collection of pins that a visitor has open, and the buttons that pin what a page shows."""

import secrets
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import streamlit as st

from corsmal.dataset import Dataset
from corsmal.errors import CorsmalError
from corsmal.figures.pin_collections import KIND, Collection, add_pins, list_collections, load_collection
from corsmal.figures.pins import Pin
from corsmal.runs.run import list_runs, named_run
from corsmal.ui import session, shared
from corsmal.ui.caching import cached
from corsmal.ui.folders import check_may_change, is_read_only
from corsmal.ui.messages import plain

SAID = "pins_said"
"""What the tray is to say in the next run."""

OWN = "pins-"
"""How the name of a visitor's own collection begins, until it gets another one."""

OWNED = "pins_owned"
"""The names of the collections that this session began, which are not listed for others."""


def collection() -> Collection:
    """The open collection of the open dataset; an empty one before the visitor has pinned anything.

    Raises:
        ArgumentError: the address names one as none can be named.
    """
    name = session.choice().collection
    return load_collection(name or OWN, dataset=fingerprint(), store=shared.store())


def fingerprint() -> str:
    """Of the open dataset, under which its pins are kept."""
    found: Dataset | None = st.session_state.get(session.DATASET)
    return "" if found is None else found.fingerprint


def named_collections() -> list[str]:
    """The names of the collections on the open dataset that people named."""
    store, times = shared.store(), []
    for key in store.keys(KIND):
        with suppress(FileNotFoundError):  # renamed by another session
            times.append((key, store.file(KIND, key, ".json").stat().st_mtime_ns))
    return _named(fingerprint(), times)


@cached(8, key=lambda dataset, times: (str(shared.store().root), dataset, times))
def _named(dataset: str, times: list[tuple[str, int]]) -> list[str]:
    del times
    return list_collections(dataset=dataset, store=shared.store())


def pins() -> list[Pin]:
    """The pins of the open collection, in order, with what they show."""
    return collection().load(store=shared.store()) if session.choice().collection else []


def pin_button(label: str, make: Callable[[], list[Pin]], *, key: str) -> None:
    """A button that pins what a page shows; the tray of every page and the report show it.

    Args:
        label: what is pinned.
        make: called when the button is pressed.
        key: of the button, one per place.
    """
    if is_read_only():
        return
    is_pressed = st.button(
        f"Pin {label}",
        key=f"pin_{key}",
        icon=":material/push_pin:",
        help="Kept on this server with its numbers and its link; see *Pins* in the sidebar. Goes into the report that "
        "the Evaluation page makes.",
        on_click=_pin,  # first of all, whatever else makes the page run again in the meantime
        args=(make,),
    )
    if is_pressed:
        st.rerun()  # the whole page, with its tray


def _pin(make: Callable[[], list[Pin]]) -> None:
    try:
        check_may_change()
        made = [_completed(pin) for pin in make()]
        name = session.choice().collection or _own_name()
        add_pins(name, made, dataset=fingerprint(), store=shared.store())
    except CorsmalError as error:
        st.session_state[SAID] = plain(str(error))
        return
    session.choose(collection=name)
    st.session_state[SAID] = f"Pinned: {plain('; '.join(pin.title for pin in made))}"


def _own_name() -> str:
    """A name that nobody guesses."""
    name = f"{OWN}{secrets.token_hex(6)}"
    st.session_state.setdefault(OWNED, []).append(name)
    return name


def _completed(pin: Pin) -> Pin:
    """A pin with what all pins say of where they are from."""
    dataset, _ = session.opened()
    link = session.permalink(**({} if pin.frame is None else {"frame": pin.frame}))
    return replace(pin, dataset=dataset.name, link=pin.link or link, run=pin.run or _run_shown(dataset))


def _run_shown(dataset: Dataset) -> str | None:
    """The chosen run, if what a page shows of a recording is estimated with its parameters."""
    wanted = session.choice().run
    run = None if wanted is None else named_run(list_runs(store=shared.store(), dataset=dataset.root), wanted)
    return None if run is None or run.settings.shape != session.choice().estimated_shape else run.name
