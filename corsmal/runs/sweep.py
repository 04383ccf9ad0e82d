"""Capacity and dimensions of many recordings over a grid of L and d_max."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

from corsmal.dataset import Recording
from corsmal.errors import ArgumentError, CorsmalError
from corsmal.estimation import fit_frame
from corsmal.parameters import PAIRS, SelectionParameters, ShapeParameters
from corsmal.quantities import GEOMETRY
from corsmal.selection import BestFrame, select_best_frame
from corsmal.shape import Hull, measure_hull
from corsmal.stages.detections import DetectionSet, load_detections
from corsmal.stages.fits import calibration_fingerprints
from corsmal.store import Store, digest

KIND = "sweeps"
SETTINGS = ("circumferences", "max_difference_mm")
"""The two axes of the grid, L and d_max."""


def sweep_recordings(
    recordings: Iterable[Recording],
    *,
    circumferences: Sequence[int],
    max_differences_mm: Sequence[float],
    shape: ShapeParameters,
    store: Store,
    progress: Callable[[int, int], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> list[dict[str, Any]]:
    """What every setting of a grid measures in every recording.

    The best frame does not hang on either setting and the hull on L alone, so a hull is fitted once for each L and
    measured once for each d_max. As in an estimate, the second pair of views is asked where the first one fails.

    Args:
        recordings: whose detections are beside their videos or in the store.
        circumferences: values of L, each at least 2.
        max_differences_mm: values of d_max, not negative.
        shape: the other parameters.
        store: gives detections and keeps what was measured, recording by recording.
        progress: called with the numbers of recordings done and wanted.
        cancelled: asked between recordings; true stops the work and keeps what was done.

    Returns:
        A row per recording and setting: ``recording_id``, ``circumferences``, ``max_difference_mm`` and the four
        quantities, None where neither pair could be measured.

    Raises:
        ArgumentError: the grid is empty or holds a value that cannot be.
    """
    grid = [
        replace(shape, circumferences=int(count), max_difference_mm=float(step_mm))
        for count in circumferences
        for step_mm in max_differences_mm
    ]
    if not grid:
        raise ArgumentError("circumferences and max_differences_mm must each hold at least one value")
    asked = list(recordings)
    rows: list[dict[str, Any]] = []
    for done, recording in enumerate(asked):
        if progress is not None:
            progress(done, len(asked))
        if cancelled is not None and cancelled():
            break
        rows += _recording_rows(recording, grid, store)
    return rows


def _recording_rows(recording: Recording, grid: Sequence[ShapeParameters], store: Store) -> list[dict[str, Any]]:
    try:
        found = load_detections(recording, store=store)
        key = digest("sweep", found.key, calibration_fingerprints(recording), SelectionParameters(), list(grid))
    except CorsmalError:
        return [_row(recording, shape, None) for shape in grid]
    kept = store.json(KIND, key)
    if kept is not None:
        return list(kept["rows"])
    rows = _measured(recording, found, grid)
    store.save_json(KIND, key, {"rows": rows})
    return rows


def _measured(recording: Recording, found: DetectionSet, grid: Sequence[ShapeParameters]) -> list[dict[str, Any]]:
    values: dict[ShapeParameters, dict[str, float]] = {}
    for pair in PAIRS:
        best = select_best_frame(found.views, pair=pair)
        hulls: dict[int, Hull] = {}
        for shape in grid:
            if shape in values or best.frame is None:
                continue
            if shape.circumferences not in hulls:
                hulls[shape.circumferences] = _hull(recording, found, best, best.frame, shape)
            dimensions = measure_hull(hulls[shape.circumferences], shape)
            if dimensions.ok:
                values[shape] = {name: getattr(dimensions, name) for name in GEOMETRY}
    return [_row(recording, shape, values.get(shape)) for shape in grid]


def _hull(recording: Recording, found: DetectionSet, best: BestFrame, frame: int, shape: ShapeParameters) -> Hull:
    return fit_frame(
        recording, found.views, pair=best.pair, frame=frame, centre_rule=best.centre_rule, shape=shape
    ).hull


def _row(recording: Recording, shape: ShapeParameters, values: dict[str, float] | None) -> dict[str, Any]:
    settings = {name: getattr(shape, name) for name in SETTINGS}
    return {"recording_id": recording.id, **settings, **(values or dict.fromkeys(GEOMETRY))}
