"""Tables as CSV, LaTeX and HTML, with the digits that mean something."""

from collections.abc import Callable
from typing import Literal, get_args

import pandas as pd

from corsmal.errors import ArgumentError

TableFormat = Literal["csv", "latex", "html"]
TABLE_FORMATS: tuple[TableFormat, ...] = get_args(TableFormat)

MISSING = "–"

_ENDINGS = {
    "_mpf1": ", MPF1 (%) ↑",
    "_mape": ", MAPE (%) ↓",
    "_percent": " (%)",
    "_removed": ", removed (%)",
    "_ml": " (mL)",
    "_mm": " (mm)",
    "_g": " (g)",
    "_s": " (s)",
}
"""Endings of column names, and how people read them."""

_LATEX = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "%": r"\%",
    "&": r"\&",
    "#": r"\#",
    "_": r"\_",
    "$": r"\$",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "↑": r"$\uparrow$",
    "↓": r"$\downarrow$",
    "→": r"$\rightarrow$",
    "−": "$-$",
    "–": "--",
}


def export_table(table: pd.DataFrame, *, table_format: TableFormat, digits: int = 1) -> str:
    """A table as text.

    Args:
        table: its index is left out unless it has a name.
        table_format: ``csv`` keeps the columns' names and leaves out what is missing; ``latex`` (with booktabs' rules)
            and ``html`` (a ``<table>``) have headings for people and a dash.
        digits: after the point, in numbers that are not whole by nature.

    Returns:
        The text, ending in a line break.

    Raises:
        ArgumentError: the format is unknown, or digits is negative.
    """
    if table_format not in TABLE_FORMATS:
        raise ArgumentError(f"table_format must be one of {', '.join(TABLE_FORMATS)}, got {table_format!r}")
    if digits < 0:
        raise ArgumentError(f"digits must not be negative, got {digits}")
    named = table.reset_index() if table.index.names != [None] else table
    missing = "" if table_format == "csv" else MISSING
    texts = pd.DataFrame({name: _texts(named[name], digits, missing) for name in named.columns}, dtype="object")
    if table_format == "csv":
        return texts.to_csv(index=False, lineterminator="\n")
    texts.columns = pd.Index([heading(str(name)) for name in named.columns])
    is_number = [pd.api.types.is_numeric_dtype(dtype) for dtype in named.dtypes]
    return _WRITERS[table_format](texts, is_number) + "\n"


def heading(name: str) -> str:
    """A column's name as people read it: ``capacity_mape`` is "Capacity, MAPE (%) ↓"."""
    for ending, shown in _ENDINGS.items():
        if name.endswith(ending):
            return heading(name.removesuffix(ending)) + shown
    words = name.replace("_", " ")
    return words[:1].upper() + words[1:]


def _texts(column: pd.Series, digits: int, missing: str) -> list[str]:
    is_float = pd.api.types.is_float_dtype(column.dtype)
    return [missing if pd.isna(value) else f"{value:.{digits}f}" if is_float else str(value) for value in column]


def _latex(texts: pd.DataFrame, is_number: list[bool]) -> str:
    def row(cells: list[str]) -> str:
        return " & ".join("".join(_LATEX.get(letter, letter) for letter in cell) for cell in cells) + r" \\"

    lines = [
        [_signed(cell) if right else cell for cell, right in zip(cells, is_number, strict=True)]
        for cells in texts.to_numpy()
    ]
    columns = "".join("r" if right else "l" for right in is_number)
    return "\n".join(
        [
            rf"\begin{{tabular}}{{{columns}}}",
            r"\toprule",
            row(list(texts.columns)),
            r"\midrule",
            *map(row, lines),
            r"\bottomrule",
            r"\end{tabular}",
        ]
    )


def _html(texts: pd.DataFrame, is_number: list[bool]) -> str:
    signed = pd.DataFrame(
        {
            name: [_signed(cell) for cell in texts[name]] if right else texts[name]
            for name, right in zip(texts, is_number, strict=True)
        }
    )
    return str(signed.to_html(index=False, escape=True, border=0))


def _signed(text: str) -> str:
    """A number with a minus sign in place of a hyphen."""
    return text.replace("-", "−")


_WRITERS: dict[str, Callable[[pd.DataFrame, list[bool]], str]] = {"latex": _latex, "html": _html}
