"""Annotation files: JSON or CSV, taken as far as they are usable, with a sentence on the rest."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from corsmal.dataset.annotation import CONTAINERS, FILLINGS, LEVELS, Annotation, Kind
from corsmal.dataset.findings import Finding
from corsmal.dataset.headings import Columns
from corsmal.dataset.ids import listed, recording_id
from corsmal.dataset.tables import read_table
from corsmal.dataset.text_files import read_text
from corsmal.errors import ArgumentError, FileError


@dataclass(frozen=True)
class Annotations:
    """A set's annotation.

    Args:
        by_id: what is known, by recording id, in the file's order.
        findings: what is absent, was not usable, or was assumed.
        by_container: what is known of containers, by their number, from a table without recordings.
        is_synthetic: whether the file says that its recordings were rendered.
    """

    by_id: Mapping[str, Annotation] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()
    by_container: Mapping[int, Annotation] = field(default_factory=dict)
    is_synthetic: bool = False


SYNTHETIC = "Synthetic recordings"
"""How the description in a JSON file begins whose recordings were rendered."""


@dataclass(frozen=True)
class _Column:
    """How one field is read: its key in the file, the values it may have, and whether −1 is an ordinary value."""

    key: str
    convert: Callable[[object, "_Column"], float | None]
    low: float = 0
    high: float = math.inf
    is_low_allowed: bool = True
    is_often_unknown: bool = False


def _number(value: object, column: _Column) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return None
    try:
        number = float(value)
    except (ValueError, OverflowError):
        return None
    is_in_range = column.low <= number <= column.high and (column.is_low_allowed or number > column.low)
    return number if math.isfinite(number) and is_in_range else None


def _whole_number(value: object, column: _Column) -> int | None:
    number = _number(value, column)
    return int(number) if number is not None and number.is_integer() else None


_COLUMNS = {
    "container_id": _Column("container id", _whole_number, high=10**6),
    "scenario": _Column("scenario", _whole_number, high=10**6),
    "background": _Column("background", _whole_number, high=10**6),
    "illumination": _Column("illumination", _whole_number, high=10**6),
    "width_top_mm": _Column("width at the top", _number, is_low_allowed=False),
    "width_bottom_mm": _Column("width at the bottom", _number, is_low_allowed=False),
    "height_mm": _Column("height", _number, is_low_allowed=False),
    "depth_mm": _Column("depth", _number, is_low_allowed=False, is_often_unknown=True),
    "capacity_ml": _Column("container capacity", _number, is_low_allowed=False),
    "container_mass_g": _Column("container mass", _number, is_low_allowed=False),
    "filling_type": _Column("filling type", _whole_number, high=len(FILLINGS) - 1),
    "filling_level": _Column("filling level", _whole_number, high=len(LEVELS) - 1),
    "filling_density_g_per_ml": _Column("filling density", _number),
    "filling_mass_g": _Column("filling mass", _number),
}


TABLE_COLUMNS = Columns(
    ids="id",
    spellings={column.key: (name,) for name, column in _COLUMNS.items()},
    units={
        **dict.fromkeys(("width at the top", "width at the bottom", "height", "depth"), "mm"),
        **dict.fromkeys(("container mass", "filling mass"), "g"),
        "container capacity": "mL",
        "filling density": "g/mL",
    },
)
"""An annotation's columns, under the names of the published file or those of ``Annotation``."""


def read_annotation_file(path: Path, *, file: str) -> Annotations:
    """Read one annotation file as far as it can be used: JSON, or a table of text.

    Args:
        path: the file.
        file: what findings call it.

    Raises:
        FileError: it cannot be read, or is no annotation.
    """
    is_synthetic = False
    if path.suffix.lower() == ".json":
        content, notes = _json_content(path)
        rows, containers = _json_rows(path, content)
        is_synthetic = _is_synthetic(content)
    else:
        table = read_table(path, TABLE_COLUMNS)
        rows = [dict(zip(table.names, row, strict=True)) for row in table.rows]
        containers, notes = dict(CONTAINERS), list(table.notes)
    by_id, by_container, problems = _collect(rows, containers)
    present = {"id"}.union(*rows)
    absent = [column.key for column in _COLUMNS.values() if column.key not in present] if by_id else []
    notes = ["; ".join(notes)] if notes else []
    notes += [f"there is no column {', '.join(repr(key) for key in absent)}"] if absent else []
    findings = [Finding("note", "annotation", note, file=file) for note in notes]
    findings += [Finding("warning", "annotation", problem, file=file) for problem in problems]
    return Annotations(by_id, tuple(findings), by_container, is_synthetic)


