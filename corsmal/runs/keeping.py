"""Runs as people keep them: renamed, with a note, archived, deleted, and brought back."""

import os
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime

from corsmal.errors import ArgumentError, FileError
from corsmal.runs.names import check_name, numbered_names
from corsmal.runs.run import KIND, LABEL, LABELS, Run, list_runs
from corsmal.store import Store, digest

DELETED = "runs-deleted"
"""Of the store: where runs are put that people deleted."""

DELETED_KEPT_DAYS = 30
"""So long a deleted run can be brought back."""

NOTE_MAX = 500
DAY_S = 86_400.0


@dataclass(frozen=True)
class DeletedRun:
    """A run that can be brought back.

    Args:
        run: the run.
        until: when it is removed for good.
    """

    run: Run
    until: datetime


def label_run(
    run: Run, *, store: Store, name: str | None = None, note: str | None = None, is_archived: bool | None = None
) -> Run:
    """Rename a run, write a note on it, put it into the archive or take it out; what is None stays.

    Its id stays, also while it is being made.

    Returns:
        The run as it is listed from now on.

    Raises:
        ArgumentError: the name cannot be one, see ``check_name``, or the note is longer than 500 characters.
        FileError: it cannot be written.
    """
    kept = {**{each: getattr(run, each) for each in LABEL}, **(store.json(LABELS, run.id) or {})}
    if name is not None and name.strip() != kept["name"]:
        others = [other.name for other in list_runs(store=store, dataset=run.dataset) if other.id != run.id]
        kept["name"] = check_name(name, taken=others)
    if note is not None:
        if len(note.strip()) > NOTE_MAX:
            raise ArgumentError(f"a run's note has at most {NOTE_MAX} characters, got {len(note.strip())}")
        kept["note"] = note.strip()
    if is_archived is not None:
        kept["is_archived"] = is_archived
    if not store.save_json(LABELS, run.id, kept):
        raise FileError(store.root, f"the run's name and note could not be kept: {store.problems[-1]}")
    return replace(run, **kept)


def free_id(run: Run, *, store: Store) -> str:
    """An id for a new run: that of the first of its name, unless a run has it that was renamed or deleted since."""
    is_free = not any(store.file(kind, run.id, ".json").is_file() for kind in (KIND, DELETED))
    return run.id if is_free else digest("run", run.dataset, run.name, run.created)


def delete_run(run: Run, *, store: Store) -> None:
    """Put a run aside, for ``restore_run``; those that were deleted 30 days ago are removed for good.

    The estimates of its recordings stay in the store. What is not there is no error.

    Raises:
        FileError: the file cannot be moved.
    """
    _move(run, KIND, DELETED, store)
    for deleted in deleted_runs(store=store):
        if deleted.until < datetime.now(UTC):
            for kind in (DELETED, LABELS):
                with suppress(OSError):
                    store.file(kind, deleted.run.id, ".json").unlink(missing_ok=True)


def deleted_runs(*, store: Store, dataset: str | None = None) -> list[DeletedRun]:
    """The runs that can be brought back, the last deleted first; of one dataset's folder if it is named."""
    found = []
    for run in list_runs(store=store, dataset=dataset, kind=DELETED):
        with suppress(FileNotFoundError):  # brought back by another session
            deleted_s = store.file(DELETED, run.id, ".json").stat().st_mtime
            found.append(DeletedRun(run, datetime.fromtimestamp(deleted_s + DELETED_KEPT_DAYS * DAY_S, UTC)))
    return sorted(found, key=lambda deleted: deleted.until, reverse=True)


def restore_run(run: Run, *, store: Store) -> Run:
    """Bring a deleted run back; where its name was taken meanwhile it gets a number.

    Returns:
        The run, with the name that it has now.

    Raises:
        FileError: the file cannot be moved.
    """
    taken = {other.name for other in list_runs(store=store, dataset=run.dataset) if other.id != run.id}
    name = next(each for each in numbered_names(run.name) if each not in taken)
    if name != run.name:
        run = label_run(run, store=store, name=name)
    _move(run, DELETED, KIND, store)
    return run


def _move(run: Run, source: str, target: str, store: Store) -> None:
    before, after = (store.file(kind, run.id, ".json") for kind in (source, target))
    try:
        if target == KIND and after.is_file():  # it was being made when it was deleted: what is there is newer
            before.unlink(missing_ok=True)
        elif before.is_file():
            after.parent.mkdir(parents=True, exist_ok=True)
            os.replace(before, after)
            os.utime(after)
    except OSError as error:
        raise FileError(before, f"cannot be moved ({error.strerror})") from error
