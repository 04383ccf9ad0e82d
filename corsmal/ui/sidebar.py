"""The sidebar: the link to copy, the pins, the dataset folder and the recording picker."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

import streamlit as st
from streamlit.delta_generator import DeltaGenerator
from streamlit.runtime.scriptrunner import get_script_run_ctx

from corsmal.dataset import Dataset
from corsmal.demo.opening import open_demo
from corsmal.errors import CorsmalError
from corsmal.ui import demo, following, look, permalinks, session, shared
from corsmal.ui.choice import OF_DATASET, OF_RECORDING
from corsmal.ui.copy_link import copy_link
from corsmal.ui.folders import READ_ONLY, allowed_folder, data_root, default_folder, demo_folder, is_demo, is_read_only
from corsmal.ui.messages import guarded, plain
from corsmal.ui.pins import tray
from corsmal.ui.recordings import has_video, listed, most_complete, recording_labels

PICKER, SHOWN_ROOT, NOT_SHOWN = "picker", "shown_root", "sidebar_not_shown"
NUMBERS_FIRST = "overview"
"""The page that shows the sidebar itself when a visit begins there."""

STORE_PROBLEMS_MAX = 3
"""Of the last ones; visitors of a server with a data root are shown none: they name folders outside it."""


@contextmanager
def page_run(page: str) -> Iterator[None]:
    """What stands around every page: read the address, show the sidebar, write the address.

    Where a link is of another dataset than the open one the page says so, and ends here.

    Args:
        page: its name.
    """
    with following.timed():
        try:
            _begin(page)
            with guarded():  # a file may be removed at any moment
                yield
        finally:
            show()


def show() -> None:
    """Show the sidebar now, if this run has not shown it.

    The page that a visitor opens first may show its numbers before: the controls take a browser longer than they do.
    """
    if (draw := st.session_state.pop(NOT_SHOWN, None)) is not None:
        with _as_in_app(), st.sidebar:
            draw()


@contextmanager
def _as_in_app() -> Iterator[None]:
    """Let widgets be those of ``app.py``, which all pages have, when a page draws them: else each has its own."""
    context = get_script_run_ctx()
    if context is None:
        yield
        return
    with context.run_with_active_hash(context.pages_manager.main_script_hash):
        yield


def _begin(page: str) -> None:
    is_later = page == NUMBERS_FIRST and session.PAGE not in st.session_state
    st.session_state[session.PAGE] = page
    look.apply()
    session.read_address()
    permalinks.follow()
    if session.FOLDER not in st.session_state:
        st.session_state[session.FOLDER] = default_folder()
    with st.sidebar:
        reading = st.empty()
        place = None if is_later else _top()
        with reading:  # says so
            found = st.session_state[session.DATASET] = _open_dataset()
    _forget_links_of_another(found)
    is_met = permalinks.is_met(found)
    if found is not None and is_met:
        permalinks.remember(found)
        _choose_one_of(found)
    st.session_state[NOT_SHOWN] = partial(_draw, place, found, is_met=is_met)
    ends_early = not is_met or found is None or session.choice().recording is None
    if not is_later or ends_early:  # nothing can be shown once a page has ended
        show()
    session.write_address()
    if not is_met:
        permalinks.notice(found)
        st.stop()
    session.show_problems()


def _top() -> DeltaGenerator:
    """The folder's name; returns where the link and the pins stand."""
    place = st.container(key="sharing")
    _folder_input()
    return place


def _draw(place: DeltaGenerator | None, found: Dataset | None, *, is_met: bool) -> None:
    place = _top() if place is None else place
    if problem := st.session_state.get(session.FOLDER_PROBLEM):
        st.error(plain(problem), icon=":material/folder_off:")
    if found is not None and is_met:
        _recording_picker(found)
    if is_met:
        _sharing(place, found)


