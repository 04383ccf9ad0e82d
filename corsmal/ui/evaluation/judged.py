"""Runs as a session judges them, and what is computed from that, cached."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.evaluation import (
    attribution_table,
    challenge_scores,
    changed_sides,
    compare_runs,
    container_table,
    find_split,
    submission_table,
    sweep_table,
)
from corsmal.evaluation.challenge import Absent
from corsmal.evaluation.protocols import Protocol
from corsmal.evaluation.splits import FoundSplit, Split
from corsmal.evaluation.summary import Headline
from corsmal.quantities import QUANTITIES
from corsmal.runs.judged import RESAMPLES_SEED, JudgedRun
from corsmal.runs.keeping import DELETED, DeletedRun, deleted_runs
from corsmal.runs.run import KIND, LABELS, Run, list_runs
from corsmal.runs.sweep import Grid
from corsmal.ui import shared
from corsmal.ui.caching import by_key, cached

METRIC_NAMES = {quantity.metric: quantity.label for quantity in QUANTITIES}
"""Table 2's metrics, as briefly as headings need."""


@dataclass(frozen=True)
class Judged:
    """A run held against the annotation of a dataset.

    Its methods raise an ``ArgumentError`` where run and annotation have nothing in common.

    Args:
        run: the run.
        dataset: has the annotation.
        protocol: which numbers of networks count.
        without: flags whose rows are left out.
    """

    run: Run
    dataset: Dataset
    protocol: Protocol
    without: tuple[str, ...] = ()

    @cached_property
    def key(self) -> tuple[object, ...]:
        """What is cached is not used once the run's rows or the annotation changed."""
        annotation = int(pd.util.hash_pandas_object(self.dataset.table).sum())
        return self.run.key, str(self.dataset.root), annotation, self.protocol, self.without

    @property
    def split(self) -> FoundSplit:
        """Which of the challenge's sets the dataset is."""
        return find_split(self.dataset.table, name=self.dataset.name)

    @cached(32)
    def _kept(self) -> JudgedRun:
        return JudgedRun(self.run, self.dataset, self.protocol, self.without)

    @property
    def table(self) -> pd.DataFrame:
        """The run's estimates without the rows that are left out."""
        return self._kept().table

    def errors(self) -> pd.DataFrame:
        """The error table."""
        return self._kept().errors

    def cells(self) -> pd.DataFrame:
        """Table 2 cell by cell."""
        return self._kept().cells

    @cached(8)
    def scores(self, split: Split, absent: Absent = "skip") -> pd.Series:
        """The challenge's scores, with ``attrs["notes"]``."""
        submission = submission_table(self.table)
        return challenge_scores(self.dataset.table, submission, split=split, absent=absent, errors=self.errors())

    def _first(self, run: Run) -> "Judged":
        return replace(self, run=run)

    @cached(8, key=lambda judged, first: (by_key(judged), first.key), spinner="Computing intervals from 2000 resamples")
    def compared_with(self, first: Run) -> pd.DataFrame:
        """Paired differences of an earlier run and this one, see ``compare_runs``."""
        return compare_runs(self._first(first).errors(), self.errors(), rng=np.random.default_rng(RESAMPLES_SEED))

    @cached(8, key=lambda judged, _replaced: by_key(judged), spinner="Computing intervals")
    def attributed(self, replaced: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
        """What goes away with each stage replaced by the truth, see ``attribution_table``."""
        rng = np.random.default_rng(RESAMPLES_SEED)
        return attribution_table(self.table, replaced, self.dataset.table, rng=rng, protocol=self.protocol)

    @cached(8, key=lambda judged, grid, _rows: by_key(judged, grid))
    def swept(self, grid: Grid, rows: list[dict[str, Any]]) -> pd.DataFrame:
        """Errors over a grid of settings beside those with the run's own, see ``sweep_table``."""
        own = {axis.name: getattr(self.run.settings.shape, axis.name) for axis in (grid.across, grid.down)}
        rng = np.random.default_rng(RESAMPLES_SEED)
        return sweep_table(pd.DataFrame(rows), self.dataset.table, reference=own, rng=rng)

    def summary(self) -> tuple[Headline, ...]:
        """The run in a few numbers."""
        return self._kept().headlines

    def changed_from(self, first: Run, *, threshold_percent: float) -> pd.DataFrame:
        """The recordings that changed sides since an earlier run, see ``changed_sides``."""
        return changed_sides(self._first(first).errors(), self.errors(), threshold_percent=threshold_percent)


def runs(dataset: Dataset) -> list[Run]:
    """The runs on a dataset, made here or by command, the newest first."""
    return _runs(str(dataset.root), file_times(KIND, LABELS))


def file_times(*kinds: str) -> list[tuple[str, int]]:
    """What tells whether kept results of some kinds changed: the times of their files."""
    store, times = shared.store(), []
    for kind in kinds:
        for key in store.keys(kind):
            with suppress(FileNotFoundError):  # deleted by another session
                times.append((key, store.file(kind, key, ".json").stat().st_mtime_ns))
    return times


@cached(8, key=lambda root, times: (str(shared.store().root), root, times))
def _runs(root: str, times: list[tuple[str, int]]) -> list[Run]:
    del times
    return list_runs(store=shared.store(), dataset=root)


def deleted(dataset: Dataset) -> list[DeletedRun]:
    """The runs on a dataset that can be brought back, the last deleted first."""
    return _deleted(str(dataset.root), file_times(DELETED, LABELS))


@cached(8, key=lambda root, times: (str(shared.store().root), root, times))
def _deleted(root: str, times: list[tuple[str, int]]) -> list[DeletedRun]:
    del times
    return deleted_runs(store=shared.store(), dataset=root)


@cached(64)
def averages(judged: Judged) -> pd.Series:
    """The last row of Table 2, without intervals."""
    return container_table(judged.errors()).iloc[-1]


def has_truth(dataset: Dataset) -> bool:
    """Whether there is any truth that an estimate could be held against; if not, the page says what to do."""
    if dataset.table[["capacity_ml", "filling_type"]].notna().to_numpy().any():
        return True
    st.info(
        "There is no annotation with a truth here, so nothing can be evaluated: put `ccm_train_annotation.json` (or "
        "`.csv`) into the dataset's folder.",
        icon=":material/rule:",
    )
    return False
