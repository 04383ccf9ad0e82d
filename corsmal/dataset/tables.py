"""The one reader of tables that come from outside: annotations, submissions, estimates."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from corsmal.dataset.headings import Columns
from corsmal.dataset.ids import recording_id
from corsmal.dataset.number_cells import Decimal, find_decimal
from corsmal.dataset.table_shape import Grid, find_grid
from corsmal.dataset.text_files import read_text
from corsmal.errors import ArgumentError, FileError

_NOTHING = {"", "na", "n/a", "#n/a", "nan", "-nan", "null", "none", "<na>", "-"}
"""What programs write where there is nothing."""


@dataclass(frozen=True)
class Table:
    """A table's cells as text, whatever program wrote them.

    Args:
        names: the columns' names: those that ``Columns`` knows by its names, others as they stand in the file.
        rows: a cell per column, None where there is nothing. Numbers have a decimal point, ids are as ``recording_id``
            gives them where it does.
        notes: what was assumed, a sentence each.
    """

    names: tuple[str, ...]
    rows: tuple[tuple[str | None, ...], ...]
    notes: tuple[str, ...] = ()


def read_table(path: Path, columns: Columns) -> Table:
    """Read a table of text: encoding, separator and decimal sign are found, and noted where unusual.

    Args:
        path: the file.
        columns: what the table may hold.

    Raises:
        FileError: the file cannot be read, is no such table, or can be read in two ways; the text says what to do.
    """
    text = read_text(path)
    try:
        grid = find_grid(text.content, columns)
        cells = [
            cell
            for row in grid.rows
            for name, cell in zip(grid.names, row, strict=True)
            if name != columns.ids and name not in columns.texts
        ]
        decimal = find_decimal(cells, separator=grid.separator)
    except ArgumentError as error:
        raise FileError(path, str(error)) from error
    notes = [text.note, *grid.notes, decimal.note, _on_headings(grid, columns), _on_ids(grid, columns)]
    rows = tuple(
        tuple(_cell(cell, name, columns, decimal) for name, cell in zip(grid.names, row, strict=True))
        for row in grid.rows
    )
    names = tuple(name or heading.strip() for name, heading in zip(grid.names, grid.headings, strict=True))
    return Table(names, rows, tuple(filter(None, notes)))


def _cell(cell: str, name: str | None, columns: Columns, decimal: Decimal) -> str | None:
    text = cell.strip()
    if name in columns.texts:
        return text or None
    if text.casefold() in _NOTHING:
        return None
    return (recording_id(text) or text) if name == columns.ids else decimal.plain(text)


def _on_headings(grid: Grid, columns: Columns) -> str:
    """Which headings are spelled otherwise than the table's kind spells them."""
    spelled = [
        f"{heading.strip()!r} as {name!r}"
        for heading, name in zip(grid.headings, grid.names, strict=True)
        if name is not None and heading.strip() and heading.strip() not in columns.spelled(name)
    ]
    more = f" and {len(spelled) - 2} more" if len(spelled) > 2 else ""
    return f"headings are read by their meaning: {', '.join(spelled[:2])}{more}" if spelled else ""


def _on_ids(grid: Grid, columns: Columns) -> str:
    """Which ids are written as something else than a number or a name."""
    cells = _column(grid, columns.ids)
    odd = next((cell for cell in cells if (name := recording_id(cell)) and cell.strip().zfill(len(name)) != name), None)
    return "" if odd is None else f"ids such as {odd.strip()!r} are read as {recording_id(odd)}"


def _column(grid: Grid, name: str) -> Sequence[str]:
    return [row[grid.names.index(name)] for row in grid.rows] if name in grid.names else []
