"""The errors of capacity and dimensions over a grid of settings."""

from collections.abc import Sequence

import pandas as pd

from corsmal.errors import ArgumentError
from corsmal.evaluation.checking import truth_table
from corsmal.evaluation.estimates import ID_COLUMN
from corsmal.evaluation.metrics import relative_errors
from corsmal.quantities import BY_NAME, GEOMETRY

MEASURED = {name: BY_NAME[name].metric for name in GEOMETRY}
"""What the hull gives, and the metric of each."""


def sweep_table(estimates: pd.DataFrame, annotation: pd.DataFrame, *, settings: Sequence[str]) -> pd.DataFrame:
    """MAPE of capacity and dimensions for each setting, in %.

    Args:
        estimates: a row per setting and recording: ``recording_id``, the columns named by ``settings``, and
            ``capacity_ml``, ``width_top_mm``, ``width_bottom_mm``, ``height_mm``, NaN where the fit failed.
        annotation: a dataset's table, or the columns of the annotation file.
        settings: names of the columns that make up a setting, such as ``circumferences``.

    Returns:
        A row per setting: its columns, the mean over the setting's recordings of each error, ``recordings`` (whose
        truth is known) and ``failures`` (those without an estimate, which are in no mean).

    Raises:
        ArgumentError: a column is missing, or no recording is in the annotation.
    """
    wanted = [ID_COLUMN, *settings, *MEASURED]
    absent = [name for name in wanted if name not in estimates]
    if absent or not settings:
        raise ArgumentError(f"estimates must have the columns {', '.join(wanted)}; missing: {', '.join(absent)}")
    truth = truth_table(annotation)[list(MEASURED)].dropna(how="any")
    known = estimates[estimates[ID_COLUMN].isin(truth.index)]
    if known.empty:
        raise ArgumentError("estimates have no recording whose capacity, widths and height the annotation knows")
    true = truth.loc[known[ID_COLUMN]]
    rows = known[list(settings)].reset_index(drop=True)
    for name, metric in MEASURED.items():
        rows[metric] = abs(relative_errors(known[name], true[name]))
    rows["recordings"], rows["failures"] = 1, rows[list(MEASURED.values())].isna().any(axis=1).astype("int64")
    means = dict.fromkeys(MEASURED.values(), "mean") | {"recordings": "sum", "failures": "sum"}
    return rows.groupby(list(settings), as_index=False).agg(means)
