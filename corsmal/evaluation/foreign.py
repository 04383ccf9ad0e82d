"""Estimates and submissions from files of other programs, as data frames."""

import csv
import io
import json
from pathlib import Path
from typing import Any

import pandas as pd

from corsmal.dataset.headings import Columns
from corsmal.dataset.tables import read_table
from corsmal.dataset.text_files import read_text
from corsmal.errors import ArgumentError, FileError

ASSUMED = "assumed"
"""The key of a data frame's ``attrs`` under which stand sentences on how its file was read."""

SOURCES = {
    "Container capacity": "capacity_ml",
    "Container mass": "container_mass_g",
    "Filling mass": "filling_mass_g",
    "None": "type_p0",
    "Pasta": "type_p1",
    "Rice": "type_p2",
    "Water": "type_p3",
    "Filling type": "filling_type",
    "Empty": "level_p0",
    "Half-full": "level_p1",
    "Full": "level_p2",
    "Filling level": "filling_level",
    "Width at the top": "width_top_mm",
    "Width at the bottom": "width_bottom_mm",
    "Height": "height_mm",
    "Execution time": "execution_time_ms",
}
"""A submission's columns that come from an estimates table, in order, and what they are called there."""

_ENDS = {"_ml": "mL", "_mm": "mm", "_g": "g", "_ms": "ms"}
UNITS = {
    name: unit
    for shown, source in SOURCES.items()
    for end, unit in _ENDS.items()
    if source.endswith(end)
    for name in (shown, source)
}
"""Unit of each column that has one, under both names."""


def read_frame(path: Path, columns: Columns) -> pd.DataFrame:
    """Read a table of text, JSON (a list of rows) or Parquet.

    Args:
        path: the file; what ends in neither ``.json`` nor ``.parquet`` is text.
        columns: what it may hold.

    Returns:
        Its columns under the names of ``columns``, others as they stand; ids and texts as text. ``attrs`` holds under
        ``ASSUMED`` how the file was read, where that is not plain.

    Raises:
        FileError: the file is absent, broken, or no such table.
    """
    ending = path.suffix.lower()
    if ending not in (".json", ".parquet"):
        return _from_text(path, columns)
    try:
        frame = pd.read_parquet(path) if ending == ".parquet" else _from_json(path)
        if frame.index.name is not None:
            frame = frame.reset_index()
        names = columns.names(list(frame.columns))
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror or error})") from error
    except (ValueError, TypeError, RecursionError) as error:
        raise FileError(path, f"is no table of estimates ({error}); make it again") from error
    frame.columns = pd.Index([name or shown for name, shown in zip(names, frame.columns, strict=True)])
    return frame.loc[:, ~frame.columns.duplicated()]


def _from_text(path: Path, columns: Columns) -> pd.DataFrame:
    table = read_table(path, columns)
    buffer = io.StringIO(newline="")
    csv.writer(buffer).writerows([table.names, *table.rows])
    buffer.seek(0)
    texts = dict.fromkeys((columns.ids, *columns.texts), "str")
    try:
        frame = pd.read_csv(buffer, dtype=texts, keep_default_na=False, na_values=[""], low_memory=False)
    except ValueError as error:
        raise FileError(path, f"is no table of estimates ({error}); make it again") from error
    frame.attrs[ASSUMED] = tuple(f"{path.name}: {note}" for note in table.notes)
    return frame


def _from_json(path: Path) -> pd.DataFrame:
    content: Any = json.loads(read_text(path).content)
    if not isinstance(content, list) or not all(isinstance(row, dict) for row in content):
        raise ArgumentError("a list of rows was expected")
    return pd.DataFrame(content)
