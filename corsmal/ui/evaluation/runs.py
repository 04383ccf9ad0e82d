"""Which run is looked at; starting, stopping, resuming and deleting one."""

from collections.abc import Callable
from functools import partial

import streamlit as st

from corsmal.dataset import Dataset, Recording
from corsmal.errors import CorsmalError
from corsmal.parameters import METHOD_VIEWS, SHAPE_PRESETS, ShapeParameters
from corsmal.runs.run import Run, delete_run, record_run
from corsmal.stages.detections import detect_recording, load_detections
from corsmal.store import Store
from corsmal.ui import data, session
from corsmal.ui.components import guarded, plain
from corsmal.ui.detecting import DETECTORS, SEARCH_STEP, open_detector
from corsmal.ui.evaluation import cached as evaluation
from corsmal.ui.jobs import Job, progress_text

RUN = "evaluation_run"
OWN = "as on the Shape page"


def chosen_run(dataset: Dataset) -> Run | None:
    """The run that is looked at, under the controls for it; None while there is none."""
    found = evaluation.runs(dataset)
    key = job_key(dataset)
    job = data.jobs().get(key)
    is_running = job is not None and job.active
    if not found:
        _without_runs(dataset, is_running=is_running)
    run = _picker(dataset, found) if found else None
    follow(key)
    if run is not None:
        _about(dataset, run, is_running=is_running)
    return run


def job_key(dataset: Dataset) -> str:
    """The key of the job that estimates on a dataset: one for all tabs of the browser."""
    return f"evaluate {dataset.root}"


def follow(key: str) -> bool:
    """Show how far a job on recordings is, or why it failed.

    Returns:
        Whether it is running; the page is run again when it ends.
    """
    job = data.jobs().get(key)
    if job is not None and job.active:
        _watch(key)
        return True
    if job is not None and job.state == "failed":
        st.error(plain(job.problem), icon=":material/error:")
    return False


@st.fragment(run_every=0.5)
def _watch(key: str) -> None:
    job = data.jobs().get(key)
    if job is None or not job.active:
        st.rerun()
    left, right = st.columns([5, 1], vertical_alignment="bottom")
    left.progress(job.fraction, text=progress_text(job, "recordings"))
    right.button(
        "Stop",
        key=f"stop {key}",
        on_click=job.cancel,
        help="What was done is kept.",
        icon=":material/stop:",
        width="stretch",
    )


def _without_runs(dataset: Dataset, *, is_running: bool) -> None:
    if is_running:
        return
    st.info(
        "There is no run on this dataset yet. A run estimates everything about many recordings and is kept under a "
        "name, with its parameters and the digests of weights and files.",
        icon=":material/play_circle:",
    )
    with st.container(border=True):
        _new_run(dataset, [])


def _picker(dataset: Dataset, found: list[Run]) -> Run:
    by_name = {run.name: run for run in found}
    wanted = st.session_state.get(RUN)  # a run that was started a moment ago may not be kept yet
    run = by_name.get(str(wanted), found[0])
    left, middle, right = st.columns([5, 1.4, 1.4], vertical_alignment="bottom")
    st.session_state["run_picker"] = run.name
    left.selectbox(
        "Run",
        list(by_name),
        key="run_picker",
        format_func=lambda name: _label(by_name[name]),
        on_change=lambda: st.session_state.update({RUN: st.session_state["run_picker"]}),
    )
    job = data.jobs().get(job_key(dataset))
    # A popover stays open until another one takes its place: once something was started in it
    state = f"{run.name} {None if job is None else job.started_s}"
    with middle.popover("New run", icon=":material/add:", width="stretch", key=f"new_run {state}"):
        _new_run(dataset, list(by_name))
    with right.popover("This run", icon=":material/more_horiz:", width="stretch", key=f"this_run {state}"):
        st.button(
            "Update",
            icon=":material/refresh:",
            on_click=_resume,
            args=(dataset, run),
            width="stretch",
            help="Estimates again where detections or files are new; the rest is read from the store.",
        )
        st.button("Delete", icon=":material/delete:", on_click=_delete, args=(run,), width="stretch", key="delete_run")
    return run


def _label(run: Run) -> str:
    state = "" if run.is_complete else f", {len(run.rows)} done"
    return f"{run.name} · {len(run.recordings)} recordings{state} · {run.created[:10]}"


def _about(dataset: Dataset, run: Run, *, is_running: bool) -> None:
    st.caption(f":material/tune: {evaluation.run_line(run)}")
    if run.is_complete or is_running:
        return
    left, right = st.columns([5, 1.4], vertical_alignment="center")
    left.warning(
        f"This run was stopped: {len(run.rows)} of {len(run.recordings)} recordings are estimated.",
        icon=":material/pause_circle:",
    )
    right.button("Go on", icon=":material/play_arrow:", on_click=_resume, args=(dataset, run), width="stretch")


