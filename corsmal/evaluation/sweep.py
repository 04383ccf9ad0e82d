"""The errors of capacity and dimensions over a grid of settings, and which differences are more than noise."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from corsmal.errors import ArgumentError
from corsmal.evaluation.bootstrap import RESAMPLES, Floats, draw_weights, interval
from corsmal.evaluation.checking import truth_table
from corsmal.evaluation.estimates import ID_COLUMN
from corsmal.evaluation.metrics import relative_errors
from corsmal.quantities import BY_NAME, GEOMETRY

MEASURED = {name: BY_NAME[name].metric for name in GEOMETRY}
"""What the hull gives, and the metric of each."""

MEAN = "mean_mape"
"""The mean of the four errors of a recording."""


def sweep_table(
    estimates: pd.DataFrame,
    annotation: pd.DataFrame,
    *,
    reference: Mapping[str, float],
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> pd.DataFrame:
    """MAPE of capacity and dimensions for each setting, in %, beside that of a reference setting.

    The noise of a difference is that of a paired bootstrap: the recordings that both settings measure are drawn anew,
    the same ones for both.

    Args:
        estimates: a row per setting and recording: ``recording_id``, the columns named by ``reference``, and
            ``capacity_ml``, ``width_top_mm``, ``width_bottom_mm``, ``height_mm``, NaN where the fit failed.
        annotation: a dataset's table, or the columns of the annotation file.
        reference: the setting that all are compared with, by column, such as ``circumferences``.
        rng: draws the recordings.
        resamples: how many times, at least 100.

    Returns:
        A row per setting: its columns; for each error and for ``mean_mape`` the mean over the setting's recordings,
        and with ``_difference``, ``_low`` and ``_high`` what it is more than the reference's in the recordings that
        both measure, with its 95 % interval (NaN for one recording); ``recordings`` (whose truth is known) and
        ``failures`` (those without an estimate, which are in no mean).

    Raises:
        ArgumentError: a column or the reference is missing, or no recording is in the annotation.
    """
    settings = list(reference)
    wanted = [ID_COLUMN, *settings, *MEASURED]
    absent = [name for name in wanted if name not in estimates]
    if absent or not settings:
        raise ArgumentError(f"estimates must have the columns {', '.join(wanted)}; missing: {', '.join(absent)}")
    truth = truth_table(annotation)[list(MEASURED)].dropna(how="any")
    known = estimates[estimates[ID_COLUMN].isin(truth.index)]
    if known.empty:
        raise ArgumentError("estimates have no recording whose capacity, widths and height the annotation knows")
    true = truth.loc[known[ID_COLUMN]]
    errors = known[[ID_COLUMN, *settings]].reset_index(drop=True)
    for name, metric in MEASURED.items():
        errors[metric] = abs(relative_errors(known[name], true[name]))
    errors[MEAN] = errors[list(MEASURED.values())].mean(axis=1, skipna=False)
    groups = {key: group.set_index(ID_COLUMN) for key, group in errors.groupby(settings)}
    own = groups.get(tuple(reference.values()))
    if own is None:
        raise ArgumentError(f"estimates must have the reference setting, {dict(reference)}")
    weights = draw_weights(len(own), resamples=resamples, rng=rng)
    rows = [
        dict(zip(settings, key, strict=True)) | _setting(group.reindex(own.index), own, weights)
        for key, group in groups.items()
    ]
    return pd.DataFrame(rows)


def _setting(errors: pd.DataFrame, reference: pd.DataFrame, weights: Floats) -> dict[str, float]:
    """The errors of one setting, and how they differ from the reference's."""
    row: dict[str, float] = {"recordings": len(errors), "failures": int(errors[MEAN].isna().sum())}
    for metric in (*MEASURED.values(), MEAN):
        differences = (errors[metric] - reference[metric]).to_numpy(dtype=np.float64)
        both = np.isfinite(differences)
        sums, counts = weights[:, both] @ differences[both], weights[:, both].sum(axis=1)
        drawn = np.divide(sums, counts, out=np.full(len(sums), np.nan), where=counts > 0)
        low, high = interval(drawn, has_spread=both.sum() > 1)
        row |= {metric: errors[metric].mean(), f"{metric}_difference": drawn[0]}
        row |= {f"{metric}_low": low, f"{metric}_high": high}
    return row