def _sharing(place: DeltaGenerator, found: Dataset | None) -> None:
    """The link to this page, and the pins."""
    if found is None:
        return
    left, right = place.columns(2)
    with left:
        copy_link("Copy link", key="copy_link")
    with right:
        tray()


def _folder_input() -> None:
    within = "" if data_root() is None else " This server opens those in its data folder, by their names there."
    st.text_input(
        "Dataset folder",
        key=session.FOLDER,
        persist_state="session",
        placeholder="/data/corsmal/train" if data_root() is None else "train",
        help=f"A folder with view1, view2, view3, audio and an annotation, as the dataset is published.{within}",
    )
    if is_read_only():
        st.caption(f":material/lock: {READ_ONLY}")
    if is_demo(session.folder()):
        demo.show_demo(session.folder(), session.FOLDER)
    else:
        to_demo = {session.FOLDER: str(demo_folder())}
        st.button(
            "Open the demo",
            on_click=lambda: st.session_state.update(to_demo),
            icon=":material/science:",
            width="stretch",
        )


def _open_dataset() -> Dataset | None:
    """The dataset of the chosen folder; None, with the reason in the session, where there is none."""
    folder = session.folder()
    st.session_state.pop(session.FOLDER_PROBLEM, None)
    if not folder:
        return None
    try:
        if folder == str(demo_folder()):
            open_demo(store=shared.store())
        return shared.dataset(allowed_folder(folder))
    except CorsmalError as error:
        st.session_state[session.FOLDER_PROBLEM] = str(error)
        return None


def _forget_links_of_another(found: Dataset | None) -> None:
    """Once a visitor has opened another dataset, what the address said of the earlier one binds no more."""
    if found is not None and _is_other(found) and st.session_state.get(session.LINK) is None:
        st.session_state[session.OPENED] = None


def _is_other(found: Dataset) -> bool:
    return st.session_state.get(SHOWN_ROOT) not in (None, found.root)


def _recording_picker(found: Dataset) -> None:
    current = session.choice().recording
    passing = set(listed(found).index)
    ids = [name for name in found.table.index if name in passing or name == current]
    place = ids.index(str(current))
    st.session_state[PICKER] = current
    labels = recording_labels(found.table.loc[ids])
    st.selectbox(
        "Recording",
        ids,
        key=PICKER,
        format_func=labels.__getitem__,
        on_change=lambda: _open(st.session_state[PICKER]),
        help="Those that the filters of the *Recordings* page leave; at first those with a video.",
    )
    left, right = st.columns(2)
    for column, label, key, step in ((left, "Previous", "[", -1), (right, "Next", "]", 1)):
        other = ids[place + step] if 0 <= place + step < len(ids) else None
        column.button(
            label,
            key=f"picker_{label}",
            help=f"Key `{key}`",
            disabled=other is None,
            on_click=_open,
            args=(other,),
            width="stretch",
        )
    look.run_scripts()
    for problem in found.problems:
        st.caption(f":material/info: {plain(problem)}")
    for problem in shared.store().problems[-STORE_PROBLEMS_MAX:] if data_root() is None else ():
        st.caption(f":material/warning: {plain(problem)}")


def _choose_one_of(found: Dataset) -> None:
    """Have a recording of the dataset chosen: of another dataset than before, one with files."""
    current, is_other = session.choice().recording, _is_other(found)
    is_linked = st.session_state.get(session.OPENED) is not None
    st.session_state[SHOWN_ROOT] = found.root
    session.choose(settled=False, dataset=permalinks.reference(found))
    if is_other and not is_linked:
        session.choose(settled=False, **OF_DATASET)
        if current is not None and current in found and not has_video(str(found.table.loc[current, "missing"])):
            current = None
    if current is None:
        session.choose(settled=False, recording=most_complete(found.table))
    elif current not in found:
        session.choose(settled=False, recording=most_complete(found.table), **OF_RECORDING)
    else:
        session.choose(settled=False, recording=found[current].id)


def _open(recording: str) -> None:
    session.choose(recording=recording, **OF_RECORDING)
