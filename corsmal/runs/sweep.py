"""Capacity and dimensions of many recordings over a grid of two parameters that the run's fit depends on."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from corsmal.dataset import Dataset, Recording
from corsmal.engines.engine import Engine, Row, completed_rows, in_turn, never
from corsmal.errors import ArgumentError, CorsmalError
from corsmal.estimation import Fit, estimate, fit_frame
from corsmal.parameters import CentreRule, SelectionParameters, ShapeParameters
from corsmal.quantities import GEOMETRY
from corsmal.runs.run import Run
from corsmal.selection import Pair
from corsmal.shape import Hull, measure_hull
from corsmal.stages.detections import DetectionSet, load_detections
from corsmal.stages.fits import calibration_fingerprints
from corsmal.stages.version import METHOD_VERSION
from corsmal.store import Store, digest

KIND = "sweeps"

OFFERED: Mapping[str, tuple[float, ...]] = {
    "circumferences": (40, 70, 100, 145, 180, 220, 260, 320, 400, 500),
    "max_difference_mm": (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0),
    "points": (7, 9, 13, 19, 25, 37, 61),
    "radii": (36, 73, 145, 290, 500),
    "tilt_deg": (0.0, 1.5, 3.0, 5.0, 8.0),
    "wall_mm": (0.0, 0.5, 1.0, 1.5, 2.0, 3.0),
    "frames": (1, 2, 4, 8, 16),
}
"""Values that are worth trying, by field of ``ShapeParameters``; ``ShapeParameters.varied`` says which matter."""

MEASURING = ("max_difference_mm", "wall_mm")
"""Parameters that a fitted hull is measured with: it does not depend on them."""


@dataclass(frozen=True)
class Axis:
    """One parameter of a sweep.

    Args:
        name: field of ``ShapeParameters``.
        values: those that are tried.
    """

    name: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Grid:
    """What a sweep is made over: ids of recordings, and two parameters with their values.

    Raises:
        ArgumentError: one of them is empty, or both parameters are the same.
    """

    recordings: tuple[str, ...]
    across: Axis
    down: Axis

    def __post_init__(self) -> None:
        if not (self.recordings and self.across.values and self.down.values):
            raise ArgumentError("recordings and the values of both parameters must each hold at least one")
        if self.across.name == self.down.name:
            raise ArgumentError(f"a sweep needs two different parameters, got {self.across.name} twice")

    @property
    def settings(self) -> list[dict[str, float]]:
        """All pairs of values, by parameter."""
        return [{self.across.name: x, self.down.name: y} for x in self.across.values for y in self.down.values]


@dataclass(frozen=True)
class SweepTask:
    """Measuring a recording with each of many parameters.

    Args:
        cache: folder of the store.
        shapes: the parameters.
        selection: the rules for the frames.
    """

    cache: Path
    shapes: tuple[ShapeParameters, ...]
    selection: SelectionParameters

    def __call__(self, recording: Recording) -> Row:
        """The recording's ``values``: the four quantities with each parameters; None where they cannot be measured."""
        values = _recording_values(recording, self.shapes, self.selection, Store(self.cache))
        return {"recording_id": recording.id, "values": values}


def run_grid(run: Run, recordings: Sequence[str], across: Axis, down: Axis) -> Grid:
    """A grid that holds the run's own setting too, with which the others are compared.

    Raises:
        ArgumentError: the run's fit does not depend on a parameter, or see ``Grid``.
    """
    varied = run.settings.shape.varied
    for axis in (across, down):
        if axis.name not in varied:
            raise ArgumentError(f"the run's fit does not depend on {axis.name}; it does on {', '.join(varied)}")
    own = [
        replace(axis, values=tuple(sorted({*axis.values, getattr(run.settings.shape, axis.name)})))
        for axis in (across, down)
    ]
    return Grid(tuple(recordings), *own)


