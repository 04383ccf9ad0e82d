"""Runs: estimates of many recordings under a name, with everything that they were made from, kept in the store."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from corsmal.dataset.layout import MASK_NAMES
from corsmal.errors import ArgumentError, CorsmalError, FileError
from corsmal.notebook import record_html
from corsmal.parameters import SELECTION_PRESETS, SHAPE_PRESETS, SelectionParameters
from corsmal.runs.names import NAME_MAX
from corsmal.runs.records import record_json, record_of
from corsmal.stages.settings import EstimateSettings
from corsmal.store import KEY, Store, digest

if TYPE_CHECKING:
    import pandas as pd

KIND, LABELS = "runs", "run-labels"
"""Of the store: what was computed, and what people call it. The second is apart, so that a run can be renamed while its
rows are written again and again."""

LABEL = ("name", "note", "is_archived")
"""The fields of a run that people change."""

OWN = "own parameters"


@dataclass(frozen=True, eq=False)
class Run:
    """One evaluation: which recordings, with what, from which files, and the rows so far.

    Args:
        name: for people, unique within a dataset's folder.
        dataset: the folder's full path.
        recordings: ids of all that are wanted.
        settings: parameters, means, networks and detector.
        digests: of the networks that were read, by ``filling``, ``mass`` and ``detector``; None where one was left out.
        method_version: see ``METHOD_VERSION``.
        data_digest: of the recordings' files, see ``data_digest``.
        created: when it was begun, UTC, ISO 8601.
        engine: where it was last made, for people.
        rows: as ``Estimate.row`` gives them, in the order of ``recordings``; one per recording that is done.
        id: its key in the store, which a new name does not change; default: that of the first run of the name.
        note: of people, for people.
        is_archived: whether it is listed only on request.

    Raises:
        ArgumentError: the name is empty, too long or not printable, or the id is no key.
    """

    name: str
    dataset: str
    recordings: tuple[str, ...]
    settings: EstimateSettings
    digests: Mapping[str, str | None]
    method_version: int
    data_digest: str
    created: str
    engine: str
    rows: tuple[Mapping[str, Any], ...] = ()
    id: str = ""
    note: str = ""
    is_archived: bool = False

    def __post_init__(self) -> None:
        if not self.id:
            object.__setattr__(self, "id", first_id(self.name, self.dataset))
        if not re.fullmatch(KEY, self.id):
            raise ArgumentError(f"a run's id must be a key of the store, got {self.id[:80]!r}")
        if not self.name.strip() or len(self.name) > NAME_MAX or not self.name.isprintable():
            raise ArgumentError(f"a run's name must be 1 to {NAME_MAX} printable characters, got {self.name[:80]!r}")

    @property
    def short_id(self) -> str:
        """Enough of the id to name the run in an address."""
        return self.id[:12]

    @property
    def is_complete(self) -> bool:
        """Whether every wanted recording has its row."""
        return len(self.rows) == len(self.recordings)

    @property
    def preset(self) -> str:
        """The preset whose parameters these are, or ``own parameters``."""
        return next((name for name, shape in SHAPE_PRESETS.items() if shape == self.settings.shape), OWN)

    @property
    def conditions(self) -> dict[str, Any]:
        """What the rows depend on besides the files, by name; where the networks' files lie is no part of it."""
        detector, features = self.settings.detector, self.settings.features
        return {
            "recordings": self.recordings,
            "parameters": self.settings.shape,
            "selection": self.settings.selection,
            "means": self.settings.means,
            "filling network": self.digests["filling"],
            "mass network": self.digests["mass"],
            "features": None if features is None else str(features),
            **({} if self.settings.sight is None else {"sight": str(self.settings.sight)}),
            "detector": None if detector is None else (self.digests["detector"], detector.every),
            "matching of the views": self.settings.matching,
            "masks": self.settings.masks,
            "version of the method": self.method_version,
        }

    @cached_property
    def key(self) -> str:
        """Digest of conditions, files and rows: what is computed from a run is kept under it."""
        rows = [{name: value for name, value in row.items() if value is not None} for row in self.rows]
        by_default = (SelectionParameters(), "detected")  # without which runs were kept at first
        conditions = {name: value for name, value in self.conditions.items() if value not in by_default}
        return digest("run", conditions, self.data_digest, rows)

    @cached_property
    def table(self) -> "pd.DataFrame":
        """The estimates table."""
        from corsmal.evaluation import estimates_table  # noqa: PLC0415 - loads pandas

        return estimates_table(self.rows)

    def facts(self) -> dict[str, str]:
        """What the run was made with, for people."""
        shape, detector = self.settings.shape, self.settings.detector
        smoothing = "" if "max_difference_mm" in shape.ignored else f", d_max {shape.max_difference_mm:g} mm"
        numbers = f"L {shape.circumferences}{smoothing}"
        if shape.method == "outlines":
            numbers = f"outlines of up to {shape.frames} frames"
        networks = {"filling network": self.settings.filling, "mass network": self.settings.mass}
        detected = "none: detections must be there"
        if detector is not None:
            detected = f"{_short(self.digests['detector'])}, every {detector.every} frames"
        selection = next((name for name, each in SELECTION_PRESETS.items() if each == self.settings.selection), OWN)
        return {
            "parameters": f"{self.preset} ({numbers})",
            "selection": selection,
            **{
                name: "none" if file is None else f"{_short(self.digests[file.kind])} ({file.origin})"
                for name, file in networks.items()
            },
            "detector": detected,
            "masks": MASK_NAMES[self.settings.masks],
            "views matched": str(self.settings.matching),
            "recordings": f"{len(self.rows)} of {len(self.recordings)}",
            "files": self.data_digest[:8],
            "created": f"{self.created.replace('T', ' ')[:16]} UTC",
            "engine": self.engine,
        }

    def _repr_html_(self) -> str:
        """What a notebook shows: what it was made with, and how many recordings have which status."""
        statuses = [str(row["status"]) for row in self.rows]
        counts = ", ".join(f"{statuses.count(status)} {status}" for status in dict.fromkeys(statuses))
        return record_html(f"Run {self.name}", {"note": self.note, **self.facts(), "status": counts})


