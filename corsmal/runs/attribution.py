"""Which stage the errors come from: recordings estimated again with one stage replaced by the truth."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from corsmal.dataset import Dataset, Recording
from corsmal.detection import ViewDetections
from corsmal.engines.engine import Engine, Row, completed_rows, in_turn, never
from corsmal.engines.tasks import open_predictors
from corsmal.errors import ArgumentError, CorsmalError
from corsmal.estimation import (
    Estimate,
    RecordingMasks,
    choose_frames,
    counted_frames,
    estimate,
    frontal_frame,
    with_mass,
)
from corsmal.evaluation.attribution import AS_IT_IS
from corsmal.parameters import SHAPE_PRESETS, ShapeParameters, selection_of
from corsmal.quantities import GEOMETRY
from corsmal.runs.run import Run
from corsmal.stages.by_hand import has_masks_by_hand, masks_origin, views_by_hand
from corsmal.stages.detections import load_detections
from corsmal.stages.estimates import Predictors
from corsmal.stages.settings import EstimateSettings
from corsmal.stages.true_masks import true_views
from corsmal.store import Store, digest

KIND = "attributions"
STAGES = ("masks", "best frame", "dimensions")
"""The stages that are replaced here: what follows from them is computed again, the container's mass included. The
filling needs no such thing: its truth changes its own columns only, see ``corsmal.evaluation.attribution_table``."""

Views = Mapping[str, ViewDetections]
RowsByStage = dict[str, list[Row]]


@dataclass(frozen=True)
class AttributionTask:
    """Estimating a recording with one stage after the other replaced by the truth. What is heard is left out.

    ``masks``: the true masks of all frames, or those by hand in the frames that have them. ``best frame``: the detected
    masks, in the frames that the true masks would have chosen among those that were inspected; that is one frame for a
    preset that fits one, else one of each stretch. Where a recording's true masks are not known, it has no such rows.
    ``dimensions``: the annotated capacity, widths and height, which the mass network is given too.

    Args:
        cache: folder of the store.
        settings: what is estimated with.
        stages: of ``STAGES``, or ``as it is``: nothing is replaced.
        key: of the predictors that are meant, see ``EstimateTask``.
    """

    cache: Path
    settings: EstimateSettings
    stages: tuple[str, ...]
    key: str = ""

    def __call__(self, recording: Recording) -> Row:
        """The recording's rows by stage; where it cannot be estimated, failed ones with the reason."""
        try:
            predictors = open_predictors(self.settings, self.key)
            store = Store(self.cache)
            found: Views = load_detections(recording, store=store).views
            stages = [stage for stage in self.stages if stage in (AS_IT_IS, *known_stages([recording], store=store))]
            true = _true(recording, store) if {"masks", "best frame"} & set(stages) else {}
            makers: dict[str, Callable[[], Estimate]] = {
                AS_IT_IS: lambda: _estimated(recording, found, predictors),
                "masks": lambda: _estimated(recording, true, predictors),
                "best frame": lambda: _in_true_frames(recording, found, true, predictors),
                "dimensions": lambda: _with_true_dimensions(recording, found, predictors),
            }
            rows = {stage: makers[stage]().row() for stage in stages}
        except CorsmalError as error:
            failed = {"recording_id": recording.id, "status": "failed", "notes": str(error)}
            rows = dict.fromkeys(self.stages, failed)
        return {"recording_id": recording.id, "rows": rows}


def attribute_run(
    run: Run,
    dataset: Dataset,
    *,
    store: Store,
    engine: Engine = in_turn,
    progress: Callable[[int, int], None] | None = None,
    cancelled: Callable[[], bool] = never,
) -> RowsByStage:
    """The rows of a run with one stage replaced by the truth at a time; they are kept, see ``load_attribution``.

    Masks and best frames are replaced in the recordings whose true masks are known: synthetic ones, and those with
    masks by hand. Of others only the dimensions are known. Where the work is cancelled nothing is kept.

    Returns:
        Rows by stage in the run's order, without what is heard; of a stage, those of the recordings that have it.

    Raises:
        ArgumentError: the networks' weights changed since the run was made.
        CorsmalError: weights are missing or broken, or the engine failed.
    """
    predictors = run.settings.open()
    if any(run.digests[name] != found for name, found in predictors.digests.items()):
        raise ArgumentError("the networks' weights changed since the run was made: make a new run")
    matched = dataset.matched(run.settings.matching, masks=run.settings.masks)
    recordings = [matched[row["recording_id"]] for row in run.rows if row["recording_id"] in dataset]
    stages = known_stages(recordings, store=store)
    task = AttributionTask(store.root.resolve(), run.settings, stages, predictors.key)
    result = _rows_by_stage(task, recordings, engine=engine, progress=progress, cancelled=cancelled)
    if not cancelled():
        store.save_json(KIND, _key(run, dataset, store), result)
    return result


