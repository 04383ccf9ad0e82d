"""Annotation files: JSON or CSV, taken as far as they are usable, with a sentence on the rest."""

import csv
import io
import json
import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from corsmal.dataset.annotation import CONTAINERS, FILLINGS, LEVELS, Annotation, Kind
from corsmal.dataset.ids import listed, recording_id
from corsmal.errors import FileError


@dataclass(frozen=True)
class Annotations:
    """A set's annotation.

    Args:
        by_id: what is known, by recording id, in the file's order.
        problems: sentences on what is absent or was not usable.
    """

    by_id: Mapping[str, Annotation] = field(default_factory=dict)
    problems: tuple[str, ...] = ()


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


def read_annotations(root: Path, names: Iterable[str]) -> Annotations:
    """Read the annotation of a dataset folder as far as it can be used, with sentences on the rest.

    Of the files ``names`` in it the first is taken whose name contains ``annotation`` and that can be read, JSON before
    CSV.
    """
    candidates = sorted(name for name in names if re.search(r"annotation.*\.(json|csv)$", name.lower()))
    candidates.sort(key=lambda name: not name.lower().endswith(".json"))
    problems = []
    for name in candidates:
        try:
            rows, containers = _rows_of(root / name)
        except FileError as error:
            problems.append(str(error))
            continue
        by_id, more = _collect(rows, containers)
        return Annotations(by_id, (*problems, *(f"{name}: {problem}" for problem in more)))
    if not candidates:
        problems.append(f"no annotation was found: {root} holds no file like ccm_train_annotation.json or .csv")
    return Annotations({}, tuple(problems))


def _rows_of(path: Path) -> tuple[list[dict[str, Any]], dict[int, tuple[str, Kind | None]]]:
    """The file's rows with their keys in lower case, and the containers that it describes itself."""
    try:
        text = path.read_text(encoding="utf-8-sig")
        content = json.loads(text) if path.suffix.lower() == ".json" else list(csv.DictReader(io.StringIO(text)))
    except (OSError, ValueError, RecursionError, csv.Error) as error:
        raise FileError(path, f"the annotation cannot be read ({error}); download it again") from error
    rows = content.get("annotations") if isinstance(content, dict) else content
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise FileError(path, "is no annotation: a list of rows, in JSON under 'annotations', was expected")
    described = content.get("containers") if isinstance(content, dict) else None
    return [{str(key).strip().lower(): row[key] for key in row} for row in rows], _containers_of(described)


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
) -> tuple[dict[str, Annotation], list[str]]:
    """Annotations by recording id, and what was wrong with the rows."""
    problems = []
    present = {key for row in rows for key in row}
    absent = [column.key for column in _COLUMNS.values() if column.key not in present]
    if rows and absent:
        problems.append(f"there is no column {', '.join(repr(key) for key in absent)}")
    by_id: dict[str, Annotation] = {}
    unusable: dict[str, list[str]] = {column.key: [] for column in _COLUMNS.values() if column.key not in absent}
    without_id, repeated = 0, []
    for row in rows:
        name = recording_id(row.get("id"))
        if name is None:
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
    return by_id, problems


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
