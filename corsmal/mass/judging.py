"""How good restored masks and predicted masses are, row by row and by container."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from corsmal.errors import ArgumentError
from corsmal.mass.axis import AXIS_RULES
from corsmal.mass.records import MassRow
from corsmal.mass.restoration import PADDING_PX, restore_mask

if TYPE_CHECKING:
    from corsmal.mass.prediction import MassPredictor

Mask = NDArray[np.bool_]

TILTS_DEG = (0, 2, 5, 10, 20, 90)
"""Bounds of the classes of tilt."""

WORSE_IOU = 1e-9


def mask_iou(first: Mask, second: Mask) -> float:
    """Pixels in both masks by pixels in either, 0..1; 1 for two empty masks."""
    if first.shape != second.shape:
        raise ArgumentError(f"masks must have the same shape, got {first.shape} and {second.shape}")
    either = int((first | second).sum())
    return int((first & second).sum()) / either if either else 1.0


def judge_restoration(frames: Iterable[tuple[str, float, Mask, Mask]], *, padding_px: int = PADDING_PX) -> pd.DataFrame:
    """Restore masks whose whole silhouette is known, by each rule for the axis.

    Args:
        frames: container, true tilt of its axis in the image (degrees), visible and amodal mask.
        padding_px: around the mask's box.

    Returns:
        A row per frame: container, tilt_deg, ``hidden`` (the share of the silhouette that is not seen), ``before``
        (IoU of the visible and the amodal mask), and the IoU after restoring by each rule, ``base`` and ``whole``.
    """
    rows = []
    for container, tilt_deg, visible, amodal in frames:
        hidden = 1 - visible.sum() / max(int(amodal.sum()), 1)
        row = {"container": container, "tilt_deg": tilt_deg, "hidden": hidden, "before": mask_iou(visible, amodal)}
        for axis in AXIS_RULES:
            row[axis] = mask_iou(restore_mask(visible, padding_px=padding_px, axis=axis).mask, amodal)
        rows.append(row)
    return pd.DataFrame(rows, columns=["container", "tilt_deg", "hidden", "before", *AXIS_RULES])


def restoration_table(frames: pd.DataFrame, *, by: str = "container") -> pd.DataFrame:
    """Mean IoU before and after, and the share of frames that restoring makes worse.

    Args:
        frames: from ``judge_restoration``.
        by: ``container``, or ``tilt`` for classes of the tilt's size.

    Returns:
        A row per group and one, ``all``, of all frames: ``frames``, ``before``, and for each rule its mean IoU and
        ``worse_`` followed by its name, the share of frames whose IoU falls.
    """
    if by not in ("container", "tilt"):
        raise ArgumentError(f"by must be container or tilt, got {by!r}")
    groups = (
        frames["container"]
        if by == "container"
        else pd.cut(frames["tilt_deg"].abs(), list(TILTS_DEG), include_lowest=True).astype(str)
    )
    parts = {name: frames[groups == name] for name in sorted(groups.unique(), key=_first_number)} | {"all": frames}
    rows = {}
    for name, part in parts.items():
        row = {"frames": len(part), "before": part["before"].mean()}
        for axis in AXIS_RULES:
            row[axis] = part[axis].mean()
            row[f"worse_{axis}"] = (part[axis] < part["before"] - WORSE_IOU).mean()
        rows[name] = row
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis(by)


def judge_mass(predictor: "MassPredictor", rows: Iterable[MassRow]) -> pd.DataFrame:
    """Predict masses whose truth is known.

    Args:
        predictor: the network.
        rows: recordings with masks, dimensions and true masses.

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
    """Sorts 2 before 10, and what begins with no number last."""
    digits = text.lstrip("([-").split(",")[0]
    try:
        return float(digits), text
    except ValueError:
        return np.inf, text
