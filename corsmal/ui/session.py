"""What one browser session is looking at: its choice, which the address bar says, and its dataset."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NoReturn
from urllib.parse import urlencode

import streamlit as st
from streamlit.runtime.scriptrunner import get_script_run_ctx

from corsmal.dataset import Dataset, Recording
from corsmal.ui.choice import OF_FIT, Choice
from corsmal.ui.messages import plain
from corsmal.ui.url import FIELDS, from_params, to_params

CHOICE, WRITTEN, PROBLEMS, OPENED, LINK = "choice", "url_written", "url_problems", "url_opened", "url_dataset"
FOLDER, FOLDER_PROBLEM, DATASET, PAGE = "data_folder", "folder_problem", "dataset", "page"

SHORT = {name: short for short, (name, _, _) in FIELDS.items()}
"""By field of ``Choice``: its name in the address."""


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
        before = choice()
        if any(getattr(before, name) != changes.get(name, getattr(before, name)) for name in OF_FIT):
            changes = {"numbers": ()} | changes
        st.session_state[CHOICE] = replace(before, **changes)
    if changes and settled:
        st.session_state[PROBLEMS] = ()
    if settled:
        write_address()


def open_page(page: str, **changes: Any) -> NoReturn:
    """Go to another page, and look at something else there.

    The address goes with it: a page that is opened without one writes its own, a second step of the browser's history.

    Args:
        page: its file's name.
        changes: fields of ``Choice``.
    """
    choose(settled=False, **changes)
    params = st.session_state[WRITTEN] = to_params(choice())
    st.session_state[PROBLEMS] = ()
    st.switch_page(f"pages/{page}.py", query_params=params)


def opened() -> tuple[Dataset, Recording]:
    """The dataset and the chosen recording, its views matched and its masks used as is chosen.

    Where there is none the page says what to do and ends here.
    """
    found: Dataset | None = st.session_state[DATASET]
    current = choice().recording
    if found is None or current is None:
        _nothing_to_show()
        st.stop()
    return found, replace(found[current], matching=choice().matching, masks=choice().masks or "detected")


def folder() -> str:
    """The dataset folder that this session looks at."""
    return str(st.session_state.get(FOLDER, "")).strip()


def permalink(**changes: Any) -> str:
    """The address of the page that is shown, from the app's own on; without the visitor's collection of pins.

    Args:
        changes: fields of ``Choice`` in which it differs from what is chosen.
    """
    params = to_params(replace(choice(), **{"collection": None, **changes}))
    return f"{st.session_state.get(PAGE, 'overview')}?{urlencode(params)}"


def is_linked(field: str) -> bool:
    """Whether a field of the choice is still as an opened address said."""
    linked = st.session_state.get(OPENED)
    return linked is not None and SHORT[field] in linked[1] and getattr(linked[0], field) == getattr(choice(), field)


def keep_frame_within(frames: int) -> None:
    """Ignore a chosen frame that the recording does not have, and say so: only an address can hold one."""
    frame = choice().frame
    if frame is not None and frame >= frames:
        _ignore("frame", f"allowed range 0–{frames - 1}")


def keep_among(field: str, options: Iterable[str]) -> None:
    """Ignore what an address says of a field where it is not to be had here, and say so.

    Args:
        field: of ``Choice``, a text or a tuple of them.
        options: what is to be had.
    """
    chosen, known = getattr(choice(), field), list(options)
    wanted = chosen if isinstance(chosen, tuple) else () if chosen is None else (chosen,)
    if set(wanted) <= set(known) or not is_linked(field):
        return
    _ignore(field, f"available: {', '.join(known)[:120] or 'nothing'}")


def _ignore(field: str, reason: str) -> None:
    value, short = getattr(choice(), field), SHORT[field]
    problem = f"The address has {short}={FIELDS[short].write(value)[:40]!r}: ignored; {reason}."
    add_problem(problem)
    show_problem(problem)
    choose(settled=False, **{field: () if isinstance(value, tuple) else None})
    write_address()


def write_address() -> None:
    """Let the address bar say what this session is looking at; every change is a step of the browser's history."""
    params = to_params(choice())
    if st.query_params.to_dict() != params:
        st.query_params.from_dict(params)
    st.session_state[WRITTEN] = params


def read_address() -> None:
    """Follow an address that was opened, or stepped back to; one that navigation emptied is written again.

    Any other run may still bring the address from before the last change, of which the browser is just being told.
    """
    if WRITTEN in st.session_state and not _stepped_in_history():
        return
    params, written = st.query_params.to_dict(), st.session_state.get(WRITTEN)
    if params and params != written:
        found, problems = from_params(params)
        st.session_state.update({CHOICE: found, PROBLEMS: problems, OPENED: (found, params), LINK: found.dataset})


def _stepped_in_history() -> bool:
    """Whether the browser's Back or Forward caused this run."""
    context = get_script_run_ctx()
    return context is not None and context.is_history_navigation


def add_problem(problem: str) -> None:
    """Keep a sentence about the address, to be shown until something is chosen."""
    st.session_state[PROBLEMS] = (*st.session_state.get(PROBLEMS, ()), problem)


def show_problems() -> None:
    """Show what was wrong with the address."""
    for problem in st.session_state.get(PROBLEMS, ()):
        show_problem(problem)


def show_problem(problem: str) -> None:
    """Show a sentence about the address."""
    st.warning(plain(problem), icon=":material/link_off:")


def _nothing_to_show() -> None:
    if problem := st.session_state.get(FOLDER_PROBLEM):
        st.error(plain(problem), icon=":material/folder_off:")
    st.info(
        "Name a dataset folder in the sidebar to begin: a folder with `view1`, `view2`, `view3` (each with `rgb` and "
        "`calib`), `audio` and an annotation. It can also be given as `streamlit run app.py -- --data DIR`, or in the "
        "environment as `CORSMAL_DATA`.",
        icon=":material/folder_open:",
    )