def load_attribution(run: Run, dataset: Dataset, *, store: Store) -> RowsByStage | None:
    """What ``attribute_run`` kept for a run and the masks by hand as they are now; None where there is nothing."""
    return store.json(KIND, _key(run, dataset, store))


def known_stages(recordings: Iterable[Recording], *, store: Store) -> tuple[str, ...]:
    """The stages whose truth is known of at least one of these recordings."""
    is_known = any(each.truth_path is not None or has_masks_by_hand(each, store=store) for each in recordings)
    return STAGES if is_known else STAGES[-1:]


def ablation_presets() -> dict[str, ShapeParameters]:
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


def ablate(
    dataset: Dataset,
    *,
    store: Store,
    presets: Mapping[str, ShapeParameters] | None = None,
    engine: Engine = in_turn,
    progress: Callable[[int, int], None] | None = None,
) -> dict[tuple[str, str], list[Row]]:
    """The geometry of synthetic recordings with several presets, from the detected and from the true masks.

    ``progress`` is called with the numbers of recordings, once for each preset, done and wanted.

    Returns:
        Rows by ``detected`` or ``true`` masks and preset, see ``corsmal.evaluation.ablation_table``.
    """
    presets = ablation_presets() if presets is None else presets
    recordings, rows = list(dataset), {}
    for number, (name, shape) in enumerate(presets.items()):
        settings = EstimateSettings(shape=shape, selection=selection_of(shape))
        task = AttributionTask(store.root.resolve(), settings, (AS_IT_IS, "masks"))

        def report(done: int, total: int, before: int = number * len(recordings)) -> None:
            if progress is not None:
                progress(before + done, total * len(presets))

        made = _rows_by_stage(task, recordings, engine=engine, progress=report)
        rows["detected", name], rows["true", name] = made[AS_IT_IS], made["masks"]
    return rows


def _key(run: Run, dataset: Dataset, store: Store) -> str:
    real = [dataset[name] for name in run.recordings if name in dataset and dataset[name].truth_path is None]
    origins = [(each.id, found) for each in real if (found := masks_origin(each, store=store))]
    return digest("attribution", run.key, *origins)


def _true(recording: Recording, store: Store) -> Views:
    return views_by_hand(recording, store=store) if recording.truth_path is None else true_views(recording)


def _rows_by_stage(
    task: AttributionTask,
    recordings: list[Recording],
    *,
    engine: Engine,
    progress: Callable[[int, int], None] | None,
    cancelled: Callable[[], bool] = never,
) -> RowsByStage:
    done = {
        row["recording_id"]: row.get("rows") or dict.fromkeys(task.stages, row)
        for row in completed_rows(task, recordings, engine=engine, progress=progress, cancelled=cancelled)
    }
    in_order = [done[recording.id] for recording in recordings if recording.id in done]
    return {stage: [rows[stage] for rows in in_order if stage in rows] for stage in task.stages}


def _estimated(recording: Recording, views: Views, predictors: Predictors, **changes: Any) -> Estimate:
    means = None if predictors.means is None else predictors.means.for_container(recording.annotation)
    with_: dict[str, Any] = {"shape": predictors.shape, "selection": predictors.selection}
    given: dict[str, Any] = {**with_, "means": means, "mass": predictors.mass, **changes}
    return estimate(recording, detections=views, **given)


def _in_true_frames(recording: Recording, found: Views, true: Views, predictors: Predictors) -> Estimate:
    """The estimate from detections of the frames that the truth chooses for the first pair that gives a fit."""
    inspected = {name: _only(view, found.get(name, ())) for name, view in true.items()}
    results = []
    counted = counted_frames(recording, predictors.selection)
    for pair in predictors.shape.pairs:
        _, frames = choose_frames(
            inspected, pair=pair, shape=predictors.shape, selection=predictors.selection, counted=counted
        )
        results.append(_estimated(recording, {name: _only(view, frames) for name, view in found.items()}, predictors))
        if results[-1].fit is not None:
            return results[-1]
    return results[0]


def _only(view: ViewDetections, frames: Iterable[int]) -> ViewDetections:
    return replace(view, by_frame={frame: view[frame] for frame in frames if frame in view})


def _with_true_dimensions(recording: Recording, found: Views, predictors: Predictors) -> Estimate:
    """The estimate with what is annotated in place of what was measured, and the mass that the network then gives."""
    measured = _estimated(recording, found, predictors, mass=None)
    annotated = {name: getattr(recording.annotation, name, None) for name in GEOMETRY}
    result = replace(measured, **{name: value for name, value in annotated.items() if value})
    if predictors.mass is None:
        return result
    selection = predictors.selection
    frontal = frontal_frame(found, selection, counted_frames(recording, selection))
    return with_mass(result, RecordingMasks(recording, found, selection), predictors.mass, frontal=frontal)
