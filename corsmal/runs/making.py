"""Making a run: the one call of page and command."""

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from corsmal.dataset import Dataset, Recording
from corsmal.engines.engine import Engine, Row, completed_rows, in_turn, never
from corsmal.engines.tasks import EstimateTask
from corsmal.errors import ArgumentError
from corsmal.runs.keeping import free_id
from corsmal.runs.names import check_name, numbered_names
from corsmal.runs.progress import RunPace, RunProgress, Work, planned_work
from corsmal.runs.run import Run, load_run, save_run
from corsmal.stages.settings import EstimateSettings
from corsmal.stages.version import METHOD_VERSION
from corsmal.store import Store, digest, file_fingerprint

SAVE_EVERY_S = 2.0
"""A program that dies loses no more of a run's rows than these; what was estimated stays in the store anyway."""


def make_run(
    name: str | None,
    dataset: Dataset,
    settings: EstimateSettings,
    *,
    store: Store,
    recordings: Iterable[str] | None = None,
    engine: Engine = in_turn,
    progress: Callable[[int, int], None] | None = None,
    cancelled: Callable[[], bool] = never,
    is_kept: bool = True,
    watch: Callable[[RunProgress], None] | None = None,
    clock: Callable[[], float] = time.monotonic,
) -> Run:
    """Estimate recordings under a name, or resume the run of that name.

    Rows are kept as the work goes, and when it ends for whatever reason: cancelled, interrupted, or failed.

    Args:
        name: for people; the run of that name is resumed if its settings agree. None: a free name after the preset,
            or that of a run with the same settings.
        dataset: the dataset.
        settings: what is estimated with, see ``default_settings``.
        store: gives detections, keeps estimates and the run.
        recordings: ids of those that are wanted; default: all.
        engine: as in ``completed_rows``, like the two that follow.
        progress: likewise.
        cancelled: likewise.
        is_kept: False: the run is returned only, for a store that cannot be written.
        watch: called at first and after each row, which is kept within two seconds, with how far each stage is.
        clock: what the pace is measured with, see ``RunPace``.

    Raises:
        ArgumentError: no recording is wanted, the name cannot be one, or is taken by a run with other settings.
        FileError: weights cannot be read, or the run cannot be written.
        NotFoundError: the dataset lacks a recording.
        CorsmalError: the engine failed, such as a cluster that does not answer.
    """
    matched = dataset.matched(settings.matching, masks=settings.masks)
    named = [matched[each] for each in (dataset.ids if recordings is None else recordings)]
    wanted = list({recording.id: recording for recording in named}.values())
    if not wanted:
        raise ArgumentError("recordings must name at least one: there is nothing to estimate")
    predictors = settings.open()
    detector = None if settings.detector is None else settings.detector.open(device="cpu").digest
    run = _begun(
        Run(
            name="unnamed" if name is None else name.strip(),
            dataset=str(dataset.root),
            recordings=tuple(recording.id for recording in wanted),
            settings=settings,
            digests={**predictors.digests, "detector": detector},
            method_version=METHOD_VERSION,
            data_digest=data_digest(wanted),
            created=datetime.now(UTC).isoformat(timespec="milliseconds"),
            engine="in turn" if engine is in_turn else str(engine),
        ),
        is_named=name is not None,
        store=store,
    )
    task = EstimateTask(store.root.resolve(), settings, key=predictors.key, digest=detector or "")
    planned: dict[str, Work] = {}
    if watch is not None:
        planned = {each.id: planned_work(each, predictors, detector or "", store=store) for each in wanted}
    pace = RunPace(planned, workers=getattr(engine, "count", 1), clock=clock, watch=watch)
    if engine is in_turn:
        task = replace(task, cancelled=cancelled, frames=pace.inspected)
    work = completed_rows(task, wanted, engine=engine, progress=progress, cancelled=cancelled)
    return _with_rows(run, work, pace=pace, store=store if is_kept else None)


def data_digest(recordings: Iterable[Recording]) -> str:
    """A digest of the files of recordings: sizes, times and the ends of the paths, not the content."""
    return digest(
        "data", [[recording.id, [file_fingerprint(path) for path in _paths(recording)]] for recording in recordings]
    )


def _begun(new: Run, *, is_named: bool, store: Store) -> Run:
    """The run with the rows of the earlier one of its name; one without a name takes one that is free or fits."""
    for name in (new.name,) if is_named else numbered_names(new.preset):
        earlier = load_run(name, dataset=new.dataset, store=store)
        if earlier is None:
            named = replace(new, name=check_name(name, taken=()), id="")
            return replace(named, id=free_id(named, store=store))
        ours, theirs = new.conditions, earlier.conditions
        different = [what for what in ours | theirs if ours.get(what) != theirs.get(what)]
        if not different:
            return replace(new, name=name, id=earlier.id, created=earlier.created, rows=earlier.rows)
    raise ArgumentError(
        f"name {new.name!r} is taken by a run with other settings (different: {', '.join(different)}); "
        "choose another name or delete it"
    )


def _with_rows(run: Run, work: Iterator[Row], *, pace: RunPace, store: Store | None) -> Run:
    """The run with new rows in place of its old ones, kept in a store as the work goes and however it ends."""
    rows = {row["recording_id"]: row for row in run.rows}

    def current() -> Run:
        made = replace(run, rows=tuple(rows[name] for name in run.recordings if name in rows))
        if store is not None:
            save_run(made, store=store)
        return made

    current()
    saved_s = time.monotonic()
    try:
        for row in work:
            rows[row["recording_id"]] = row
            if time.monotonic() - saved_s > SAVE_EVERY_S:
                current()
                saved_s = time.monotonic()
            pace.finished(row["recording_id"])
    finally:
        made = current()
    return made


def _paths(recording: Recording) -> list[Path]:
    views = recording.views.values()
    paths = [path for view in views for path in (view.video_path, view.calibration_path, view.detections_path)]
    return [path for path in (*paths, recording.audio_path) if path is not None]