def sweep_run(
    run: Run,
    dataset: Dataset,
    grid: Grid,
    *,
    store: Store,
    engine: Engine = in_turn,
    progress: Callable[[int, int], None] | None = None,
    cancelled: Callable[[], bool] = never,
) -> list[dict[str, Any]]:
    """What every setting of a grid measures in recordings of a run; it is kept for the run, see ``load_sweep``.

    The numbers are those of an estimate with these parameters. A hull is fitted once for all settings that only measure
    it otherwise. What was measured in a recording is kept even if the work is cancelled.

    Returns:
        A row per recording and setting: ``recording_id``, the two parameters and the four quantities, None where
        neither pair could be measured.

    Raises:
        ArgumentError: the grid holds a value that cannot be.
        NotFoundError: the dataset lacks a recording.
        CorsmalError: the engine failed.
    """
    shapes = tuple(with_setting(run.settings.shape, setting) for setting in grid.settings)
    matched = dataset.matched(run.settings.matching, masks=run.settings.masks)
    recordings = [matched[name] for name in grid.recordings]
    task = SweepTask(store.root.resolve(), shapes, run.settings.selection)
    measured = {
        row["recording_id"]: row.get("values", [None] * len(shapes))
        for row in completed_rows(task, recordings, engine=engine, progress=progress, cancelled=cancelled)
    }
    rows: list[dict[str, Any]] = [
        {"recording_id": name, **setting, **(values or dict.fromkeys(GEOMETRY))}
        for name in grid.recordings
        if name in measured
        for setting, values in zip(grid.settings, measured[name], strict=True)
    ]
    if len(measured) == len(set(grid.recordings)):
        store.save_json(KIND, _run_key(run, grid), {"rows": rows})
    return rows


def load_sweep(run: Run, grid: Grid, *, store: Store) -> list[dict[str, Any]] | None:
    """What ``sweep_run`` kept for a run as it is now; None where there is nothing."""
    kept = store.json(KIND, _run_key(run, grid))
    return None if kept is None else list(kept["rows"])


def _run_key(run: Run, grid: Grid) -> str:
    return digest("sweep of a run", METHOD_VERSION, run.key, grid)


def with_setting(shape: ShapeParameters, setting: Mapping[str, float]) -> ShapeParameters:
    """The parameters with those of a setting, whole numbers as such."""
    changes: dict[str, Any] = {name: type(getattr(shape, name))(value) for name, value in setting.items()}
    return replace(shape, **changes)


def _recording_values(
    recording: Recording, shapes: Sequence[ShapeParameters], selection: SelectionParameters, store: Store
) -> list[dict[str, float] | None]:
    """The four quantities with each of many parameters; None where they could not be measured."""
    try:
        found = load_detections(recording, store=store)
        calibrations = calibration_fingerprints(recording)
        key = digest("sweep", METHOD_VERSION, found.key, calibrations, selection, list(shapes))
    except CorsmalError:
        return [None] * len(shapes)
    kept = store.json(KIND, key)
    if kept is None:
        kept = {"values": _measured(recording, found, shapes, selection)}
        store.save_json(KIND, key, kept)
    values: list[dict[str, float] | None] = kept["values"]
    return values


def _measured(
    recording: Recording, found: DetectionSet, shapes: Sequence[ShapeParameters], selection: SelectionParameters
) -> list[dict[str, float] | None]:
    fitted: dict[object, Hull] = {}

    def measure(shape: ShapeParameters) -> dict[str, float] | None:
        fit_with = replace(shape, **{name: getattr(shapes[0], name) for name in MEASURING})

        def fits(*, pair: Pair, frame: int, centre_rule: CentreRule) -> Fit:
            key = pair, frame, centre_rule, fit_with
            if key not in fitted:
                choice: dict[str, Any] = {"pair": pair, "frame": frame, "centre_rule": centre_rule}
                fitted[key] = fit_frame(recording, found.views, **choice, shape=fit_with, selection=selection).hull
            return Fit(pair, frame, fitted[key], measure_hull(fitted[key], shape))

        result = estimate(recording, detections=found.views, shape=shape, selection=selection, fits=fits)
        return None if result.fit is None else {name: getattr(result, name) for name in GEOMETRY}

    return [measure(shape) for shape in shapes]
