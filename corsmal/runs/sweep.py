"""Capacity and dimensions of many recordings over a grid of L and d_max."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from corsmal.dataset import Dataset, Recording
from corsmal.engines.engine import never
from corsmal.errors import ArgumentError, CorsmalError
from corsmal.estimation import fit_frame
from corsmal.parameters import PAIRS, SelectionParameters, ShapeParameters
from corsmal.quantities import GEOMETRY
from corsmal.runs.run import Run
from corsmal.selection import BestFrame, select_best_frame
from corsmal.shape import Hull, measure_hull
from corsmal.stages.detections import DetectionSet, load_detections
from corsmal.stages.fits import calibration_fingerprints
from corsmal.stages.version import METHOD_VERSION
from corsmal.store import Store, digest

KIND = "sweeps"
SETTINGS = ("circumferences", "max_difference_mm")
"""The two axes of the grid, L and d_max."""


@dataclass(frozen=True)
class Grid:
    """What a sweep is made over: ids of recordings, values of L, each at least 2, and of d_max, not negative.

    Raises:
        ArgumentError: one of them is empty.
    """

    recordings: tuple[str, ...]
    circumferences: tuple[int, ...]
    max_differences_mm: tuple[float, ...]

    def __post_init__(self) -> None:
        if not (self.recordings and self.circumferences and self.max_differences_mm):
            raise ArgumentError("recordings, circumferences and max_differences_mm must each hold at least one value")


def sweep_run(
    run: Run,
    dataset: Dataset,
    grid: Grid,
    *,
    store: Store,
    progress: Callable[[int, int], None] | None = None,
    cancelled: Callable[[], bool] = never,
) -> list[dict[str, Any]]:
    """What every setting of a grid measures in recordings of a run; it is kept for the run, see ``load_sweep``.

    The best frame depends on neither setting and the hull on L only, so a hull is fitted once for each L and measured
    once for each d_max. As in an estimate, the second pair of views is tried where the first one fails. What was
    measured in a recording is kept even if the work is cancelled.

    Returns:
        A row per recording and setting: ``recording_id``, ``circumferences``, ``max_difference_mm`` and the four
        quantities, None where neither pair could be measured.

    Raises:
        ArgumentError: the grid holds a value that cannot be.
        NotFoundError: the dataset lacks a recording.
    """
    shapes = [
        replace(run.settings.shape, circumferences=int(count), max_difference_mm=float(step_mm))
        for count in grid.circumferences
        for step_mm in grid.max_differences_mm
    ]
    rows: list[dict[str, Any]] = []
    for done, name in enumerate(grid.recordings):
        if progress is not None:
            progress(done, len(grid.recordings))
        if cancelled():
            return rows
        rows += _recording_rows(dataset[name], shapes, store)
    store.save_json(KIND, _run_key(run, grid), {"rows": rows})
    return rows


def load_sweep(run: Run, grid: Grid, *, store: Store) -> list[dict[str, Any]] | None:
    """What ``sweep_run`` kept for a run as it is now; None where there is nothing."""
    kept = store.json(KIND, _run_key(run, grid))
    return None if kept is None else list(kept["rows"])


def _run_key(run: Run, grid: Grid) -> str:
    return digest("sweep of a run", METHOD_VERSION, run.key, grid)


def _recording_rows(recording: Recording, grid: Sequence[ShapeParameters], store: Store) -> list[dict[str, Any]]:
    try:
        found = load_detections(recording, store=store)
        key = digest(
            "sweep", METHOD_VERSION, found.key, calibration_fingerprints(recording), SelectionParameters(), list(grid)
        )
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
