"""What one browser session is looking at: its dataset folder, recording, frame and parameters."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import streamlit as st
from streamlit.runtime.scriptrunner import get_script_run_ctx

from corsmal.dataset import Dataset, Recording
from corsmal.demo.opening import open_demo
from corsmal.errors import CorsmalError
from corsmal.ui import demo, following, look, shared
from corsmal.ui.folders import default_folder, demo_folder, is_demo
from corsmal.ui.messages import plain
from corsmal.ui.recordings import forget_filters, has_video, listed, most_complete, recording_labels
from corsmal.ui.url import Choice, from_params, to_params

CHOICE, WRITTEN, PROBLEMS, PICKER = "choice", "url_written", "url_problems", "picker"
FOLDER, FOLDER_PROBLEM, DATASET, SHOWN_ROOT = "data_folder", "folder_problem", "dataset", "shown_root"


@contextmanager
def page_run() -> Iterator[None]:
    """What stands around every page: read the address, show the sidebar's pickers, write the address."""
    with following.timed():
        _begin()
        yield


def _begin() -> None:
    look.apply()
    _read_address()
    with st.sidebar:
        _folder_input()
        found = st.session_state[DATASET] = _open_dataset()
        if found is not None:
            _recording_picker(found)
    for problem in st.session_state.get(PROBLEMS, ()):
        _show_problem(problem)
    _write_address()


def keep_frame_within(frames: int) -> None:
    """Ignore a chosen frame that the recording does not have, and say so: only an address can hold one."""
    frame = choice().frame
    if frame is None or frame < frames:
        return
    problem = f"The address has frame={str(frame)!r}: ignored; allowed range 0–{frames - 1}."
    _add_problem(problem)
    _show_problem(problem)
    choose(settled=False, frame=None)
    _write_address()


def choice() -> Choice:
    """What this session is looking at."""
    current: Choice = st.session_state.setdefault(CHOICE, Choice())
    return current


def choose(*, settled: bool = True, **changes: Any) -> None:
    """Look at something else, and let the address say so.

    Args:
        settled: False while something is being dragged: the address is written when it stops, with or without changes.
        changes: fields of ``Choice``.
    """
    if changes:
        st.session_state[CHOICE] = replace(choice(), **changes)
    if changes and settled:
        st.session_state[PROBLEMS] = ()
    if settled:
        _write_address()


def opened() -> tuple[Dataset, Recording]:
    """The dataset and the chosen recording; where there is none the page says what to do and ends here."""
    found: Dataset | None = st.session_state[DATASET]
    current = choice().recording
    if found is None or current is None:
        _nothing_to_show()
        st.stop()
    return found, found[current]


def folder() -> str:
    """The dataset folder that this session looks at."""
    return str(st.session_state.get(FOLDER, "")).strip()


def _write_address() -> None:
    """Let the address bar say what this session is looking at; every change is a step of the browser's history."""
    params = to_params(choice())
    if st.query_params.to_dict() != params:
        st.query_params.from_dict(params)
    st.session_state[WRITTEN] = params


def _read_address() -> None:
    """Follow an address that was opened, or stepped back to; one that navigation emptied is written again.

    Any other run may still bring the address from before the last change, of which the browser is just being told.
    """
    if WRITTEN in st.session_state and not _stepped_in_history():
        return
    params, written = st.query_params.to_dict(), st.session_state.get(WRITTEN)
    if params and params != written:
        st.session_state[CHOICE], st.session_state[PROBLEMS] = from_params(params)


def _stepped_in_history() -> bool:
    """Whether the browser's Back or Forward caused this run."""
    context = get_script_run_ctx()
    return context is not None and context.is_history_navigation


def _add_problem(problem: str) -> None:
    st.session_state[PROBLEMS] = (*st.session_state.get(PROBLEMS, ()), problem)


def _show_problem(problem: str) -> None:
    st.warning(plain(problem), icon=":material/link_off:")


def _folder_input() -> None:
    if FOLDER not in st.session_state:
        st.session_state[FOLDER] = default_folder()
    st.text_input(
        "Dataset folder",
        key=FOLDER,
        persist_state="session",
        placeholder="/data/corsmal/train",
        help="A folder with view1, view2, view3, audio and an annotation, as the dataset is published.",
    )
    if is_demo(folder()):
        demo.show_demo(folder(), FOLDER)
    else:
        to_demo = {FOLDER: str(demo_folder())}
        st.button(
            "Open the demo",
            on_click=lambda: st.session_state.update(to_demo),
            icon=":material/science:",
            width="stretch",
        )


def _open_dataset() -> Dataset | None:
    """The dataset of the chosen folder; None, with the reason in the sidebar, where there is none."""
    st.session_state.pop(FOLDER_PROBLEM, None)
    if not folder():
        return None
    try:
        if folder() == str(demo_folder()):
            open_demo(store=shared.store())
        return shared.dataset(folder())
    except CorsmalError as error:
        st.session_state[FOLDER_PROBLEM] = str(error)
        st.error(plain(str(error)), icon=":material/folder_off:")
        return None


def _recording_picker(found: Dataset) -> None:
    _choose_one_of(found)
    current = choice().recording
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
    look.picker_keys()
    for problem in found.problems:
        st.caption(f":material/info: {plain(problem)}")


def _choose_one_of(found: Dataset) -> None:
    """Have a recording of the dataset chosen: of another dataset than before, one with files."""
    current, is_other = choice().recording, st.session_state.get(SHOWN_ROOT) not in (None, found.root)
    st.session_state[SHOWN_ROOT] = found.root
    if is_other:
        forget_filters()
    if current is None:
        choose(settled=False, recording=most_complete(found.table))
    elif current not in found.table.index or (is_other and not has_video(str(found.table.loc[current, "missing"]))):
        if not is_other:
            _add_problem(f"Recording {current[:40]!r} is not in {found.root}; another one is shown instead.")
        choose(settled=False, recording=most_complete(found.table), frame=None, pair=None, crop_s=None)
    elif is_other:
        choose(settled=False, frame=None, pair=None, crop_s=None)


def _open(recording: str) -> None:
    choose(recording=recording, frame=None, pair=None, crop_s=None)


def _nothing_to_show() -> None:
    if problem := st.session_state.get(FOLDER_PROBLEM):
        st.error(plain(problem), icon=":material/folder_off:")
    st.info(
        "Name a dataset folder in the sidebar to begin: a folder with `view1`, `view2`, `view3` (each with `rgb` and "
        "`calib`), `audio` and an annotation. It can also be given as `streamlit run app.py -- --data DIR`, or in the "
        "environment as `CORSMAL_DATA`.",
        icon=":material/folder_open:",
    )
