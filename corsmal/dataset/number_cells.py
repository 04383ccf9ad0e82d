"""Numbers in tables as spreadsheets write them: with a decimal comma or point, in groups of three digits."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from corsmal.errors import ArgumentError

Sign = Literal[".", ","]

_NUMBER = re.compile(r"([-+]?)(\d[\d.,]*|[.,]\d+)((?:[eE][-+]?\d+)?)")
_SPACED = re.compile(r"[-+]?\d{1,3}(?:[ '’\u00a0\u202f\u2009]\d{3})+(?:[.,]\d+)?")
_GROUPED: dict[str, re.Pattern[str]] = {sign: re.compile(rf"[1-9]\d{{0,2}}(?:\{sign}\d{{3}})+") for sign in ".,"}


@dataclass(frozen=True)
class Decimal:
    """How a table writes its numbers.

    Args:
        sign: what stands before the decimals.
        note: what was assumed, where it is not what Python writes; else empty.
    """

    sign: Sign = "."
    note: str = ""

    def plain(self, cell: str) -> str:
        """A cell's number as Python reads it; a cell that holds something else stays as it is."""
        found = _NUMBER.fullmatch(_tidied(cell))
        if found is None:
            return cell
        head, digits, power = found.groups()
        groups = "," if self.sign == "." else "."
        whole, point, rest = digits.partition(self.sign)
        is_number = rest.isdecimal() or not rest
        if not is_number or (groups in whole and not _GROUPED[groups].fullmatch(whole)):
            return cell
        return f"{head}{whole.replace(groups, '')}{'.' if point else ''}{rest}{power}"


def find_decimal(cells: Iterable[str], *, separator: str) -> Decimal:
    """How the numbers in a table's cells are written.

    Args:
        cells: all cells that may hold numbers.
        separator: of the table's columns.

    Raises:
        ArgumentError: they can be read in two ways; the text names a cell.
    """
    sure: dict[Sign, str] = {}
    open_cells: dict[Sign, str] = {}
    is_grouped = False
    for cell in cells:
        text = _tidied(cell)
        if _NUMBER.fullmatch(text) is None:
            continue
        is_grouped |= text != cell.strip() and _SPACED.fullmatch(cell.strip()) is not None
        written, is_sure = _sign(text.lstrip("+-"))
        if written is not None:
            (sure if is_sure else open_cells).setdefault(written, cell.strip())
    if len(sure) > 1:
        raise ArgumentError(
            f"its numbers have a decimal comma ({sure[',']}) and a decimal point ({sure['.']}); write all with a point"
        )
    if not sure and "," in open_cells:
        raise ArgumentError(
            f"{open_cells[',']!r} may have a decimal comma or a comma between thousands; write numbers with a decimal "
            "point and without separators of thousands"
        )
    if not sure and "." in open_cells and separator == ";":
        raise ArgumentError(
            f"{open_cells['.']!r} may have a decimal point or a point between thousands; write numbers without "
            "separators of thousands"
        )
    sign: Sign = next(iter(sure), ".")
    other: Sign = "." if sign == "," else ","
    notes = ["numbers are read with a decimal comma"] if sign == "," else []
    if other in open_cells:
        notes.append(f"{open_cells[other]!r} is read with a {'point' if other == '.' else 'comma'} between thousands")
    elif is_grouped:
        notes.append("digits are read in groups of thousands")
    return Decimal(sign, " and ".join(notes))


def _tidied(cell: str) -> str:
    """A cell without what only looks: a typeset minus sign, gaps between groups of three digits."""
    text = cell.strip().replace("\u2212", "-")
    return re.sub(r"[ '’\u00a0\u202f\u2009]", "", text) if _SPACED.fullmatch(text) else text


def _sign(number: str) -> tuple[Sign | None, bool]:
    """What stands before the decimals of a number, and whether it can be nothing else; None: it has no decimals."""
    number = re.sub(r"[eE].*", "", number)
    points, commas = number.count("."), number.count(",")
    if points and commas:
        sign: Sign = "." if number.rfind(".") > number.rfind(",") else ","
        return (sign, True) if number.count(sign) == 1 else (None, False)
    if not points and not commas:
        return None, False
    own: Sign = "." if points else ","
    other: Sign = "," if points else "."
    if points + commas > 1:
        return (other, True) if _GROUPED[own].fullmatch(number) else (None, False)
    return own, _GROUPED[own].fullmatch(number) is None
