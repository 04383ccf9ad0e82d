"""The error budget of the geometry: which stage loses what, on recordings whose truth is known."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from corsmal.dataset import Dataset, Recording
from corsmal.detection import Detector, ViewDetections, detect_view
from corsmal.estimation import estimate, fit_frame
from corsmal.parameters import METHOD_VIEWS, PAIRS, ShapeParameters
from corsmal.quantities import GEOMETRY
from corsmal.selection import select_best_frame
from corsmal.stages import true_views

WAYS = ("true masks", "detected masks", "detected masks, true best frame")

Views = Mapping[str, ViewDetections]


def geometry_budget(
    dataset: Dataset,
    detections_of: Callable[[Recording], Views],
    *,
    detector: Detector | None = None,
    shape: ShapeParameters | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> pd.DataFrame:
    """Percentage errors of the four quantities for every recording, with more and more of the truth taken away.

    Args:
        dataset: a demo with its truth beside it.
        detections_of: gives the detections of a recording by view.
        detector: detects in the true best frames; default: they are looked for among the detections, which may lack
            them.
        shape: parameters of the fit; default: the paper's.
        progress: called with the numbers of recordings done and wanted.

    Returns:
        A row per recording and way (``WAYS``): recording, container, way, status, and the absolute error of each
        quantity in %, NaN in all four where nothing could be fitted.

    Raises:
        FileError: the truth of a recording cannot be read.
    """
    rows = []
    recordings = list(dataset)
    for done, recording in enumerate(recordings, start=1):
        true = true_views(recording)
        found = detections_of(recording)
        frames = true_best_frames(true)
        there = _only(frames, found) if detector is None else _detected(recording, frames, detector)
        for way, views in zip(WAYS, (true, found, there), strict=True):
            result = estimate(recording, detections=views, shape=shape)
            errors = errors_pct(recording, [getattr(result, name) for name in GEOMETRY])
            name = recording.annotation.container if recording.annotation else None
            rows.append({"recording": recording.id, "container": name, "way": way, "status": result.status, **errors})
        if progress is not None:
            progress(done, len(recordings))
    return pd.DataFrame(rows)


def budget_table(budget: pd.DataFrame) -> pd.DataFrame:
    """MAPE by container and way, and the number of recordings that could not be fitted, which are in no mean."""
    grouped = budget.groupby(["container", "way"], sort=False)
    table = grouped[list(GEOMETRY)].mean()
    table["failed"] = grouped["capacity_ml"].apply(lambda errors: int(errors.isna().sum()))
    average = table.groupby(level="way", sort=False).mean()
    average["failed"] = table["failed"].groupby(level="way", sort=False).sum()
    average.index = pd.MultiIndex.from_product([["average"], average.index], names=["container", "way"])
    return pd.concat([table, average])


def score_against_error(dataset: Dataset, *, step: int = 3, shape: ShapeParameters | None = None) -> pd.DataFrame:
    """View Score of frames beside the error of the fit in them, with true masks and the first pair of views.

    Args:
        dataset: a demo with its truth beside it.
        step: every so many frames.
        shape: parameters of the fit; default: the paper's.

    Returns:
        A row per frame that could be fitted: recording, container, frame, score (pixels), error_pct (mean of the
        four quantities'), and ``rank``, ``error_rank``: their ranks within the recording, 0..1.
    """
    rows = []
    for recording in dataset:
        true = true_views(recording)
        best = select_best_frame(true, pair=PAIRS[0])
        for score in best.scores[::step]:
            if score.total is None:
                continue
            fit = fit_frame(
                recording, true, pair=best.pair, frame=score.frame, centre_rule=best.centre_rule, shape=shape
            )
            values = [getattr(fit.dimensions, name) for name in GEOMETRY]
            error = float(np.mean(list(errors_pct(recording, values).values())))
            name = recording.annotation.container if recording.annotation else None
            rows.append((recording.id, name, score.frame, score.total, error))
    table = pd.DataFrame(rows, columns=["recording", "container", "frame", "score", "error_pct"]).dropna()
    by_recording = table.groupby("recording")
    table["rank"] = by_recording["score"].rank(pct=True)
    table["error_rank"] = by_recording["error_pct"].rank(pct=True)
    return table


def errors_pct(recording: Recording, values: Sequence[float | None]) -> dict[str, float]:
    """Absolute errors in % of values in the order of ``GEOMETRY``; NaN where either side is missing."""
    truth = [getattr(recording.annotation, name, None) for name in GEOMETRY]
    return {
        name: 100 * abs(value - true) / true if value is not None and true else np.nan
        for name, value, true in zip(GEOMETRY, values, truth, strict=True)
    }


def true_best_frames(true: Views) -> list[int]:
    """The best frames of both pairs by the true masks."""
    return sorted({best.frame for pair in PAIRS if (best := select_best_frame(true, pair=pair)).frame is not None})


def _only(frames: Sequence[int], found: Views) -> Views:
    """The detections of some frames alone, so that no other can be chosen."""
    return {
        name: replace(view, by_frame={frame: view[frame] for frame in frames if frame in view})
        for name, view in found.items()
    }


def _detected(recording: Recording, frames: Sequence[int], detector: Detector) -> Views:
    found = {}
    for name in METHOD_VIEWS:
        if name in recording.views:
            with recording.views[name].video() as video:
                found[name] = detect_view(video, detector, frames=frames)
    return found
