"""The form of a new run, and starting or resuming one in the background."""

import time
from collections.abc import Sequence

import streamlit as st

from corsmal.dataset import Dataset, Recording
from corsmal.dataset.clock import Matching
from corsmal.dataset.layout import MASK_NAMES, Masks
from corsmal.engines.local import local_engine
from corsmal.errors import CorsmalError
from corsmal.parameters import METHOD_VIEWS, SELECTION_PRESETS, SHAPE_PRESETS, ShapeParameters, own_selection
from corsmal.runs.making import make_run
from corsmal.runs.names import NAME_MAX, check_name, numbered_names
from corsmal.runs.progress import RunProgress, Work
from corsmal.runs.run import Run
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
from corsmal.ui.job import Job
from corsmal.ui.messages import plain, show_problem
from corsmal.ui.one_of import one_of
from corsmal.weights import find_weights

OWN = "as on the Shape page"
SHOW_EVERY_S = 5.0
"""While a run is made the page shows its new rows this often."""

STAGES: dict[Work, str] = {"read": "read from the store", "detect": "detected and estimated", "estimate": "estimated"}


def job_key(dataset: Dataset) -> str:
    """The key of the job that estimates on a dataset: one for all tabs of the browser."""
    return f"evaluate {dataset.root}"


def new_run(dataset: Dataset, taken: list[str]) -> None:
    """The form of a new run.

    Args:
        dataset: that is estimated.
        taken: the names of the runs on it.
    """
    presets: dict[str, ShapeParameters] = dict(SHAPE_PRESETS)
    if not session.choice().is_preset:
        presets[OWN] = session.choice().shape
    preset = one_of("Parameters of the fit", {name: name for name in presets}, key="run_preset")
    free = next(name for name in numbered_names(preset) if name not in taken)
    name = st.text_input("Name", free, max_chars=NAME_MAX, key=f"run_name {preset} {len(taken)}")
    ids = _recordings_control(dataset)
    detector = detector_settings(dataset[ids[0]] if ids else None)
    for weights in (find_weights("filling"), find_weights("mass")):
        if not weights.path.is_file():
            st.caption(
                f":material/info: No {weights.kind} network: its weights are not in {plain(str(weights.path))}. "
                f"The run leaves out its estimates; train it with `python -m corsmal train {weights.kind} ROOT RUN` "
                f"and name it in `CORSMAL_{weights.kind.upper()}_WEIGHTS`."
            )
    own = own_selection(session.choice().preset if preset == OWN else preset)
    selections = [own, *(name for name in SELECTION_PRESETS if name != own)]
    selection = one_of("Rules for the best frame", {name: name for name in selections}, key=f"run_selection {own}")
    matching = session.choice().matching
    if matching != Matching():
        st.caption(f":material/schedule: The views of all recordings are matched {matching}, as on the *Frames* page.")
    masks: Masks = one_of("Masks", MASK_NAMES, key="run_masks", default=session.choice().masks)
    settings = default_settings(
        dataset,
        shape=presets[preset],
        selection=SELECTION_PRESETS[selection],
        detector=detector,
        matching=matching,
        masks=masks,
    )
    left_out = left_out_note(dataset, settings)
    if left_out:
        st.caption(f":material/info: {left_out}")
    is_running = shared.jobs().is_active(job_key(dataset))
    if st.button("Run", type="primary", icon=":material/play_arrow:", disabled=not ids or is_running, key="start_run"):
        try:
            session.choose(run=check_name(name, taken=taken))  # its id is known once it is begun
            start(dataset, name, ids, settings)
            st.rerun()
        except CorsmalError as error:
            show_problem(error)
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
    store, shown_s = shared.store(), time.monotonic()

    def work(job: Job) -> None:
        def watch(progress: RunProgress) -> None:
            nonlocal shown_s
            job.forecast(progress.left_s, is_at_most=progress.is_at_most)
            job.advance(progress.done, progress.total)
            job.part = progress.fraction * progress.total - progress.done
            job.detail = progress_detail(progress)
            if time.monotonic() - shown_s > SHOW_EVERY_S:
                shown_s = time.monotonic()
                job.keep()

        make_run(
            name,
            dataset,
            settings,
            store=store,
            recordings=ids,
            engine=local_engine(len(ids), detects=settings.detector is not None, gives_way=True),
            cancelled=job.cancelled,
            watch=watch,
            clock=job.worked_s,
        )

    shared.jobs().start(job_key(dataset), f"Run {plain(name)}", work)


def resume(dataset: Dataset, run: Run) -> None:
    """Make what a run lacks, with its own settings."""
    session.choose(run=run.short_id)
    start(dataset, run.name, run.recordings, run.settings)


def progress_detail(progress: RunProgress) -> str:
    """What each stage of a run has done, and why no time is named."""
    parts = [f"{STAGES[work]} {done} of {wanted}" for work, (done, wanted) in progress.stages.items()]
    text = f"Recordings {'; '.join(parts)}."
    if progress.frames is not None:
        text += f" Detecting: frame {progress.frames[0]} of {progress.frames[1]}."
    if progress.left_s is None and progress.done < progress.total:
        text += " The time left is known once each kind of work was timed."
    return text
