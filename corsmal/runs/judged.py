"""A run held against the annotation of a dataset, for pages and reports."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from corsmal.dataset import Dataset
from corsmal.evaluation import cell_table, error_table, find_split
from corsmal.evaluation.flagged import without_flagged
from corsmal.evaluation.protocols import Protocol
from corsmal.evaluation.splits import FoundSplit
from corsmal.evaluation.summary import Headline, summary
from corsmal.runs.run import Run

RESAMPLES_SEED = 0
"""Of the bootstrap's draws: the same run has the same intervals wherever they are shown."""


@dataclass(frozen=True, eq=False)
class JudgedRun:
    """A run held against a dataset's annotation, with the tables that a report shows of it.

    Args:
        run: the run.
        dataset: has the annotation.
        protocol: which numbers of networks count.
        without: rows that raise one of these flags are left out, see ``without_flagged``.
    """

    run: Run
    dataset: Dataset
    protocol: Protocol
    without: tuple[str, ...] = ()

    @cached_property
    def _left(self) -> tuple[pd.DataFrame, str]:
        return without_flagged(self.run.table, self.without)

    @property
    def table(self) -> pd.DataFrame:
        """The run's estimates without the rows that are left out."""
        return self._left[0]

    @cached_property
    def errors(self) -> pd.DataFrame:
        """The error table; its notes say which rows are left out."""
        table, left_out = self._left
        errors = error_table(table, self.dataset.table, protocol=self.protocol)
        errors.attrs["notes"] = (*([left_out] if left_out else []), *errors.attrs["notes"])
        return errors

    @cached_property
    def cells(self) -> pd.DataFrame:
        """Table 2 cell by cell."""
        return cell_table(self.errors, rng=np.random.default_rng(RESAMPLES_SEED))

    @cached_property
    def headlines(self) -> tuple[Headline, ...]:
        """The run in a few numbers."""
        return summary(self.errors, self.cells, estimates=self.table, annotation=self.dataset.table)

    @cached_property
    def is_synthetic(self) -> bool | None:
        """Whether its recordings were rendered; None where some were."""
        kinds = {self.dataset[name].is_synthetic for name in self.errors.index}
        return kinds.pop() if len(kinds) == 1 else None

    @cached_property
    def split(self) -> FoundSplit:
        """Which of the challenge's sets the dataset is; rendered recordings are none."""
        if self.is_synthetic is not False:
            return FoundSplit("other", "its recordings are synthetic")
        return find_split(self.dataset.table, name=self.dataset.name)

    @property
    def is_like_with_like(self) -> bool:
        """Whether the published numbers are of the same recordings: the whole training set."""
        return self.split.split == "train" and len(self.errors) == len(self.dataset)
