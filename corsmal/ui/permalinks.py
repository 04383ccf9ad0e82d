"""Links name their dataset: finding it on this server, and what is said where it is another or absent."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import streamlit as st

from corsmal.dataset import Dataset
from corsmal.demo.opening import open_demo
from corsmal.digests import digest
from corsmal.errors import CorsmalError
from corsmal.ui import session, shared
from corsmal.ui.choice import Choice
from corsmal.ui.folders import allowed_folder, data_root, default_folder, demo_folder, full_demo_folder
from corsmal.ui.messages import plain

KIND, REMEMBERED = "datasets", "dataset_remembered"
NAME_MAX = 80


def reference(dataset: Dataset) -> str:
    """How an address names a dataset: by its folder's name and its fingerprint, by which it is recognised.

    Where there is a data folder on the server the name is the path in it; where else the folder lies is not said.
    """
    root = data_root()
    is_within = root is not None and dataset.root.is_relative_to(root) and dataset.root != root
    name = dataset.root.relative_to(root).as_posix() if root is not None and is_within else dataset.name
    return f"{name[:NAME_MAX]}-{dataset.fingerprint}"


def remember(dataset: Dataset) -> None:
    """Keep where a dataset lies, so that links to it open it on this server; it is kept once in a session."""
    known = str(dataset.root), dataset.fingerprint
    if st.session_state.get(REMEMBERED) != known:
        st.session_state[REMEMBERED] = known
        shared.store().save_json(KIND, _key(dataset.fingerprint), {"folder": str(dataset.root)})


def follow() -> None:
    """Open the dataset that an opened address names, if this server knows it."""
    wanted = st.session_state.get(session.LINK)
    if wanted is None:
        return
    for folder, found in _candidates(wanted):
        if found.fingerprint == _parts(wanted)[1]:
            st.session_state[session.FOLDER] = folder
            return


def is_met(found: Dataset | None) -> bool:
    """Whether the open dataset is the one that an opened address is about, and has its recording."""
    wanted, current = st.session_state.get(session.LINK), session.choice().recording
    if wanted is not None and (found is None or found.fingerprint != _parts(wanted)[1]):
        return False
    if found is not None and current is not None and current not in found and session.is_linked("recording"):
        return False
    st.session_state[session.LINK] = None
    return True


def notice(found: Dataset | None) -> None:
    """Say that a link is of another dataset, and what can be done; nothing of the open one is shown."""
    wanted, current = st.session_state.get(session.LINK), session.choice().recording
    name, fingerprint = _parts(wanted or "")
    what = f"recording **{plain(current[:40])}**" if current else "recordings"
    if wanted is None or (found is not None and found.fingerprint == fingerprint):
        here = (
            "" if found is None else f"the open dataset, **{plain(found.name)}**, does not have: nothing of it is shown"
        )
        sentence = f"The link is about {what}, which {here}."
    else:
        sentence = f"The link is about {what} of the dataset **{plain(name)}** (`{fingerprint}`)."
        if found is not None:
            other = f"{plain(found.name)} (`{found.fingerprint}`)"
            sentence += f" Open here is **another dataset**, {other}: nothing of it is shown."
    st.title("This link cannot be shown here")
    st.error(sentence, icon=":material/link_off:")
    st.markdown(
        "If that dataset is on this server, enter its folder in the sidebar, and the link is followed. The digits in "
        "brackets are computed from the recordings' ids and the annotation."
    )
    _ways_on(found, wanted, current)


def _ways_on(found: Dataset | None, wanted: str | None, current: str | None) -> None:
    if wanted is not None:
        for folder, other in _candidates(wanted):
            if other.name == Path(_parts(wanted)[0]).name and (current is None or current in other):
                st.button(
                    f"Show it in the dataset {plain(other.name)} of this server, whose recordings or annotation differ",
                    icon=":material/folder_open:",
                    on_click=_show_in,
                    args=(folder,),
                )
                break
    label = "Continue without the link" if found is None else f"Open {plain(found.name)} without the link"
    st.button(label, icon=":material/link_off:", on_click=_without_link)


def _show_in(folder: str) -> None:
    """Follow the link in a dataset of the same name."""
    st.session_state.update({session.FOLDER: folder, session.LINK: None})
    session.choose(dataset=None)


def _without_link() -> None:
    st.session_state.update({session.LINK: None, session.OPENED: None, session.PROBLEMS: ()})
    st.session_state[session.CHOICE] = Choice(collection=session.choice().collection)
    session.write_address()


def _candidates(wanted: str) -> Iterator[tuple[str, Dataset]]:
    """Datasets that a link may mean, with their folders.

    What is open, what the server was started with, the demos, where a dataset of this fingerprint was before, and what
    has the name in the data folder.
    """
    name, fingerprint = _parts(wanted)
    kept, root = shared.store().json(KIND, _key(fingerprint)) or {}, data_root()
    folders = [session.folder(), default_folder(), str(kept.get("folder") or "")]
    folders += [str(folder) for folder in (demo_folder(), full_demo_folder()) if folder.name == name]
    folders += [] if root is None else [str(root / name)]
    for folder in filter(None, dict.fromkeys(folders)):
        with suppress(CorsmalError):
            if folder == str(demo_folder()):
                open_demo(store=shared.store())
            yield folder, shared.dataset(allowed_folder(folder))


def _parts(reference_text: str) -> tuple[str, str]:
    """Name and fingerprint."""
    name, _, fingerprint = reference_text.rpartition("-")
    return name, fingerprint


def _key(fingerprint: str) -> str:
    return digest("dataset", fingerprint)
