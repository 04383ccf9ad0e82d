"""What the steps of a reproduction leave for its files."""

from dataclasses import dataclass

import pandas as pd

from corsmal.dataset import Dataset
from corsmal.errors import CorsmalError

STOPPED = "The reproduction was stopped; what was done is kept, and the same call resumes it."


class CancelledError(CorsmalError):
    """Work was ended by its caller."""


@dataclass(frozen=True, eq=False)
class TestResult:
    """A test set's estimates.

    Args:
        name: the test set's name, different from the others'.
        dataset: the test set.
        rows: an estimates table.
    """

    name: str
    dataset: Dataset
    rows: pd.DataFrame


@dataclass(frozen=True, eq=False)
class Results:
    """What the steps found.

    Args:
        dataset: the training set.
        rows: estimates of the first seed.
        more_seeds: those of the other seeds.
        rounds: filling predictions of the round whose kept epoch has the least loss (paper, Fig. 3); None where it is
            not the paper's protocol or nothing was trained.
        tests: the test sets' estimates.
        notes: sentences on what was missing or left out.
    """

    dataset: Dataset
    rows: pd.DataFrame
    more_seeds: tuple[pd.DataFrame, ...]
    rounds: pd.DataFrame | None
    tests: tuple[TestResult, ...]
    notes: tuple[str, ...]