def _json_content(path: Path) -> tuple[Any, list[str]]:
    """What a file says, and what was assumed in reading it."""
    text = read_text(path)
    try:
        return json.loads(text.content), [text.note] if text.note else []
    except (ValueError, RecursionError) as error:
        raise FileError(path, f"the annotation cannot be read ({error}); download it again") from error


def _is_synthetic(content: Any) -> bool:
    info = content.get("info") if isinstance(content, dict) else None
    return isinstance(info, dict) and str(info.get("description")).startswith(SYNTHETIC)


def _json_rows(path: Path, content: Any) -> tuple[list[dict[str, Any]], dict[int, tuple[str, Kind | None]]]:
    """The file's rows under the names of ``TABLE_COLUMNS``, and the containers that it describes."""
    rows = content.get("annotations") if isinstance(content, dict) else content
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise FileError(path, "is no annotation: a list of rows, in JSON under 'annotations', was expected")
    described = content.get("containers") if isinstance(content, dict) else None
    keys = list(dict.fromkeys(key for row in rows for key in row))
    try:
        names = dict(zip(keys, TABLE_COLUMNS.names(keys), strict=True))
    except ArgumentError as error:
        raise FileError(path, str(error)) from error
    renamed = [{names[key] or key: row[key] for key in reversed(row)} for row in rows]
    return renamed, _containers_of(described)


def _containers_of(described: object) -> dict[int, tuple[str, Kind | None]]:
    """Name and kind by container id: the known ones, and over them those that the file describes."""
    containers: dict[int, tuple[str, Kind | None]] = dict(CONTAINERS)
    for entry in described if isinstance(described, list) else []:
        if isinstance(entry, dict) and isinstance(entry.get("id"), int) and isinstance(entry.get("name"), str):
            words = str(entry.get("type", "")).lower()
            kinds: tuple[Kind, ...] = ("cup", "glass", "box")
            known_kind = containers.get(entry["id"], ("", None))[1]
            containers[entry["id"]] = entry["name"], next((kind for kind in kinds if kind in words), known_kind)
    return containers


def _collect(
    rows: list[dict[str, Any]], containers: dict[int, tuple[str, Kind | None]]
) -> tuple[dict[str, Annotation], dict[int, Annotation], list[str]]:
    """Annotations by recording id, or by container where no row has one, and what was wrong with the rows."""
    problems = []
    present = {key for row in rows for key in row}
    unusable: dict[str, list[str]] = {column.key: [] for column in _COLUMNS.values() if column.key in present}
    by_id: dict[str, Annotation] = {}
    by_container: dict[int, Annotation] = {}
    has_ids = "id" in present
    without_id, repeated = 0, []
    for row in rows:
        name = recording_id(row.get("id"))
        number = None if has_ids else _whole_number(row.get("container id"), _COLUMNS["container_id"])
        if number is not None and number not in by_container:
            by_container[number] = _annotation(row, containers, unusable, f"of container {number}")
        elif name is None:
            without_id += 1
        elif name in by_id:
            repeated.append(name)
        else:
            by_id[name] = _annotation(row, containers, unusable, name)
    if not rows:
        problems.append("it has no rows")
    if without_id:
        problems.append(f"{without_id} of {len(rows)} rows have no usable 'id' and were left out")
    if repeated:
        problems.append(f"{listed(repeated)} appears more than once; the first row was taken")
    for key, names in unusable.items():
        if names:
            problems.append(f"{key!r} is missing or unusable for {listed(names)}")
    return by_id, by_container, problems


def _annotation(
    row: dict[str, Any],
    containers: dict[int, tuple[str, Kind | None]],
    unusable: dict[str, list[str]],
    name: str,
) -> Annotation:
    values: dict[str, Any] = {}
    for target, column in _COLUMNS.items():
        value = row.get(column.key)
        values[target] = column.convert(value, column)
        is_plain_unknown = column.is_often_unknown and str(value).strip() in ("-1", "-1.0")
        if values[target] is None and column.key in unusable and not is_plain_unknown:
            unusable[column.key].append(name)
    container, kind = containers.get(values["container_id"], (None, None))
    return Annotation(**values, container=container, kind=kind)