def _short(name: str | None) -> str:
    """The first digits of a network's digest, with what stands around them."""
    return " ".join(part[:8] if len(part.strip(",")) == 64 else part for part in (name or "").split())


def first_id(name: str, dataset: str) -> str:
    """The id of the first run of a name on a dataset's folder."""
    return digest("run", dataset, name)


def save_run(run: Run, *, store: Store) -> None:
    """Keep a run in place of what was kept under its id; name, note and archive are those of ``label_run``, if any.

    Raises:
        FileError: it cannot be written.
    """
    content = {name: value for name, value in record_json(run).items() if name not in ("note", "is_archived")}
    if not store.save_json(KIND, run.id, content):
        raise FileError(store.root, f"the run could not be kept: {store.problems[-1]}")


def load_run(name: str, *, dataset: str | Path, store: Store) -> Run | None:
    """The run of a name on a dataset, None where there is none."""
    return next((run for run in list_runs(store=store, dataset=dataset) if run.name == name), None)


def list_runs(*, store: Store, dataset: str | Path | None = None, kind: str = KIND) -> list[Run]:
    """The runs that are kept, the newest first; of one dataset's folder if it is named."""
    found = [_run_of(key, kind, store) for key in store.keys(kind)]
    runs = [run for run in found if run is not None and (dataset is None or str(dataset) == run.dataset)]
    return sorted(runs, key=lambda run: run.created, reverse=True)


def named_run(found: Iterable[Run], wanted: str | None) -> Run | None:
    """The run that an address names by its short id, or, as older addresses do, by its name."""
    runs = list(found)
    named = [run for run in runs if run.short_id == wanted] or [run for run in runs if run.name == wanted]
    return named[0] if named else None


def _run_of(key: str, kind: str, store: Store) -> Run | None:
    """A run from its files; None for what is no run, such as one that another version wrote."""
    content = store.json(kind, key)
    if content is None:
        return None
    label = {name: value for name, value in (store.json(LABELS, key) or {}).items() if name in LABEL}
    try:
        return record_of(Run, {**content, **label, "id": key})
    except (CorsmalError, LookupError, TypeError, ValueError, AttributeError):
        return None
