"""The form of a reproduction: its settings, its plan, and its start in the background."""

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.engines.local import local_engine
from corsmal.evaluation.typesetting import TITLES
from corsmal.parameters import SHAPE_PRESETS, FillingPreset
from corsmal.quantities import duration_text
from corsmal.runs.reproduction import StepProgress, reproduce
from corsmal.runs.reproduction_results import CancelledError
from corsmal.runs.reproduction_settings import (
    Folds,
    PlannedStep,
    Protocol,
    ReproductionSettings,
    plan,
)
from corsmal.ui import session, shared
from corsmal.ui.evaluation.new_run import detector_settings
from corsmal.ui.folders import allowed_folder
from corsmal.ui.job import Job
from corsmal.ui.messages import guarded
from corsmal.ui.one_of import one_of

if TYPE_CHECKING:
    from corsmal.filling.sight import FeatureFolders

PROTOCOLS: dict[Protocol, str] = {"held-out": TITLES["held-out"], "paper": TITLES["paper"]}
FOLDS: dict[Folds, str] = {"spread": "spread", "containers": "by container"}
NETWORKS: dict[FillingPreset, str] = {name: name for name in get_args(FillingPreset)}


def job_key(out: Path) -> str:
    """The key of the job that works in an output folder."""
    return f"reproduce {out}"


@st.fragment
@guarded()
def new_reproduction(dataset: Dataset, out: Path, *, is_running: bool) -> None:
    """Choose the settings, see the plan, start."""
    left, right = st.columns([3, 2], gap="medium")
    with left:
        settings, tests = _settings(dataset), _test_sets()
    with right:
        _show_plan(plan(dataset, settings, tests))
        if st.button(
            "Reproduce Table 2",
            type="primary",
            icon=":material/play_arrow:",
            disabled=is_running,
            key="start_reproduction",
            width="stretch",
        ):
            start(dataset, out, settings, tests)
            st.rerun()


def _settings(dataset: Dataset) -> ReproductionSettings:
    left, right = st.columns(2)
    with left:
        protocol = one_of(
            "Protocol",
            PROTOCOLS,
            key="reproduction_protocol",
            help_text="Held-out: no recording is judged by a network that was trained on it or chosen by it. Paper's: "
            "as published, epochs are chosen on the recordings that are judged.",
        )
        preset = one_of("Parameters of the fit", {name: name for name in SHAPE_PRESETS}, key="reproduction_preset")
        seeds = st.number_input("Seeds", 1, 20, key="reproduction_seeds", help="Number of cross-validations.")
    with right:
        folds = one_of(
            "Folds",
            FOLDS,
            key="reproduction_folds",
            help_text="spread: the networks know the containers from other recordings; by container: they do not.",
        )
        networks = one_of(
            "Presets of the networks",
            NETWORKS,
            key="reproduction_networks",
            help_text="released: networks, front end, masks and training of the authors' program; with the parameters "
            "released, too, all of it is reproduced.",
        )
        is_quick = st.toggle("Quick: a few epochs, for a first look", key="reproduction_quick")
    features = st.text_area(
        "Features, a folder per line",
        key="reproduction_features",
        height=68,
        placeholder="log-mel features of the sound",
        help="Folders of arrays, ID.npy, for the filling network. The networks *fused* need one of the videos, with "
        "rows of 512 numbers, which `features` writes.",
    )
    folders = _feature_folders([line.strip() for line in features.splitlines() if line.strip()])
    return ReproductionSettings(
        protocol=protocol,
        folds=folds,
        seeds=int(seeds),
        shape=SHAPE_PRESETS[preset],
        networks=networks,
        features=folders.sound,
        sight=folders.sight,
        detector=detector_settings(next(iter(dataset), None)),
        is_quick=is_quick,
        matching=session.choice().matching,
    )


def _feature_folders(names: list[str]) -> "FeatureFolders":
    """The folders that a visitor named, by what they hold."""
    from corsmal.filling.sight import FeatureFolders  # noqa: PLC0415 - PyTorch takes seconds to import

    return FeatureFolders.of([Path(allowed_folder(name)).expanduser().resolve() for name in names])


def _test_sets() -> list[Dataset]:
    folders = st.text_area(
        "Test sets, a folder per line",
        key="reproduction_tests",
        height=68,
        placeholder="/data/corsmal/test_pub",
        help="Each gets its submission, and its scores where it is annotated (Table 3).",
    )
    return [shared.dataset(allowed_folder(line.strip())) for line in folders.splitlines() if line.strip()]


def _show_plan(steps: list[PlannedStep]) -> None:
    st.markdown("**Plan**")
    rows = [(step.name, duration_text(step.seconds), step.what) for step in steps]
    st.dataframe(pd.DataFrame(rows, columns=["step", "time", "what"]), hide_index=True, height=38 + 35 * len(rows))
    together = duration_text(sum(step.seconds for step in steps))
    st.caption(f"Together about {together} on two cores where nothing is kept yet.")


def start(dataset: Dataset, out: Path, settings: ReproductionSettings, tests: list[Dataset]) -> None:
    """Begin or resume a reproduction in the background."""
    store = shared.store()

    def work(job: Job) -> None:
        def report(state: StepProgress) -> None:
            job.label = f"Reproducing Table 2, {state.step}"
            job.forecast(state.left_s)
            job.advance(round(100 * state.share), 100)

        with suppress(CancelledError):
            reproduce(
                dataset.root,
                out=out,
                settings=settings,
                tests=[test.root for test in tests],
                store=store,
                engine=local_engine(len(dataset), detects=settings.detector is not None, gives_way=True),
                progress=report,
                cancelled=job.cancelled,
            )

    shared.jobs().start(job_key(out), "Reproducing Table 2", work)
