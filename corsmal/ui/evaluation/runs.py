"""The run that is shown; starting, stopping, resuming and deleting one."""

from collections.abc import Sequence

import streamlit as st

from corsmal.dataset import Dataset, Recording
from corsmal.engines.local import local_engine
from corsmal.parameters import METHOD_VIEWS, SHAPE_PRESETS, ShapeParameters
from corsmal.runs.making import make_run, numbered_names
from corsmal.runs.run import Run, delete_run
from corsmal.stages.settings import (
    SEARCH_STEP,
    DetectorSettings,
    EstimateSettings,
    default_settings,
    find_detector,
    left_out_note,
)
from corsmal.ui import session, shared
from corsmal.ui.detecting import detector_control
from corsmal.ui.evaluation.judged import runs
from corsmal.ui.folders import READ_ONLY, check_may_change, is_read_only
from corsmal.ui.following import follow
from corsmal.ui.jobs import Job
from corsmal.ui.messages import guarded, plain
from corsmal.ui.one_of import one_of
from corsmal.weights import find_weights

OWN = "as on the Shape page"


def chosen_run(dataset: Dataset) -> Run | None:
    """The run that is shown, under the controls for it; None while there is none."""
    found, key = runs(dataset), job_key(dataset)
    is_running = shared.jobs().is_active(key)
    is_lost = _is_lost(found)
    if not found and not is_running:
        _without_runs(dataset)
    run = _picker(dataset, found, is_lost=is_lost) if found else None
    follow(key)
    if run is not None:
        _about(dataset, run, is_running=is_running)
    return run


def _is_lost(found: list[Run]) -> bool:
    """Whether a link names a run that is not kept here, which the page then says."""
    wanted = session.choice().run
    if not session.is_linked("run") or wanted in [run.name for run in found]:
        return False
    st.error(
        f"The link shows the run **{plain(str(wanted))}**, which is not kept on this server. Other runs have other "
        "numbers: none is shown until you choose one.",
        icon=":material/link_off:",
    )
    return True


def job_key(dataset: Dataset) -> str:
    """The key of the job that estimates on a dataset: one for all tabs of the browser."""
    return f"evaluate {dataset.root}"


def _without_runs(dataset: Dataset) -> None:
    st.info(
        "There is no run on this dataset yet. A run estimates everything about many recordings and is kept under a "
        "name, with its parameters and the digests of weights and files. Runs made by `python -m corsmal estimate` are "
        "listed here too.",
        icon=":material/play_circle:",
    )
    if is_read_only():
        st.caption(f":material/lock: {READ_ONLY}")
        return
    with st.container(border=True):
        _new_run(dataset, [])


def _picker(dataset: Dataset, found: list[Run], *, is_lost: bool) -> Run | None:
    by_name = {run.name: run for run in found}
    wanted = session.choice().run  # a run that was started a moment ago may not be kept yet
    run = None if is_lost else by_name.get(str(wanted), found[0])
    left, middle, right = st.columns([5, 1.4, 1.4], vertical_alignment="bottom")
    st.session_state["run_picker"] = None if run is None else run.name
    left.selectbox(
        "Run",
        list(by_name),
        key="run_picker",
        format_func=lambda name: _label(by_name[name]),
        on_change=lambda: session.choose(run=st.session_state["run_picker"]),
        placeholder="Choose a run",
    )
    if run is None:
        return None
    if wanted is None:
        session.choose(settled=False, run=run.name)
        session.write_address()
    if is_read_only():
        return run
    job = shared.jobs().get(job_key(dataset))
    # A popover stays open until another one takes its place: once something was started in it
    state = f"{run.name} {None if job is None else job.started_s}"
    with middle.popover("New run", icon=":material/add:", width="stretch", key=f"new_run {state}"):
        _new_run(dataset, list(by_name))
    with right.popover("This run", icon=":material/more_horiz:", width="stretch", key=f"this_run {state}"):
        st.button(
            "Update",
            icon=":material/refresh:",
            on_click=start,
            args=_resumed(dataset, run),
            width="stretch",
            help="Detects and estimates again where files or detections are new; the rest is read from the store.",
        )
        _delete_control(run)
    return run


def _label(run: Run) -> str:
    state = "" if run.is_complete else f", {len(run.rows)} done"
    return f"{run.name} · {len(run.recordings)} recordings{state} · {run.created[:10]}"


def _about(dataset: Dataset, run: Run, *, is_running: bool) -> None:
    facts = [f"{name}: {value}" for name, value in run.facts().items()]
    st.caption(f":material/tune: {plain(' · '.join(facts))}")
    if run.is_complete or is_running:
        return
    left, right = st.columns([5, 1.4], vertical_alignment="center")
    left.warning(
        f"This run is incomplete: {len(run.rows)} of {len(run.recordings)} recordings are estimated.",
        icon=":material/pause_circle:",
    )
    if not is_read_only():
        resumed = _resumed(dataset, run)
        right.button("Resume", icon=":material/play_arrow:", on_click=start, args=resumed, width="stretch")


