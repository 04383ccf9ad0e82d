"""How good predicted masses are, row by row and by container, and how alike two silhouettes."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from corsmal.errors import ArgumentError
from corsmal.mass.axis import Mask
from corsmal.mass.records import MassRow

if TYPE_CHECKING:
    from corsmal.mass.prediction import MassPredictor


def mask_iou(first: Mask, second: Mask) -> float:
    """Pixels in both masks by pixels in either, 0..1; 1 for two empty masks."""
    if first.shape != second.shape:
        raise ArgumentError(f"masks must have the same shape, got {first.shape} and {second.shape}")
    either = int((first | second).sum())
    return int((first & second).sum()) / either if either else 1.0


def judge_mass(predictor: "MassPredictor", rows: Iterable[MassRow]) -> pd.DataFrame:
    """Predict masses whose truth is known.

    Returns:
        A row per recording: recording_id, container, true_g, mass_g (NaN where there is no prediction), reason.
    """
    found = []
    for row in rows:
        prediction = predictor.predict(
            row.mask,
            width_top_mm=row.width_top_mm,
            width_bottom_mm=row.width_bottom_mm,
            height_mm=row.height_mm,
            mm_per_px=row.mm_per_px,
        )
        mass_g = np.nan if prediction.mass_g is None else prediction.mass_g
        found.append((row.recording_id, row.container, row.mass_g, mass_g, prediction.reason))
    return pd.DataFrame(found, columns=["recording_id", "container", "true_g", "mass_g", "reason"])


def mass_table(judged: pd.DataFrame) -> pd.DataFrame:
    """MAPE and challenge score by container (spec's s7: the mean of exp(-|e - t| / t), 0 where there is no estimate).

    Args:
        judged: from ``judge_mass``; ``mass_g`` may be replaced by another estimate, such as a mean.

    Returns:
        A row per container and the mean of these, ``average``: ``recordings``, ``failed`` (in no MAPE), ``true_g``,
        ``mean_g`` of the estimates, ``mape`` in % and ``s7`` in %.
    """
    shares = (judged["mass_g"] - judged["true_g"]).abs() / judged["true_g"]
    scores = (100 * shares.map(lambda share: np.exp(-share))).fillna(0)
    judged = judged.assign(mape=100 * shares, s7=scores, failed=judged["mass_g"].isna())
    grouped = judged.groupby("container")
    table = pd.DataFrame(
        {
            "recordings": grouped.size(),
            "failed": grouped["failed"].sum(),
            "true_g": grouped["true_g"].mean(),
            "mean_g": grouped["mass_g"].mean(),
            "mape": grouped["mape"].mean(),
            "s7": grouped["s7"].mean(),
        }
    )
    table = table.loc[sorted(table.index, key=_first_number)]
    average = table.mean()
    average[["recordings", "failed"]] = table[["recordings", "failed"]].sum()
    table.loc["average"] = average
    return table.astype({"recordings": int, "failed": int})


def _first_number(text: str) -> tuple[float, str]:
    """Sorts 2 before 10, and what is not a number last."""
    try:
        return float(text), text
    except ValueError:
        return np.inf, text
