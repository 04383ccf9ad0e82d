"""The run that is shown, what it was made with, and how far it is."""

import streamlit as st
from streamlit.delta_generator import DeltaGenerator

from corsmal.dataset import Dataset
from corsmal.runs.keeping import delete_run, restore_run
from corsmal.runs.run import Run, named_run
from corsmal.ui import session, shared
from corsmal.ui.evaluation.judged import deleted, runs
from corsmal.ui.evaluation.new_run import job_key, new_run, resume
from corsmal.ui.folders import READ_ONLY, check_may_change, is_read_only
from corsmal.ui.following import follow
from corsmal.ui.messages import guarded, plain

DELETED = "evaluation_deleted"
"""The ids of the runs that this session deleted last."""


def chosen_run(dataset: Dataset) -> Run | None:
    """The run that is shown, under the controls for it; None while there is none."""
    found, key = runs(dataset), job_key(dataset)
    is_running = shared.jobs().is_active(key)
    undo_control(dataset)
    is_lost = _is_lost(dataset, found)
    if not found and not is_running:
        _without_runs(dataset)
    run = _picker(dataset, found, is_lost=is_lost) if found else None
    follow(key)
    if run is not None:
        _about(dataset, run, is_running=is_running)
    return run


def show_run(run: Run) -> None:
    """Let this run be the one that is shown, among its results."""
    session.choose(view=None, run=run.short_id)


def delete(chosen: list[Run]) -> None:
    """Delete runs, which can be undone."""
    with guarded():
        check_may_change()
        for run in chosen:
            delete_run(run, store=shared.store())
    st.session_state[DELETED] = [run.id for run in chosen]


def undo_control(dataset: Dataset) -> None:
    """Say what was deleted last, with a button that brings it back."""
    wanted = st.session_state.get(DELETED, ())
    gone = [each.run for each in deleted(dataset) if each.run.id in wanted]
    if not gone:
        return
    names = ", ".join(f"**{plain(run.name)}**" for run in gone)
    left, right = st.columns([5, 1.4], vertical_alignment="center")
    left.info(
        f"Deleted: {names}. Deleted runs can be brought back for 30 days, see *All runs*.", icon=":material/delete:"
    )
    if is_read_only():
        return
    right.button("Undo", icon=":material/undo:", on_click=restore, args=(gone,), width="stretch", key="undo_delete")


def restore(gone: list[Run]) -> None:
    """Bring deleted runs back."""
    with guarded():
        check_may_change()
        for run in gone:
            restored = restore_run(run, store=shared.store())
            session.choose(run=restored.short_id)
    st.session_state.pop(DELETED, None)


def _is_lost(dataset: Dataset, found: list[Run]) -> bool:
    """Whether a link names a run that is not kept here, which the page then says."""
    wanted = session.choice().run
    if not session.is_linked("run") or named_run(found, wanted) is not None:
        return False
    gone = named_run([each.run for each in deleted(dataset)], wanted)
    where = "is not kept on this server" if gone is None else "was deleted; *All runs* can bring it back"
    name = str(wanted) if gone is None else gone.name
    st.error(
        f"The link shows the run **{plain(name)}**, which {where}. Other runs have other numbers: none is shown until "
        "you choose one.",
        icon=":material/link_off:",
    )
    return True


def _without_runs(dataset: Dataset) -> None:
    if is_read_only():
        st.info(f"There is no run on this dataset yet. {READ_ONLY}", icon=":material/lock:")
        return
    st.info(
        "There is no run on this dataset yet. A run estimates everything about many recordings and is kept under a "
        "name, with its parameters and the digests of weights and files. **Choose the parameters below and press "
        "*Run***: the results appear here while it is being made. Runs made by `python -m corsmal estimate` are listed "
        "here too.",
        icon=":material/play_circle:",
    )
    with st.container(border=True):
        new_run(dataset, [])


def _picker(dataset: Dataset, found: list[Run], *, is_lost: bool) -> Run | None:
    wanted = named_run(found, session.choice().run)
    newest = next((run for run in found if not run.is_archived), found[0])
    run = None if is_lost else wanted or newest
    by_id = {each.short_id: each for each in found if not each.is_archived or each is run}
    left, middle, right = st.columns([5, 1.4, 1.4], vertical_alignment="bottom")
    st.session_state["run_picker"] = None if run is None else run.short_id
    left.selectbox(
        "Run",
        list(by_id),
        key="run_picker",
        format_func=lambda name: _label(by_id[name]),
        on_change=lambda: session.choose(run=st.session_state["run_picker"]),
        placeholder="Choose a run",
    )
    if run is None:
        return None
    is_busy = shared.jobs().is_active(job_key(dataset))
    # A run that was started a moment ago may not be kept yet; the address has its name until then
    if session.choice().run != run.short_id and (wanted is not None or not is_busy):
        session.choose(settled=False, run=run.short_id)
        session.write_address()
    if not is_read_only():
        _actions(dataset, found, run, (middle, right), is_busy=is_busy)
    return run


def _actions(
    dataset: Dataset, found: list[Run], run: Run, places: tuple[DeltaGenerator, DeltaGenerator], *, is_busy: bool
) -> None:
    """What can be made, and what can be done with the run that is shown."""
    job = shared.jobs().get(job_key(dataset))
    # A popover stays open until another one takes its place: once something was started in it
    state = f"{run.id} {None if job is None else job.started_s}"
    with places[0].popover("New run", icon=":material/add:", width="stretch", key=f"new_run {state}"):
        new_run(dataset, [each.name for each in found])
    with places[1].popover("This run", icon=":material/more_horiz:", width="stretch", key=f"this_run {state}"):
        st.button(
            "Update",
            icon=":material/refresh:",
            on_click=resume,
            args=(dataset, run),
            width="stretch",
            help="Detects and estimates again where files or detections are new; the rest is read from the store.",
        )
        st.button(
            "Delete",
            icon=":material/delete:",
            on_click=delete,
            args=([run],),
            disabled=is_busy,
            width="stretch",
            key="delete_run",
            help="Can be undone for 30 days. The estimates of its recordings stay in the store.",
        )
        st.caption("Name, note and archive: see *All runs*.")


def _label(run: Run) -> str:
    state = "" if run.is_complete else f", {len(run.rows)} done"
    count = len(run.recordings)
    return f"{run.name} · {count} recording{'' if count == 1 else 's'}{state} · {run.created[:10]}"


def _about(dataset: Dataset, run: Run, *, is_running: bool) -> None:
    facts = [f"{name}: {value}" for name, value in run.facts().items()]
    st.caption(f":material/tune: {plain(' · '.join(facts))}")
    if run.note:
        st.caption(f":material/sticky_note_2: {plain(run.note)}")
    if run.is_complete:
        return
    count = f"{len(run.rows)} of {len(run.recordings)} recordings"
    if is_running:
        st.warning(f"**Partial results**: {count} are estimated so far.", icon=":material/hourglass_top:")
        return
    left, right = st.columns([5, 1.4], vertical_alignment="center")
    left.warning(f"**Partial results**: this run is incomplete, {count} are estimated.", icon=":material/pause_circle:")
    if not is_read_only():
        right.button("Resume", icon=":material/play_arrow:", on_click=resume, args=(dataset, run), width="stretch")
