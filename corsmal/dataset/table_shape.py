"""The rows and columns of a text table: what separates them, where the headings stand, which cells are too many."""

import csv
import io
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from corsmal.dataset.headings import Columns, repeated
from corsmal.dataset.ids import recording_id
from corsmal.errors import ArgumentError

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "vertical bars"}
"""What may separate columns, and what people call it."""

LINES_ABOVE_MAX = 10
"""Lines above the headings that may be titles, dates or names of programs."""

_SEPARATOR_LINE = re.compile(r"\s*\"?sep=(.)\"?\s*", re.IGNORECASE)

_QUOTED_NUMBER = re.compile(r'^"\d+"', re.MULTILINE)

Row = list[str]


@dataclass(frozen=True)
class Grid:
    """A table's cells as they stand in the file, as many in every row as there are headings.

    Args:
        headings: as they stand there.
        names: the columns' names; None for what ``Columns`` does not know.
        rows: the cells.
        separator: of the columns.
        notes: what was assumed or left out, a sentence each.
    """

    headings: Row
    names: list[str | None]
    rows: list[Row]
    separator: str
    notes: list[str]


def find_grid(text: str, columns: Columns) -> Grid:
    """Find rows and columns.

    Raises:
        ArgumentError: there is no known heading, or the rows can be read in two ways or in none.
    """
    separator, place, lines = _found(text, columns)
    headings, rows = lines[place], [row for row in lines[place + 1 :] if any(cell.strip() for cell in row)]
    notes = [] if separator == "," else [f"its columns are separated by {SEPARATORS[separator]}"]
    if any(cell.strip() for line in lines[:place] for cell in line):
        notes.append(f"what stands above the headings is left out ({place} line{'s' if place > 1 else ''})")
    are_numbered = len(_QUOTED_NUMBER.findall(text)) >= len(rows)
    headings, rows, more = _even(headings, rows, separator, are_numbered=are_numbered)
    notes += more
    names = columns.names(headings)
    kept, more = _kept(headings, names, rows, columns)
    return Grid(
        [headings[place] for place in kept],
        [names[place] for place in kept],
        [[row[place] for place in kept] for row in rows],
        separator,
        notes + more,
    )


def _found(text: str, columns: Columns) -> tuple[str, int, list[Row]]:
    """The separator, the place of the headings, and the lines: those in which most headings are known.

    Raises:
        ArgumentError: no line has a known heading, or two separators find as many.
    """
    if declared := _SEPARATOR_LINE.fullmatch(text.split("\n", 1)[0]):
        text = text.split("\n", 1)[1] if "\n" in text else ""
    separators = [declared[1]] if declared and declared[1] in SEPARATORS else list(SEPARATORS)
    best: list[tuple[int, str, int, list[Row]]] = []
    problem: csv.Error | None = None
    for separator in separators:
        try:
            lines = _lines(text, separator)
        except csv.Error as error:
            problem = error
            continue
        for place, line in enumerate(lines[: LINES_ABOVE_MAX + 1]):
            known = _known(line, columns)
            if known and (not best or known > best[0][0]):
                best = [(known, separator, place, lines)]
            elif known > 1 and known == best[0][0] and separator != best[0][1]:
                best.append((known, separator, place, lines))
    if not best:
        if problem is not None:
            raise ArgumentError(f"is no table of text ({problem}); is a quotation mark not closed?") from problem
        if not text.strip():
            raise ArgumentError("is empty")
        first = next(iter(text.strip().splitlines()))[:60]
        raise ArgumentError(f"has no heading that is known, such as {columns.ids!r}; its first line is {first!r}")
    if len(best) > 1:
        found = " and ".join(SEPARATORS[separator] for _, separator, _, _ in best)
        raise ArgumentError(f"its columns can be separated by {found}; use one of them in all rows")
    _, separator, place, lines = best[0]
    return separator, place, lines


def _lines(text: str, separator: str) -> list[Row]:
    lines = list(csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True))
    lines = [line for line in lines if line]
    # whole lines in quotes, as some programs export them
    if lines and all(len(line) == 1 for line in lines) and separator in lines[0][0]:
        lines = list(csv.reader((line[0] for line in lines), delimiter=separator, strict=True))
    return lines


def _known(line: Sequence[str], columns: Columns) -> int:
    try:
        return sum(name is not None for name in columns.names(line))
    except ArgumentError:  # a unit that is refused: it is a heading
        return len(line)


