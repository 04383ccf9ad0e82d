"""What each part of the preset ``tuned`` is worth, on recordings whose truth is known."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from corsmal.dataset import Dataset, Recording
from corsmal.dataset.annotation import CONTAINERS
from corsmal.estimation import Estimate, estimate
from corsmal.parameters import SHAPE_PRESETS, ShapeParameters
from corsmal.quantities import GEOMETRY
from corsmal.runs.budget import Views, errors_pct
from corsmal.stages import true_views

MASKS = ("true", "detected")

GROUPS = ("all", "seen", "unseen")
"""Of the containers: training shows the demo's networks the annotated ones."""


def ablations() -> dict[str, ShapeParameters]:
    """The presets, and ``tuned`` less each of its parts, by name."""
    tuned = ShapeParameters.tuned()
    return {
        **SHAPE_PRESETS,
        "tuned, upright axis": replace(tuned, tilt_deg=0.0),
        "tuned, no boxes": replace(tuned, boxes=False),
        "tuned, two views": replace(tuned, all_views=False),
        "tuned, one frame": replace(tuned, frames=1),
        "tuned, no wall": replace(tuned, wall_mm=0.0),
    }


def ablation_errors(
    dataset: Dataset,
    detections_of: Callable[[Recording], Views],
    *,
    presets: Mapping[str, ShapeParameters] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> pd.DataFrame:
    """Percentage errors of the four quantities with every preset, with true and with detected masks.

    Args:
        dataset: a demo with its truth beside it.
        detections_of: gives the detections of a recording by view.
        presets: parameters of the fit by name; default: ``ablations``.
        progress: called with the numbers of recordings done and wanted.

    Returns:
        A row per recording, preset and kind of masks: recording, seen (whether training shows the container), preset,
        masks, the absolute error of each quantity in %, NaN where nothing could be fitted, and ``QUANTITY inside``,
        whether its interval holds the truth, 1 or 0, NaN where there is no interval.

    Raises:
        FileError: the truth of a recording cannot be read.
    """
    presets = ablations() if presets is None else presets
    rows = []
    recordings = list(dataset)
    for done, recording in enumerate(recordings, start=1):
        views = dict(zip(MASKS, (true_views(recording), detections_of(recording)), strict=True))
        seen = recording.annotation is not None and recording.annotation.container_id in CONTAINERS
        for masks, detections in views.items():
            for name, shape in presets.items():
                found = estimate(recording, detections=detections, shape=shape)
                errors = errors_pct(recording, [getattr(found, quantity) for quantity in GEOMETRY])
                kept: dict[str, Any] = {"recording": recording.id, "seen": seen, "preset": name, "masks": masks}
                rows.append({**kept, **errors, **_inside(found, recording)})
        if progress is not None:
            progress(done, len(recordings))
    return pd.DataFrame(rows)


def ablation_table(errors: pd.DataFrame) -> pd.DataFrame:
    """MAPE in %, failures, and the share of the truths inside their intervals in %, by masks, preset and containers."""
    groups = {"all": errors, "seen": errors[errors["seen"]], "unseen": errors[~errors["seen"]]}
    tables = {}
    for group in GROUPS:
        by_preset = groups[group].groupby(["masks", "preset"], sort=False)
        table = by_preset[list(GEOMETRY)].mean()
        table["failed"] = by_preset["capacity_ml"].apply(lambda values: int(values.isna().sum()))
        inside = by_preset[[f"{name} inside" for name in GEOMETRY]].mean()
        tables[group] = pd.concat([table, 100 * inside], axis=1)
    return (
        pd.concat(tables, names=["containers"])
        .reorder_levels(["masks", "preset", "containers"])
        .sort_index(level=["masks", "containers"], sort_remaining=False)
    )


def _inside(found: Estimate, recording: Recording) -> dict[str, float]:
    inside = {}
    for name in GEOMETRY:
        true, ends = getattr(recording.annotation, name, None), found.intervals.get(name)
        inside[f"{name} inside"] = np.nan if true is None or ends is None else float(ends[0] <= true <= ends[1])
    return inside
