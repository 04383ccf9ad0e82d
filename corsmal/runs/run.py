"""Named runs: estimates of many recordings, with everything that they were made from, kept so that they last."""

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path
from typing import Any

from corsmal.dataset import Dataset, Recording
from corsmal.errors import ArgumentError, CorsmalError, FileError
from corsmal.parameters import HeightRange, ShapeParameters
from corsmal.stages.estimates import Predictors, load_estimate
from corsmal.store import Store, digest, file_fingerprint

KIND = "runs"
NAME_MAX = 60
SAVE_EVERY_S = 2.0
"""A server that dies loses no more of a run's rows than these; what was estimated stays in the store anyway."""


@dataclass(frozen=True, eq=False)
class Run:
    """One evaluation: what was estimated, with what, from which files.

    Args:
        name: for people, unique within a dataset's folder.
        dataset: the folder, as text.
        recordings: ids of all that are wanted.
        shape: parameters of the fit.
        networks: digests of ``filling`` and ``mass``, None where one was left out.
        predictors_key: digest of everything that the estimates are made with, see ``Predictors.key``.
        data_digest: digest of the recordings' files, see ``data_digest``.
        created: when it was begun, UTC, ISO 8601.
        rows: so far, as ``Estimate.row`` gives them.
    """

    name: str
    dataset: str
    recordings: tuple[str, ...]
    shape: ShapeParameters
    networks: Mapping[str, str | None]
    predictors_key: str
    data_digest: str
    created: str
    rows: tuple[Mapping[str, Any], ...] = ()

    def __post_init__(self) -> None:
        if not self.name.strip() or len(self.name) > NAME_MAX or not self.name.isprintable():
            raise ArgumentError(f"a run's name must be 1 to {NAME_MAX} printable characters, got {self.name[:80]!r}")

    @property
    def is_complete(self) -> bool:
        """Whether every wanted recording has its row."""
        return len(self.rows) == len(self.recordings)

    @cached_property
    def key(self) -> str:
        """Digest of settings, files and rows: what is computed from a run is kept under it."""
        rows = [{name: value for name, value in row.items() if value is not None} for row in self.rows]
        return digest("run", self.predictors_key, self.data_digest, rows)


def data_digest(recordings: Iterable[Recording]) -> str:
    """A digest of the files of recordings: sizes, times and the ends of the paths, not the content."""
    return digest(
        "data", [[recording.id, [file_fingerprint(path) for path in _paths(recording)]] for recording in recordings]
    )


