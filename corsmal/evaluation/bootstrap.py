"""How much a metric varies with the recordings that happen to be in the set: bootstrap within containers."""

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from corsmal.errors import ArgumentError
from corsmal.evaluation.metrics import CLASS_NAMES, NO_ESTIMATE, f1_by_class
from corsmal.evaluation.tables import METRICS
from corsmal.geometry import Floats

RESAMPLES = 2000
LEVEL_PERCENT = (2.5, 97.5)
"""The ends of a 95 % interval."""


def draw_weights(recordings: int, *, resamples: int, rng: np.random.Generator) -> Floats:
    """How often each of a container's n recordings counts: once in row 0, as drawn in the rows after it.

    n − 1 of the n recordings are drawn with replacement: one less than there are, so that the spread is right for few
    recordings too (Rao and Wu, 1988).

    Returns:
        (1 + resamples, n).

    Raises:
        ArgumentError: resamples is below 100.
    """
    if resamples < 100:
        raise ArgumentError(f"resamples must be at least 100, got {resamples}")
    n = recordings
    drawn = rng.multinomial(n - 1, np.full(n, 1 / n), size=resamples) if n > 1 else np.ones((resamples, 1))
    return np.vstack([np.ones(n), drawn])


def weighted_metric(errors: pd.DataFrame, metric: str, weights: Floats, *, counts: NDArray[np.bool_]) -> Floats:
    """A metric of Table 2 over (n) rows of ``error_table``, for many sets of weights at once.

    Args:
        errors: of some recordings.
        metric: a key of ``METRICS``.
        weights: (m, n) how often each recording counts.
        counts: (n,) whether it counts at all; for a number, whether it has an error.

    Returns:
        (m,) in %; NaN where the weights leave nothing to compute it from.
    """
    column, weights = METRICS[metric], weights[:, counts]
    if column in CLASS_NAMES:
        truth = errors.loc[counts, f"{column}_true"].to_numpy(dtype=np.int64)
        answers = errors.loc[counts, column].to_numpy(dtype=np.int64, na_value=NO_ESTIMATE)
        scores, _ = f1_by_class(truth, answers, weights)
        return 100 * _ratio(np.nansum(scores, axis=1), (~np.isnan(scores)).sum(axis=1))
    return _ratio(weights @ np.abs(errors.loc[counts, column].to_numpy()), weights.sum(axis=1))


def interval(values: Floats, *, has_spread: bool) -> tuple[float, float]:
    """The 95 % interval of (1 + resamples,) values of ``weighted_metric``, NaN without a spread.

    A container with a single recording has none, nor has an average over one.
    """
    drawn = values[1:][np.isfinite(values[1:])]
    if not has_spread or not len(drawn):
        return np.nan, np.nan
    low, high = np.percentile(drawn, LEVEL_PERCENT)
    return float(low), float(high)


def _ratio(sums: Floats, counts: NDArray[Any]) -> Floats:
    """NaN where a draw has none of the recordings that count."""
    return np.divide(sums, counts, out=np.full(np.shape(sums), np.nan), where=counts > 0)