def _even(headings: Row, rows: list[Row], separator: str, *, are_numbered: bool) -> tuple[Row, list[Row], list[str]]:
    """Headings and rows of one length, and what was done to them.

    Raises:
        ArgumentError: rows have other numbers of cells than there are headings, for no known reason.
    """
    notes = []
    while headings and not headings[-1].strip() and all(not "".join(row[len(headings) - 1 :]).strip() for row in rows):
        headings = headings[:-1]
        rows = [row[: len(headings)] for row in rows]
    count = len(headings)
    if any(len(row) > count for row in rows) and all(not "".join(row[count:]).strip() for row in rows):
        notes.append(f"its rows end in more {SEPARATORS[separator]} than its headings; these are left out")
        rows = [row[:count] for row in rows]
    # R writes rows' names in quotes and no heading for them; without quotes it may be a decimal comma that counts
    if are_numbered and all(len(row) == count + 1 for row in rows) and _is_running(row[0] for row in rows):
        notes.append("its rows begin with their numbers, which have no heading and are left out")
        rows = [row[1:] for row in rows]
    _check_lengths(rows, count, separator)
    short = sum(len(row) < count for row in rows)
    if short:
        notes.append(f"{short} of its {len(rows)} rows end before the last column; what they lack is missing")
    return headings, [row + [""] * (count - len(row)) for row in rows], notes


def _check_lengths(rows: Sequence[Row], count: int, separator: str) -> None:
    longer = next((row for row in rows if len(row) > count), None)
    if longer is not None:
        is_comma = separator == ","
        advice = (
            "; put numbers with decimal commas in quotes, or separate the columns by semicolons" if is_comma else ""
        )
        raise ArgumentError(
            f"the row {separator.join(longer)[:40]!r} has {len(longer)} cells where there are {count} headings{advice}"
        )
    if count > 1 and rows and all(len(row) == 1 for row in rows):
        raise ArgumentError(f"its headings are separated by {SEPARATORS[separator]} and its rows are not")


def _kept(headings: Row, names: list[str | None], rows: list[Row], columns: Columns) -> tuple[list[int], list[str]]:
    """The places of the columns to keep, and what is left out: columns that nobody named, or that stand twice.

    A first column without a heading becomes that of the ids, where there is none and it can only be that.

    Raises:
        ArgumentError: two columns of one name differ, or that first column may be the rows' numbers.
    """
    notes = []
    unnamed = [place for place, heading in enumerate(headings) if _is_unnamed(heading)]
    if columns.ids not in names and unnamed[:1] == [0] and _are_ids([row[0] for row in rows]):
        names[0] = columns.ids
        notes.append("its first column has no heading; its values are taken as the recordings' ids")
        unnamed = unnamed[1:]
    if unnamed:
        notes.append("a column without a heading is left out")
    left_out = set(unnamed)
    for name in repeated(names):
        first, *others = [place for place, found in enumerate(names) if found == name]
        for other in others:
            if not all(_is_same(row[first], row[other]) for row in rows):
                raise ArgumentError(
                    f"the columns {headings[first]!r} and {headings[other]!r} differ and both mean {name!r}; keep one"
                )
        left_out |= set(others)
    return [place for place in range(len(headings)) if place not in left_out], notes


def _is_unnamed(heading: str) -> bool:
    return not heading.strip() or re.fullmatch(r"unnamed: ?\d+", heading.strip().lower()) is not None


def _is_same(one: str, other: str) -> bool:
    return one.strip() == other.strip() or (recording_id(one) is not None and recording_id(one) == recording_id(other))


def _is_running(cells: Iterable[str]) -> bool:
    """Whether cells count the rows, from 0 or 1."""
    found = [cell.strip() for cell in cells]
    return any(found == [str(place + first) for place in range(len(found))] for first in (0, 1))


def _are_ids(cells: Sequence[str]) -> bool:
    """Whether cells without a heading can only be ids: all different, and not merely the rows' numbers.

    Raises:
        ArgumentError: they count the rows.
    """
    if _is_running(cells) and len(cells) > 1:
        raise ArgumentError(
            "its first column has no heading and counts the rows, so it is not clear whether it holds the recordings' "
            "ids; name the column of ids"
        )
    ids = [recording_id(cell) for cell in cells]
    return None not in ids and len(set(ids)) == len(ids)
