"""Reproductions that are kept in a folder, made by command or by a page: what was found, read from its files."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from itertools import count
from pathlib import Path
from typing import Any

import pandas as pd

from corsmal.dataset.annotation import Kind
from corsmal.errors import CorsmalError, FileError
from corsmal.evaluation import read_estimates
from corsmal.files import writing
from corsmal.parameters import selection_of
from corsmal.runs.records import record_json, record_of
from corsmal.runs.reproduction_settings import ReproductionSettings
from corsmal.runs.run import Run
from corsmal.stages.settings import EstimateSettings
from corsmal.stages.version import METHOD_VERSION

SUMMARY, ESTIMATES, REPORT = "reproduction.json", "estimates.csv", "report.html"
"""Files of a reproduction; the summary is written last: a folder that holds one is complete."""

DISK_ADVICE = "free the disk or choose another folder; what was computed is kept"

Confusions = Mapping[str, Mapping[Kind, pd.DataFrame]]
"""Fig. 3: counts by quantity and kind of container, a row per true class."""


@dataclass(frozen=True, eq=False)
class KeptReproduction:
    """The results of a reproduction, from its files.

    Args:
        folder: that holds them.
        settings: how it was made.
        made: when it was last written, local time.
        run: the estimates behind Table 2, a row per annotated recording, as a run of the folder's name that no store
            holds.
        confusions: Fig. 3.
        scores: by test set, the challenge's scores beside the published ones (Table 3), or a note on why there are
            none.
        notes: sentences on what was missing or left out.
    """

    folder: Path
    settings: ReproductionSettings
    made: datetime
    run: Run
    confusions: Confusions
    scores: Mapping[str, pd.DataFrame]
    notes: tuple[str, ...]


def results_folder(out: Path, settings: ReproductionSettings) -> Path:
    """The folder within ``out`` for the tables of a reproduction with these settings, and of no other.

    It is named after protocol, folds and, where they are not the paper's, the networks, such as
    ``held-out-spread-released``; it gets a number where a reproduction whose other settings differ has that name.
    """
    words = [settings.protocol, settings.folds, *([settings.networks] if settings.networks != "paper" else [])]
    name = "-".join([*words, *(["quick"] if settings.is_quick else [])])
    wanted = json.loads(json.dumps(record_json(settings)))
    numbered = (out / (name if number == 1 else f"{name}-{number}") for number in count(1))
    return next(folder for folder in numbered if _settings_in(folder) in (None, wanted))


def write_summary(
    folder: Path,
    settings: ReproductionSettings,
    *,
    confusions: Confusions,
    scores: Mapping[str, pd.DataFrame],
    notes: tuple[str, ...],
) -> None:
    """Write what ``read_reproduction`` needs besides the estimates; the arguments are as in ``KeptReproduction``.

    Raises:
        FileError: it cannot be written.
    """
    tables = {
        quantity: {kind: _split(table) for kind, table in by_kind.items()} for quantity, by_kind in confusions.items()
    }
    content = {
        "settings": record_json(settings),
        "notes": notes,
        "confusions": tables,
        "scores": {test: _split(table) for test, table in scores.items()},
    }
    with writing(folder / SUMMARY, advice=DISK_ADVICE) as part:
        part.write_text(json.dumps(content, indent=1), encoding="utf-8")


def read_reproduction(folder: Path) -> KeptReproduction:
    """A reproduction from the folder that its report is in.

    Raises:
        FileError: the folder holds no reproduction, a broken one, or that of another version.
    """
    path = folder / SUMMARY
    try:
        made = datetime.fromtimestamp(path.stat().st_mtime).astimezone()
        content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        settings = record_of(ReproductionSettings, content["settings"])
        return KeptReproduction(
            folder=folder,
            settings=settings,
            made=made,
            run=_run(folder, settings, made),
            confusions={
                quantity: {kind: pd.DataFrame(**table) for kind, table in by_kind.items()}
                for quantity, by_kind in content["confusions"].items()
            },
            scores={test: pd.DataFrame(**table) for test, table in content["scores"].items()},
            notes=tuple(content["notes"]),
        )
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror or error})") from error
    except FileError:
        raise
    except (CorsmalError, LookupError, TypeError, ValueError, AttributeError) as error:
        raise FileError(path, "is broken or of another version; make the reproduction again") from error


def kept_reproductions(out: Path) -> list[Path]:
    """The folders below a reproduction's output folder that hold results, the newest first."""
    try:
        found = [(path.stat().st_mtime, path.parent) for path in out.glob(f"*/{SUMMARY}")]
    except OSError:  # deleted in the meantime, or not to be read
        return []
    return [folder for _, folder in sorted(found, reverse=True)]


def _settings_in(folder: Path) -> Any:
    """The settings of the reproduction in a folder, as JSON has them; None where none was finished that can be read."""
    try:
        return json.loads((folder / SUMMARY).read_text(encoding="utf-8"))["settings"]
    except (OSError, LookupError, TypeError, ValueError):
        return None


def _run(folder: Path, settings: ReproductionSettings, made: datetime) -> Run:
    rows: list[dict[str, Any]] = [
        {str(name): value for name, value in row.items() if pd.notna(value)}
        for row in read_estimates(folder / ESTIMATES).to_dict("records")
    ]
    return Run(
        name=folder.name,
        dataset=str(folder),
        recordings=tuple(str(row["recording_id"]) for row in rows),
        settings=EstimateSettings(
            shape=settings.shape, matching=settings.matching, selection=selection_of(settings.shape)
        ),
        digests={"filling": None, "mass": None, "detector": None},
        method_version=METHOD_VERSION,
        data_digest="",
        created=made.isoformat(timespec="milliseconds"),
        engine="reproduction",
        rows=tuple(rows),
    )


def _split(table: pd.DataFrame) -> dict[str, Any]:
    """A table as JSON has it; null where something is missing."""
    rows = [[None if pd.isna(value) else value for value in row] for row in table.astype(object).to_numpy().tolist()]
    return {"index": list(table.index), "columns": list(table.columns), "data": rows}
