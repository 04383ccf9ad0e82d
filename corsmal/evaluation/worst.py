"""The recordings that a run estimates worst, over all quantities or in one."""

import numpy as np
import pandas as pd

from corsmal.evaluation.metrics import CLASS_NAMES
from corsmal.evaluation.tables import METRICS, is_judged, recordings_behind

WRONG_PERCENT = 100.0
"""What a wrong class, a missing number, and any larger error count for in the mean over quantities."""


def worst_recordings(errors: pd.DataFrame, *, metric: str | None = None, count: int = 10) -> pd.DataFrame:
    """The worst recordings first.

    Args:
        errors: from ``error_table``.
        metric: a key of ``METRICS``; None: over all quantities that count, by the mean of their errors, in which an
            error counts for 100 % at most, as does a wrong class or a missing estimate.
        count: how many at most.

    Returns:
        Rows of ``errors``, with ``mean_error``, that mean in %; none that has nothing to judge.

    Raises:
        ArgumentError: it is no error table, or the metric is unknown.
    """
    means = _mean_errors(errors)
    if metric is not None:
        rows = recordings_behind(errors, metric).head(count)
        return rows.assign(mean_error=means[rows.index])
    order = means.dropna().sort_values(ascending=False, kind="stable").head(count)
    return errors.loc[order.index].assign(mean_error=order)


def _mean_errors(errors: pd.DataFrame) -> pd.Series:
    parts = {}
    for metric, column in METRICS.items():
        if column in CLASS_NAMES:
            is_wrong = ~errors[f"{column}_correct"].fillna(value=True).astype("bool")
            part = WRONG_PERCENT * is_wrong.astype("float64")
        else:
            part = errors[column].abs().astype("float64").fillna(WRONG_PERCENT).clip(upper=WRONG_PERCENT)
        parts[metric] = part.where(is_judged(errors, metric), np.nan)
    return pd.DataFrame(parts, index=errors.index).mean(axis=1)