def record_run(
    name: str,
    dataset: Dataset,
    recordings: Iterable[str],
    predictors: Predictors,
    *,
    store: Store,
    progress: Callable[[int, int], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
    before: Callable[[Recording], None] | None = None,
) -> Run:
    """Estimate recordings under a name, or go on with the run of that name.

    Args:
        name: for people; the same name with the same settings and recordings goes on.
        dataset: the dataset.
        recordings: ids of those that are wanted.
        predictors: what the estimates are made with.
        store: gives detections, keeps estimates and the run.
        progress: called with the numbers of recordings done and wanted.
        cancelled: asked between recordings; true stops the work and keeps what was done.
        before: called with each recording before it is estimated, such as to detect in it.

    Returns:
        The run as it is kept.

    Raises:
        ArgumentError: no recording is wanted, the name cannot be one, or is taken by a run with other settings.
        FileError: the run cannot be written.
        NotFoundError: the dataset lacks a recording.
    """
    wanted = [dataset[each] for each in recordings]
    if not wanted:
        raise ArgumentError("recordings must name at least one: there is nothing to estimate")
    run = _begun(name, dataset, wanted, predictors, store)
    rows: list[Mapping[str, Any]] = []
    saved_s = time.monotonic()
    for recording in wanted:
        if before is not None and not (cancelled and cancelled()):
            before(recording)
        if cancelled and cancelled():
            break
        rows.append(load_estimate(recording, predictors, store=store))
        if progress is not None:
            progress(len(rows), len(wanted))
        if time.monotonic() - saved_s > SAVE_EVERY_S:
            save_run(_with_rows(run, rows), store=store)
            saved_s = time.monotonic()
    run = _with_rows(run, rows)
    save_run(run, store=store)
    return run


def save_run(run: Run, *, store: Store) -> None:
    """Keep a run; an earlier one of the same name and dataset is replaced.

    Raises:
        FileError: it cannot be written.
    """
    if not store.save_json(KIND, _key(run.name, run.dataset), asdict(run)):
        raise FileError(store.root, f"the run could not be kept: {store.problems[-1]}")


def load_run(name: str, *, dataset: str | Path, store: Store) -> Run | None:
    """The run of a name on a dataset, None where there is none."""
    return _run_of(store.json(KIND, _key(name, str(dataset))))


def list_runs(*, store: Store, dataset: str | Path | None = None) -> list[Run]:
    """The runs that are kept, the newest first; of one dataset's folder if it is named."""
    found = [_run_of(store.json(KIND, key)) for key in store.keys(KIND)]
    runs = [run for run in found if run is not None and dataset in (None, run.dataset, Path(run.dataset))]
    return sorted(runs, key=lambda run: run.created, reverse=True)


def delete_run(name: str, *, dataset: str | Path, store: Store) -> None:
    """Forget a run; the estimates of its recordings stay in the store.

    Raises:
        FileError: the file cannot be deleted.
    """
    path = store.file(KIND, _key(name, str(dataset)), ".json")
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise FileError(path, f"cannot be deleted ({error.strerror})") from error


def _begun(name: str, dataset: Dataset, wanted: list[Recording], predictors: Predictors, store: Store) -> Run:
    """A new run, kept without rows, or the earlier one of that name with its rows."""
    run = Run(
        name=name.strip(),
        dataset=str(dataset.root),
        recordings=tuple(recording.id for recording in wanted),
        shape=predictors.shape,
        networks={part: getattr(getattr(predictors, part), "digest", None) for part in ("filling", "mass")},
        predictors_key=predictors.key,
        data_digest=data_digest(wanted),
        created=datetime.now(UTC).isoformat(timespec="seconds"),
    )
    earlier = load_run(run.name, dataset=run.dataset, store=store)
    if earlier is None:
        save_run(run, store=store)
        return run
    if (earlier.predictors_key, earlier.recordings) != (run.predictors_key, run.recordings):
        raise ArgumentError(
            f"name {run.name!r} is taken by a run with other settings or recordings; choose another name or delete it"
        )
    return replace(run, created=earlier.created, rows=earlier.rows)


def _with_rows(run: Run, rows: list[Mapping[str, Any]]) -> Run:
    """The run with new rows, and with its old ones of the recordings that were not reached this time."""
    done = {row["recording_id"] for row in rows}
    return replace(run, rows=(*rows, *(row for row in run.rows if row["recording_id"] not in done)))


def _key(name: str, dataset: str) -> str:
    return digest("run", dataset, name)


def _paths(recording: Recording) -> list[Path]:
    views = recording.views.values()
    paths = [path for view in views for path in (view.video_path, view.calibration_path, view.detections_path)]
    return [path for path in (*paths, recording.audio_path) if path is not None]


def _run_of(content: Mapping[str, Any] | None) -> Run | None:
    """A run from its JSON; None for what is no run, such as one that another version wrote."""
    if content is None:
        return None
    try:
        shape = content["shape"]
        parameters = ShapeParameters(**{**shape, "height_range": HeightRange(**shape["height_range"])})
        recordings, rows = tuple(content["recordings"]), tuple(dict(row) for row in content["rows"])
        return Run(**{**content, "shape": parameters, "recordings": recordings, "rows": rows})
    except (CorsmalError, LookupError, TypeError, ValueError, AttributeError):
        return None
