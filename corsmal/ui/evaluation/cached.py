"""Cached calls of the library for the Evaluation page: runs, their errors and what is computed from them."""

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.evaluation import (
    challenge_scores,
    changed_sides,
    compare_runs,
    container_table,
    error_table,
    submission_table,
)
from corsmal.evaluation.challenge import Split
from corsmal.quantities import QUANTITIES
from corsmal.runs.run import KIND, Run, list_runs
from corsmal.ui import data

METRIC_NAMES = {quantity.metric: quantity.label for quantity in QUANTITIES}
"""Table 2's metrics, as briefly as headings need."""

STAGE_PAGES = {quantity.metric: quantity.stage for quantity in QUANTITIES} | {"failures": "frames"}
"""The page of the stage that a number comes from."""

RESAMPLES_SEED = 0


def annotation_key(dataset: Dataset) -> str:
    """What is cached for an annotation is not used once it changed."""
    hashes = pd.util.hash_pandas_object(dataset.table)
    return f"{dataset.root} {int(hashes.sum())}"


KEYS: dict[Any, Any] = {Run: lambda run: run.key, Dataset: annotation_key}
"""What stands for a run and a dataset in the keys of the caches."""


def runs(dataset: Dataset) -> list[Run]:
    """The runs on a dataset, made here or by command, the newest first."""
    store, times = data.store(), []
    for key in store.keys(KIND):
        with suppress(FileNotFoundError):  # deleted by another session
            times.append((key, store.file(KIND, key, ".json").stat().st_mtime_ns))
    return _runs(str(store.root), tuple(times), str(dataset.root))


@st.cache_resource(max_entries=8, show_spinner=False)
def _runs(folder: str, times: Sequence[tuple[str, int]], root: str) -> list[Run]:
    del folder, times  # part of the key only
    return list_runs(store=data.store(), dataset=root)


@st.cache_resource(max_entries=8, show_spinner=False, hash_funcs=KEYS)
def errors(run: Run, dataset: Dataset) -> pd.DataFrame:
    """A run's error table.

    Raises:
        ArgumentError: run and annotation have no recording in common.
    """
    return error_table(run.table, dataset.table)


@st.cache_resource(max_entries=8, show_spinner=False, hash_funcs=KEYS)
def containers(run: Run, dataset: Dataset) -> pd.DataFrame:
    """A run's Table 2.

    Raises:
        ArgumentError: no recording's container is known.
    """
    return container_table(errors(run, dataset))


@st.cache_resource(max_entries=8, show_spinner=False, hash_funcs=KEYS)
def scores(run: Run, dataset: Dataset, *, split: Split) -> pd.Series:
    """The challenge's scores of a run, with ``attrs["notes"]``.

    Raises:
        ArgumentError: run and annotation have no recording in common.
    """
    return challenge_scores(dataset.table, submission_table(run.table), split=split)


@st.cache_resource(max_entries=8, show_spinner="Drawing recordings, 2000 times", hash_funcs=KEYS)
def comparison(first: Run, second: Run, dataset: Dataset) -> pd.DataFrame:
    """Paired differences of two runs, see ``compare_runs``.

    Raises:
        ArgumentError: they have nothing in common that could be compared.
    """
    rng = np.random.default_rng(RESAMPLES_SEED)
    return compare_runs(errors(first, dataset), errors(second, dataset), rng=rng)


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