def _new_run(dataset: Dataset, taken: list[str]) -> None:
    presets: dict[str, ShapeParameters] = dict(SHAPE_PRESETS)
    if not session.choice().is_preset:
        presets[OWN] = session.choice().shape
    preset = st.segmented_control(
        "Parameters of the fit", list(presets), default="paper", required=True, key="run_preset"
    )
    name = st.text_input("Name", _free_name(str(preset), taken), max_chars=60, key=f"run_name {preset} {len(taken)}")
    ids = _recordings_control(dataset)
    detector = _detector_control(dataset[ids[0]] if ids else None)
    for network, path in evaluation.missing_weights().items():
        st.caption(
            f":material/info: No {network} network: its weights are not in {plain(str(path))}. The run leaves out what "
            f"it would tell; train one with `python -m corsmal train {network} ROOT RUN` and name it in "
            f"`CORSMAL_{network.upper()}_WEIGHTS`."
        )
    job = data.jobs().get(job_key(dataset))
    is_running = job is not None and job.active
    if st.button("Run", type="primary", icon=":material/play_arrow:", disabled=not ids or is_running, key="start_run"):
        st.session_state[RUN] = name.strip()
        start(dataset, name, ids, presets[str(preset)], detector=detector)
        st.rerun()
    if is_running:
        st.caption("Another run on this dataset is being made.")


def _free_name(base: str, taken: list[str]) -> str:
    names = [base, *(f"{base} {number}" for number in range(2, len(taken) + 3))]
    return next(name for name in names if name not in taken)


def _recordings_control(dataset: Dataset) -> list[str]:
    filmed = [recording.id for recording in dataset if any(name in recording.views for name in METHOD_VIEWS)]
    groups = {"with a video": filmed, "all that are known": list(dataset.ids)}
    if len(filmed) == len(dataset):
        groups.pop("all that are known")
    groups["the chosen one"] = [str(session.choice().recording)]
    group = st.segmented_control(
        "Recordings",
        list(groups),
        default="with a video",
        required=True,
        key="run_recordings",
        format_func=lambda name: f"{name} ({len(groups[name])})",
    )
    return groups[str(group)]


def _detector_control(example: Recording | None) -> str | None:
    is_demo = example is not None and example.is_synthetic
    if not st.toggle(
        "First find containers where no detector has looked",
        value=is_demo,
        key="run_detects",
        help=f"Every {SEARCH_STEP}th frame, then from coarse to fine around the best. Without it, a recording that has "
        "no detections fails. From a terminal: `python -m corsmal detect ROOT`, for the demo with `--demo-weights`.",
    ):
        return None
    names = list(DETECTORS)
    return st.selectbox(
        "Detector",
        names,
        names.index("demo" if is_demo else "coco"),
        format_func=DETECTORS.__getitem__,
        key="run_detector",
    )


def start(dataset: Dataset, name: str, ids: list[str], shape: ShapeParameters, *, detector: str | None) -> None:
    """Begin or resume a run in the background."""
    work = partial(_work, dataset=dataset, name=name, ids=ids, shape=shape, detector=detector, store=data.store())
    data.jobs().start(job_key(dataset), f"Run {plain(name)}", work)


def _resume(dataset: Dataset, run: Run) -> None:
    start(dataset, run.name, list(run.recordings), run.shape, detector=None)


def _delete(run: Run) -> None:
    with guarded():
        delete_run(run.name, dataset=run.dataset, store=data.store())


def _work(
    job: Job, *, dataset: Dataset, name: str, ids: list[str], shape: ShapeParameters, detector: str | None, store: Store
) -> None:
    job.advance(0, len(ids))
    record_run(
        name,
        dataset,
        ids,
        evaluation.make_predictors(dataset, shape),
        store=store,
        progress=job.advance,
        cancelled=job.cancelled,
        before=None if detector is None else _finder(job, detector, store),
    )


def _finder(job: Job, name: str, store: Store) -> Callable[[Recording], None]:
    """Detects in recordings that lack detections; a recording that cannot be looked at fails later, with its reason."""
    detector = open_detector(name)

    def find(recording: Recording) -> None:
        lacking = set(load_detections(recording, store=store).missing) & set(recording.views)
        if lacking:
            try:
                detect_recording(recording, detector, store=store, every=SEARCH_STEP, cancelled=job.cancelled)
            except CorsmalError:
                return

    return find
