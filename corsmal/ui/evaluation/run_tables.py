"""Cached calls of the library for the Evaluation page: runs, their errors and what is computed from them."""

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.evaluation import (
    cell_table,
    challenge_scores,
    changed_sides,
    compare_runs,
    container_table,
    error_table,
    find_split,
    submission_table,
)
from corsmal.evaluation.challenge import Absent
from corsmal.evaluation.protocols import Protocol
from corsmal.evaluation.splits import FoundSplit, Split
from corsmal.quantities import QUANTITIES
from corsmal.runs.run import KIND, Run, list_runs
from corsmal.ui import shared

METRIC_NAMES = {quantity.metric: quantity.label for quantity in QUANTITIES}
"""Table 2's metrics, as briefly as headings need."""

STAGE_PAGES = {quantity.metric: quantity.stage for quantity in QUANTITIES} | {"failures": "frames"}
"""The page of the stage that a number comes from."""

RESAMPLES_SEED = 0

PROTOCOL = "evaluation_protocol"


def annotation_key(dataset: Dataset) -> str:
    """What is cached for an annotation is not used once it changed."""
    hashes = pd.util.hash_pandas_object(dataset.table)
    return f"{dataset.root} {int(hashes.sum())}"


KEYS: dict[Any, Any] = {Run: lambda run: run.key, Dataset: annotation_key}
"""What stands for a run and a dataset in the keys of the caches."""


def runs(dataset: Dataset) -> list[Run]:
    """The runs on a dataset, made here or by command, the newest first."""
    store, times = shared.store(), []
    for key in store.keys(KIND):
        with suppress(FileNotFoundError):  # deleted by another session
            times.append((key, store.file(KIND, key, ".json").stat().st_mtime_ns))
    return _runs(str(store.root), tuple(times), str(dataset.root))


@st.cache_resource(max_entries=8, show_spinner=False)
def _runs(folder: str, times: Sequence[tuple[str, int]], root: str) -> list[Run]:
    del folder, times  # part of the key only
    return list_runs(store=shared.store(), dataset=root)


def protocol() -> Protocol:
    """Which numbers of networks count, as this session has chosen."""
    chosen: Protocol = st.session_state.get(PROTOCOL, "held-out")
    return chosen


def errors(run: Run, dataset: Dataset) -> pd.DataFrame:
    """A run's error table, by the session's protocol.

    Raises:
        ArgumentError: run and annotation have no recording in common.
    """
    return _errors(run, dataset, protocol())


def containers(run: Run, dataset: Dataset) -> pd.DataFrame:
    """A run's Table 2, by the session's protocol.

    Raises:
        ArgumentError: no recording's container is known.
    """
    return container_table(errors(run, dataset))


def cells(run: Run, dataset: Dataset, *protocols: Protocol) -> pd.DataFrame:
    """A run's Table 2 cell by cell, by each protocol; by the session's if none is named.

    Raises:
        ArgumentError: no recording's container is known.
    """
    return pd.concat([_cells(run, dataset, name) for name in protocols or (protocol(),)], ignore_index=True)


def scores(run: Run, dataset: Dataset, *, split: Split, absent: Absent = "skip") -> pd.Series:
    """The challenge's scores of a run by the session's protocol, with ``attrs["notes"]``.

    Raises:
        ArgumentError: run and annotation have no recording in common.
    """
    return _scores(run, dataset, protocol(), split, absent)


def comparison(first: Run, second: Run, dataset: Dataset) -> pd.DataFrame:
    """Paired differences of two runs by the session's protocol, see ``compare_runs``.

    Raises:
        ArgumentError: they have nothing in common that could be compared.
    """
    return _comparison(first, second, dataset, protocol())


@st.cache_resource(max_entries=8, show_spinner=False, hash_funcs=KEYS)
def _errors(run: Run, dataset: Dataset, protocol: Protocol) -> pd.DataFrame:
    return error_table(run.table, dataset.table, protocol=protocol)


@st.cache_resource(max_entries=8, show_spinner=False, hash_funcs=KEYS)
def _cells(run: Run, dataset: Dataset, protocol: Protocol) -> pd.DataFrame:
    return cell_table(_errors(run, dataset, protocol), rng=np.random.default_rng(RESAMPLES_SEED))


@st.cache_resource(max_entries=8, show_spinner=False, hash_funcs=KEYS)
def _scores(run: Run, dataset: Dataset, protocol: Protocol, split: Split, absent: Absent) -> pd.Series:
    submission, judged = submission_table(run.table), _errors(run, dataset, protocol)
    return challenge_scores(dataset.table, submission, split=split, absent=absent, errors=judged)


@st.cache_resource(max_entries=8, show_spinner="Drawing recordings, 2000 times", hash_funcs=KEYS)
def _comparison(first: Run, second: Run, dataset: Dataset, protocol: Protocol) -> pd.DataFrame:
    tables = [_errors(run, dataset, protocol) for run in (first, second)]
    return compare_runs(tables[0], tables[1], rng=np.random.default_rng(RESAMPLES_SEED))


def sides(first: Run, second: Run, dataset: Dataset, *, threshold_percent: float) -> pd.DataFrame:
    """The recordings that changed sides between two runs, see ``changed_sides``.

    Raises:
        ArgumentError: they have no recording in common.
    """
    return changed_sides(errors(first, dataset), errors(second, dataset), threshold_percent=threshold_percent)


def is_annotated(dataset: Dataset) -> bool:
    """Whether there is any truth that an estimate could be held against."""
    return bool(dataset.table["capacity_ml"].notna().any() or dataset.table["filling_type"].notna().any())


def split(dataset: Dataset) -> FoundSplit:
    """Which of the challenge's sets a dataset is."""
    return find_split(dataset.table, name=dataset.name)
