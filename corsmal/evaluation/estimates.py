"""The estimates table: what a run says about every recording, a row each."""

import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from corsmal.dataset.headings import Columns
from corsmal.dataset.ids import listed, recording_id
from corsmal.errors import ArgumentError, FileError
from corsmal.evaluation.checking import Checked, numbers_of, rows_of
from corsmal.evaluation.escaping import csv_file
from corsmal.evaluation.foreign import ASSUMED, SOURCES, UNITS, read_frame
from corsmal.evaluation.metrics import CLASS_NAMES
from corsmal.files import writing
from corsmal.quantities import MEASURED

ID_COLUMN = "recording_id"
FALLBACK = "fallback: training mean"
ABSENT = "absent"
"""The state of a recording that was not filmed, which is no failure."""

FAILED = (FALLBACK, "failed")
"""The states of an estimate whose container could not be measured, whatever numbers it holds."""

WHOLE_MAX = 2**53
"""Whole numbers up to here are exact as floating point numbers, too."""

_TEXTS = ("status", "pair", "protocol", "filling_weights", "mass_weights", "flags", "notes")
_FLAGS = ("filling_held_out", "mass_held_out")
_TRUTHS = {"true": True, "1": True, "1.0": True, "false": False, "0": False, "0.0": False}
_MASSES = ("filling_mass_g", "object_mass_g")
_PROBABILITIES = (*(f"type_p{number}" for number in range(4)), *(f"level_p{number}" for number in range(3)))
_REST = (*_MASSES, *_PROBABILITIES, "best_frame", "execution_time_ms")
_WHOLE = (*CLASS_NAMES, "best_frame")

ESTIMATE_COLUMNS = (
    ID_COLUMN,
    "status",
    *MEASURED,
    *CLASS_NAMES,
    *_MASSES,
    *_PROBABILITIES,
    "best_frame",
    "pair",
    "execution_time_ms",
    "protocol",
    "filling_weights",
    "filling_held_out",
    "mass_weights",
    "mass_held_out",
    "flags",
    "notes",
)
"""The table's columns in order. Quantities are mL, mm and g; classes are numbered as in the annotation; ``type_p0`` to
``level_p2`` are probabilities; ``best_frame`` and ``pair`` say where the hull comes from, ``notes`` what went wrong
or was assumed and ``flags`` the same for programs, see ``notes.FLAGS``;
``execution_time_ms`` is how long the recording's own estimate took. −1, NaN or nothing: no estimate; a CSV file has
``NaN`` in the columns of measured numbers, which every program reads as a number that is not there.

``filling_weights`` and ``mass_weights`` are digests of the networks' weights, empty where no network was used;
``filling_held_out`` and ``mass_held_out`` say whether the network was trained without the recording, NA where that is
not known or no network was used. ``protocol`` is ``paper`` where the recording helped to choose the epoch at which the
network's training stopped."""


def estimates_table(rows: Iterable[Mapping[str, Any]] | pd.DataFrame) -> pd.DataFrame:
    """Rows, one per recording with keys of ``ESTIMATE_COLUMNS``, as an estimates table; all but the id may be absent.

    Returns:
        All of ``ESTIMATE_COLUMNS`` in order, then what else the rows have. Numbers that cannot be read as such are
        left as they are, for ``check_estimates`` to name.

    Raises:
        ArgumentError: there is no ``recording_id``.
    """
    table = pd.DataFrame(rows if isinstance(rows, pd.DataFrame) else list(rows))
    if ID_COLUMN not in table and len(table):
        raise ArgumentError(
            f"rows must have a {ID_COLUMN!r}, got {', '.join(map(str, table.columns[:8])) or 'nothing'}"
        )
    extra = [name for name in table.columns if name not in ESTIMATE_COLUMNS]
    table = table.reindex(columns=[*ESTIMATE_COLUMNS, *extra])
    typed = {name: _typed(table[name], name) for name in ESTIMATE_COLUMNS}
    return pd.DataFrame({**typed, **{name: table[name] for name in extra}})


