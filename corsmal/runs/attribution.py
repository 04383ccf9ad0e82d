"""The estimates of a run made again with one stage after the other replaced by the truth."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from corsmal.dataset import Dataset, Recording
from corsmal.detection import ViewDetections
from corsmal.errors import CorsmalError
from corsmal.estimation import Estimate, estimate, mass_inputs
from corsmal.mass.physics import filling_mass_g
from corsmal.parameters import PAIRS
from corsmal.quantities import DIMENSIONS, GEOMETRY
from corsmal.runs.run import Run
from corsmal.selection import select_best_frame
from corsmal.stages.detections import load_detections
from corsmal.stages.estimates import Predictors
from corsmal.store import Store, digest

KIND = "blames"
STAGES = ("masks", "best frame", "dimensions")
"""The stages that are replaced here: what follows from them is computed again, the container's mass included. Filling
and mass need no such thing: a truth put in their place changes their columns alone."""

Views = Mapping[str, ViewDetections]
Row = dict[str, Any]


def blame_rows(
    run: Run,
    dataset: Dataset,
    predictors: Predictors,
    *,
    store: Store,
    true_views: Callable[[Recording], Views] | None = None,
    progress: Callable[[int, int], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> dict[str, list[Row]]:
    """The rows of a run with one stage replaced by the truth at a time.

    ``masks``: the true masks of all frames. ``best frame``: the detected masks of the frame that the true masks would
    have chosen among those that were inspected. ``dimensions``: the annotated capacity, widths and height, from which
    the mass network tells the mass. What was heard stays as it is.

    Args:
        run: with its rows.
        dataset: that the run was made on.
        predictors: that it was made with.
        store: gives the detections and keeps the result.
        true_views: gives the true masks of a recording as detections by view; None where they are not known, which
            leaves ``dimensions`` alone.
        progress: called with the numbers of recordings done and wanted.
        cancelled: asked between recordings; true stops the work, and nothing is kept.

    Returns:
        Rows by stage, as the run has them; a recording that cannot be estimated is a failed row with the reason.
    """
    stages = STAGES if true_views is not None else STAGES[-1:]
    result: dict[str, list[Row]] = {stage: [] for stage in stages}
    for done, row in enumerate(run.rows):
        if progress is not None:
            progress(done, len(run.rows))
        if cancelled is not None and cancelled():
            return result
        for stage, new in _replaced(row, dataset, predictors, store, true_views).items():
            result[stage].append(new)
    store.save_json(KIND, _key(run), result)
    return result


def load_blame(run: Run, *, store: Store) -> dict[str, list[Row]] | None:
    """What ``blame_rows`` kept for a run; None where it has not been asked since the run changed."""
    return store.json(KIND, _key(run))


def _key(run: Run) -> str:
    return digest("blame", run.key)


def _replaced(
    row: Mapping[str, Any],
    dataset: Dataset,
    predictors: Predictors,
    store: Store,
    true_views: Callable[[Recording], Views] | None,
) -> dict[str, Row]:
    """One recording's new row by stage."""
    name = row["recording_id"]
    try:
        recording = dataset[name]
        found: Views = load_detections(recording, store=store).views
        results = {"dimensions": _with_true_dimensions(recording, found, predictors)}
        if true_views is not None:
            true = true_views(recording)
            results["masks"] = _estimated(recording, true, predictors)
            results["best frame"] = _in_true_frame(recording, found, true, predictors)
    except CorsmalError as error:
        failed = {"recording_id": name, "status": "failed", "notes": str(error)}
        return dict.fromkeys(STAGES if true_views is not None else STAGES[-1:], failed)
    return {stage: _heard_as_before(result, row) for stage, result in results.items()}


def _estimated(recording: Recording, views: Views, predictors: Predictors) -> Estimate:
    """The estimate without listening."""
    return estimate(recording, detections=views, shape=predictors.shape, means=predictors.means, mass=predictors.mass)


def _in_true_frame(recording: Recording, found: Views, true: Views, predictors: Predictors) -> Estimate:
    """The estimate from detections of one frame alone: the first pair's true best one, else the second pair's."""
    inspected = {
        name: replace(view, by_frame={frame: view[frame] for frame in found.get(name, ()) if frame in view})
        for name, view in true.items()
    }
    results = [
        _estimated(recording, {name: _only(view, best.frame) for name, view in found.items()}, predictors)
        for pair in PAIRS
        if (best := select_best_frame(inspected, pair=pair)).frame is not None
    ]
    fitted = [result for result in results if result.fit is not None]
    return next(iter([*fitted, *results]), _estimated(recording, {}, predictors))


def _only(view: ViewDetections, frame: int | None) -> ViewDetections:
    return replace(view, by_frame={} if frame is None or frame not in view else {frame: view[frame]})


def _with_true_dimensions(recording: Recording, found: Views, predictors: Predictors) -> Estimate:
    """The estimate with what is annotated in place of what was measured, and the mass told from that."""
    measured = _estimated(recording, found, replace(predictors, mass=None))
    annotated = {name: getattr(recording.annotation, name, None) for name in GEOMETRY}
    result = replace(measured, **{name: value for name, value in annotated.items() if value})
    inputs = None if predictors.mass is None else mass_inputs(measured, recording, found)
    if predictors.mass is None or inputs is None:
        return result
    inputs |= {name: getattr(result, name) for name in DIMENSIONS}
    return replace(result, container_mass_g=predictors.mass.predict(**inputs).mass_g)


def _heard_as_before(result: Estimate, row: Mapping[str, Any]) -> Row:
    """The new estimate's row with what the run heard, and the masses that follow from both."""
    names = ("filling_type", "filling_level", *(f"type_p{index}" for index in range(4)))
    heard = {name: row.get(name) for name in (*names, *(f"level_p{index}" for index in range(3)))}
    new = result.row() | heard
    kind, level = new["filling_type"], new["filling_level"]
    if kind is None or level is None:
        return new
    new["filling_mass_g"] = filling_mass_g(kind, level, capacity_ml=result.capacity_ml)
    if result.container_mass_g is not None and new["filling_mass_g"] is not None:
        new["object_mass_g"] = result.container_mass_g + new["filling_mass_g"]
    return new