def _new_run(dataset: Dataset, taken: list[str]) -> None:
    presets: dict[str, ShapeParameters] = dict(SHAPE_PRESETS)
    if not session.choice().is_preset:
        presets[OWN] = session.choice().shape
    preset = one_of("Parameters of the fit", {name: name for name in presets}, key="run_preset")
    free = next(name for name in numbered_names(preset) if name not in taken)
    name = st.text_input("Name", free, max_chars=60, key=f"run_name {preset} {len(taken)}")
    ids = _recordings_control(dataset)
    detector = detector_settings(dataset[ids[0]] if ids else None)
    for weights in (find_weights("filling"), find_weights("mass")):
        if not weights.path.is_file():
            st.caption(
                f":material/info: No {weights.kind} network: its weights are not in {plain(str(weights.path))}. "
                f"The run leaves out its estimates; train it with `python -m corsmal train {weights.kind} ROOT RUN` "
                f"and name it in `CORSMAL_{weights.kind.upper()}_WEIGHTS`."
            )
    settings = default_settings(dataset, shape=presets[preset], detector=detector)
    left_out = left_out_note(dataset, settings)
    if left_out:
        st.caption(f":material/info: {plain(left_out)}")
    is_running = shared.jobs().is_active(job_key(dataset))
    if st.button("Run", type="primary", icon=":material/play_arrow:", disabled=not ids or is_running, key="start_run"):
        session.choose(run=name.strip())
        start(dataset, name, ids, settings)
        st.rerun()
    if is_running:
        st.caption("Another run on this dataset is being made.")


def _recordings_control(dataset: Dataset) -> list[str]:
    filmed = [recording.id for recording in dataset if any(name in recording.views for name in METHOD_VIEWS)]
    others = {} if len(filmed) == len(dataset) else {"all that are known": list(dataset.ids)}
    groups = {"with a video": filmed, **others, "the chosen one": [str(session.choice().recording)]}
    labels = {name: f"{name} ({len(ids)})" for name, ids in groups.items()}
    return groups[one_of("Recordings", labels, key="run_recordings")]


def detector_settings(example: Recording | None) -> DetectorSettings | None:
    """Choose the detector for recordings without detections; at first on for synthetic recordings, as ``example``."""
    is_demo = example is not None and example.is_synthetic
    if not st.toggle(
        "Run the detector on recordings without detections",
        value=is_demo,
        key="run_detects",
        help=f"Every {SEARCH_STEP}th frame, then from coarse to fine around the best. Without it, a recording that has "
        "no detections fails. From a terminal: `python -m corsmal detect ROOT`, for the demo with `--demo-weights`.",
    ):
        return None
    return find_detector(detector_control(is_synthetic=is_demo, key="run_detector"))


def start(dataset: Dataset, name: str, ids: Sequence[str], settings: EstimateSettings) -> None:
    """Begin or resume a run in the background."""
    store = shared.store()

    def work(job: Job) -> None:
        make_run(
            name,
            dataset,
            settings,
            store=store,
            recordings=ids,
            engine=local_engine(len(ids), detects=settings.detector is not None, gives_way=True),
            progress=job.advance,
            cancelled=job.cancelled,
        )

    shared.jobs().start(job_key(dataset), f"Run {plain(name)}", work)


def _resumed(dataset: Dataset, run: Run) -> tuple[Dataset, str, Sequence[str], EstimateSettings]:
    return dataset, run.name, run.recordings, run.settings


def _delete_control(run: Run) -> None:
    """Delete the run, after a second press."""
    asked = f"delete {run.name}"
    if not st.session_state.get(asked):
        ask = {asked: True}
        st.button(
            "Delete …",
            icon=":material/delete:",
            on_click=lambda: st.session_state.update(ask),
            width="stretch",
            key="delete_run",
        )
        return
    st.markdown(
        f"Delete the run **{plain(run.name)}**? Its table of {len(run.rows)} recordings is removed. What was estimated "
        "stays in the store, so that the same run can be made again in little time."
    )
    left, right = st.columns(2)
    keep = {asked: False}
    left.button("Keep", on_click=lambda: st.session_state.update(keep), width="stretch")
    right.button("Delete", icon=":material/delete:", on_click=_delete, args=(run, asked), width="stretch")


def _delete(run: Run, asked: str) -> None:
    st.session_state.pop(asked, None)
    with guarded():
        check_may_change()
        delete_run(run.name, dataset=run.dataset, store=shared.store())