def check_estimates(estimates: pd.DataFrame, recordings: pd.Index) -> Checked:
    """What an estimates table says about the recordings of an annotation, whose ids are given.

    Returns:
        The recordings that both have, in the annotation's order: numbers as float with NaN where there is no estimate,
        text with empty strings; and sentences on what was absent or unusable.

    Raises:
        ArgumentError: the table has no ids, or no recording of the annotation.
    """
    rows = rows_of(estimates, recordings, id_column=ID_COLUMN, what="estimates")
    notes, given = list(rows.notes), rows.table
    absent = recordings.difference(given.index)
    if len(absent):
        counts = f"{len(absent)} of {len(recordings)} annotated recordings"
        notes.append(f"estimates: there is no row for {counts} ({listed(absent)}); not evaluated")
    if "status" not in given:
        notes.append("estimates: there is no column 'status'; a recording counts as failed where a number is missing")
    scored = numbers_of(given, {name: name for name in (*MEASURED, *CLASS_NAMES)}, what="estimates")
    rest = [name for name in _REST if name in given]
    others = numbers_of(given, {name: name for name in rest}, what="estimates")
    typed = {name: _typed(given.get(name, pd.Series(index=given.index)), name) for name in (*_TEXTS, *_FLAGS)}
    table = pd.concat([scored.table, others.table.reindex(columns=list(_REST))], axis=1)
    table = table.assign(**typed).reindex(columns=list(ESTIMATE_COLUMNS[1:]))
    in_order = table.reindex(recordings[recordings.isin(table.index)])
    return Checked(in_order, (*notes, *scored.notes, *others.notes))


_TABLE_COLUMNS = Columns(
    ids=ID_COLUMN,
    spellings={
        name: tuple(shown for shown, source in SOURCES.items() if source == name) for name in ESTIMATE_COLUMNS[1:]
    },
    units=UNITS,
    texts=frozenset((*_TEXTS, *_FLAGS)),
)


def read_estimates(path: str | Path) -> pd.DataFrame:
    """Read an ``estimates_table`` from a ``.json`` (a list of rows), ``.csv``, ``.tsv``, ``.txt`` or ``.parquet`` file.

    A submission is read as well: its columns are an estimates table's under other names.

    Returns:
        As ``estimates_table``; ``attrs`` holds under ``foreign.ASSUMED`` sentences on how the file was read.

    Raises:
        ArgumentError: the file's name ends otherwise.
        FileError: the file is absent, broken, has no recordings' ids, or can be read in two ways.
    """
    path = Path(path)
    if path.suffix.lower() not in READ:
        raise ArgumentError(f"path must end in {', '.join(READ)}, got {path.name!r}")
    found = read_frame(path, _TABLE_COLUMNS)
    try:
        table = estimates_table(found)
    except (ValueError, TypeError) as error:
        raise FileError(path, f"is no table of estimates ({error}); make it again") from error
    table.attrs[ASSUMED] = found.attrs.get(ASSUMED, ())
    return table


def write_estimates(estimates: pd.DataFrame, path: str | Path) -> None:
    """Write an estimates table to a ``.json``, ``.csv`` or ``.parquet`` file; an older one is replaced.

    Raises:
        ArgumentError: the table has no recordings' ids, or the file's name ends otherwise.
        FileError: the file cannot be written.
    """
    path, table = Path(path), estimates_table(estimates)
    if path.suffix.lower() not in _WRITERS:
        raise ArgumentError(f"path must end in {', '.join(_WRITERS)}, got {path.name!r}")
    write = _WRITERS[path.suffix.lower()]
    with writing(path, advice="choose another folder") as part:
        write(table, part)


def estimates_csv(estimates: pd.DataFrame) -> str:
    """An estimates table as the text of a CSV file."""
    table = estimates.copy()
    for name in table.columns.drop(table.select_dtypes("float").columns):
        table[name] = table[name].astype("object").where(table[name].notna(), "")
    return csv_file(table, absent="NaN")


def _typed(column: pd.Series, name: str) -> pd.Series:
    if name == ID_COLUMN:
        return column.map(lambda value: recording_id(value) or str(value)).astype("str")
    if name in _TEXTS:
        return column.astype("object").where(column.notna(), "").astype("str")
    if name in _FLAGS:
        return column.map(lambda value: _TRUTHS.get(str(value).lower())).astype("boolean")
    try:
        numbers = pd.to_numeric(column).astype("float64")
    except (ValueError, TypeError, OverflowError):
        return column
    are_whole = numbers.isna() | ((numbers == numbers.round()) & (numbers.abs() < WHOLE_MAX))
    is_whole = name in _WHOLE and bool(are_whole.all())
    return numbers.astype("Int64") if is_whole else numbers


def _write_json(table: pd.DataFrame, path: Path) -> None:
    rows = table.astype("object").where(table.notna(), None).to_dict("records")
    path.write_text(json.dumps(rows, indent=1, ensure_ascii=False), encoding="utf-8")


_WRITERS: dict[str, Callable[[pd.DataFrame, Path], object]] = {
    ".json": _write_json,
    ".csv": lambda table, path: path.write_text(estimates_csv(table), encoding="utf-8"),
    ".parquet": lambda table, path: table.to_parquet(path, index=False),
}
READ = (*_WRITERS, ".tsv", ".txt")
"""Endings of the files that can be read."""
