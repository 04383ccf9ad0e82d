"""Cached calls of the library for the Evaluation page: runs, their errors and what is computed from them."""

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.engines.tasks import EstimateTask
from corsmal.estimation import training_means
from corsmal.evaluation import (
    challenge_scores,
    changed_sides,
    compare_runs,
    container_table,
    error_table,
    estimates_table,
    submission_table,
)
from corsmal.evaluation.challenge import Split
from corsmal.parameters import SHAPE_PRESETS, ShapeParameters
from corsmal.quantities import QUANTITIES
from corsmal.runs.run import KIND, Run, list_runs
from corsmal.stages.estimates import Predictors
from corsmal.ui import data
from corsmal.weights import find_weights

METRIC_NAMES = {quantity.metric: quantity.label for quantity in QUANTITIES}
"""Table 2's metrics, as briefly as headings need."""

STAGE_PAGES = {quantity.metric: quantity.stage for quantity in QUANTITIES} | {"failures": "frames"}
"""The page of the stage that a number comes from."""

RESAMPLES_SEED = 0


def runs(dataset: Dataset) -> list[Run]:
    """The runs on a dataset, the newest first."""
    store, times = data.store(), []
    for key in store.keys(KIND):
        with suppress(FileNotFoundError):  # deleted by another session
            times.append((key, store.file(KIND, key, ".json").stat().st_mtime_ns))
    return _runs(str(store.root), tuple(times), str(dataset.root))


def run_line(run: Run) -> str:
    """A run's parameters, networks and files in one line of Markdown."""
    preset = next((name for name, shape in SHAPE_PRESETS.items() if shape == run.shape), None)
    named = "own parameters" if preset is None else f"preset `{preset}`"
    parts = [f"{named} (L {run.shape.circumferences}, d_max {run.shape.max_difference_mm:g} mm)"]
    if run.shape.method == "outlines":
        parts = [f"{named} (outlines of up to {run.shape.frames} frames)"]
    for part in ("filling", "mass"):
        digest = run.networks.get(part)
        parts.append(f"no {part} network" if digest is None else f"{part} network `{digest.split()[-1][:8]}`")
    count = f"{len(run.rows)} of {len(run.recordings)} recordings"
    return " · ".join([*parts, count, f"files `{run.data_digest[:8]}`", run.created.replace("T", " ")[:16] + " UTC"])


def estimates(run: Run) -> pd.DataFrame:
    """A run's estimates table."""
    return _estimates(run.key, _run=run)


def errors(run: Run, dataset: Dataset) -> pd.DataFrame:
    """A run's error table.

    Raises:
        ArgumentError: run and annotation have no recording in common.
    """
    return _errors(run.key, annotation_key(dataset), _run=run, _dataset=dataset)


def containers(run: Run, dataset: Dataset) -> pd.DataFrame:
    """A run's Table 2.

    Raises:
        ArgumentError: no recording's container is known.
    """
    return _containers(run.key, annotation_key(dataset), _run=run, _dataset=dataset)


def scores(run: Run, dataset: Dataset, *, split: Split) -> pd.Series:
    """The challenge's scores of a run, with ``attrs["notes"]``.

    Raises:
        ArgumentError: run and annotation have no recording in common.
    """
    return _scores(run.key, annotation_key(dataset), split, _run=run, _dataset=dataset)


def comparison(first: Run, second: Run, dataset: Dataset) -> pd.DataFrame:
    """Paired differences of two runs, see ``compare_runs``.

    Raises:
        ArgumentError: they have nothing in common that could be compared.
    """
    return _comparison(first.key, second.key, annotation_key(dataset), _runs=(first, second), _dataset=dataset)


def sides(first: Run, second: Run, dataset: Dataset, *, threshold_percent: float) -> pd.DataFrame:
    """The recordings that changed sides between two runs, see ``changed_sides``.

    Raises:
        ArgumentError: they have no recording in common.
    """
    return changed_sides(errors(first, dataset), errors(second, dataset), threshold_percent=threshold_percent)


def is_annotated(dataset: Dataset) -> bool:
    """Whether there is any truth that an estimate could be held against."""
    return bool(dataset.table["capacity_ml"].notna().any() or dataset.table["filling_type"].notna().any())


def is_training_set(dataset: Dataset) -> bool:
    """Whether a dataset's annotation looks like the challenge's training set."""
    known = dataset.table["container_id"]
    return len(known) == 684 and bool(known.isin(range(1, 10)).all())


def make_predictors(dataset: Dataset, shape: ShapeParameters) -> Predictors:
    """What a run is made with: the networks whose weights are there. Loads PyTorch; for a job, not for a page.

    Raises:
        FileError: a network's weights are broken.
    """
    weights = {name: path for name, path in _weights().items() if path.is_file()}
    means = tuple(training_means(dataset.table).items())
    task = EstimateTask(data.store().root, shape, means, weights.get("filling"), weights.get("mass"))
    return task.predictors()


def missing_weights() -> dict[str, Path]:
    """The networks whose weights are not there, with the file that was looked for."""
    return {name: path for name, path in _weights().items() if not path.is_file()}


def _weights() -> dict[str, Path]:
    return {"filling": find_weights("filling").path, "mass": find_weights("mass").path}


def annotation_key(dataset: Dataset) -> str:
    """What is cached for an annotation is not used once it changed."""
    hashes = pd.util.hash_pandas_object(dataset.table)
    return f"{dataset.root} {int(hashes.sum())}"


@st.cache_resource(max_entries=8, show_spinner=False)
def _runs(folder: str, times: Sequence[tuple[str, int]], root: str) -> list[Run]:
    del folder, times  # part of the key alone
    return list_runs(store=data.store(), dataset=root)


@st.cache_resource(max_entries=8, show_spinner=False)
def _estimates(key: str, *, _run: Run) -> pd.DataFrame:
    del key
    return estimates_table(_run.rows)


@st.cache_resource(max_entries=8, show_spinner=False)
def _errors(key: str, annotation: str, *, _run: Run, _dataset: Dataset) -> pd.DataFrame:
    del annotation
    return error_table(_estimates(key, _run=_run), _dataset.table)


@st.cache_resource(max_entries=8, show_spinner=False)
def _containers(key: str, annotation: str, *, _run: Run, _dataset: Dataset) -> pd.DataFrame:
    return container_table(_errors(key, annotation, _run=_run, _dataset=_dataset))


@st.cache_resource(max_entries=8, show_spinner=False)
def _scores(key: str, annotation: str, split: Split, *, _run: Run, _dataset: Dataset) -> pd.Series:
    del annotation
    return challenge_scores(_dataset.table, submission_table(_estimates(key, _run=_run)), split=split)


@st.cache_resource(max_entries=8, show_spinner="Drawing recordings, 2000 times")
def _comparison(first: str, second: str, annotation: str, *, _runs: tuple[Run, Run], _dataset: Dataset) -> pd.DataFrame:
    del first, second, annotation
    tables = [errors(run, _dataset) for run in _runs]
    return compare_runs(tables[0], tables[1], rng=np.random.default_rng(RESAMPLES_SEED))
