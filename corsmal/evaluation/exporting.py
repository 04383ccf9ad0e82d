"""Tables as CSV, LaTeX, HTML and Markdown, with the digits that mean something."""

from collections.abc import Callable
from typing import Literal, get_args

import pandas as pd

from corsmal.errors import ArgumentError, check_choice
from corsmal.evaluation.escaping import csv_file, latex_text, markdown_text

TableFormat = Literal["csv", "latex", "html", "markdown"]
TABLE_FORMATS: tuple[TableFormat, ...] = get_args(TableFormat)
ENDINGS: dict[TableFormat, str] = {"csv": ".csv", "latex": ".tex", "html": ".html", "markdown": ".md"}
"""Of the files' names."""

MISSING = "–"

Lines = list[list[str]]
"""The cells of a table by row, the headings first."""

_UNITS = {
    "_mpf1": ", MPF1 (%) ↑",
    "_mape": ", MAPE (%) ↓",
    "_percent": " (%)",
    "_removed": ", removed (%)",
    "_ml": " (mL)",
    "_mm": " (mm)",
    "_g": " (g)",
    "_deg": " (°)",
    "_s": " (s)",
}
"""Endings of column names, and how people read them."""


def export_table(table: pd.DataFrame, *, table_format: TableFormat, digits: int = 1) -> str:
    """A table as text, which ends in a line break.

    Args:
        table: its index is left out unless it has a name.
        table_format: ``csv`` keeps the columns' names and leaves out what is missing; ``latex`` (with booktabs' rules),
            ``html`` (a ``<table>``) and ``markdown`` have headings for people and a dash. Texts are escaped: none is
            taken for a formula, a command or markup, see ``corsmal.evaluation.escaping``.
        digits: after the point, in numbers that are not whole by nature.

    Raises:
        ArgumentError: the format is unknown, or digits is negative.
    """
    check_choice("table_format", table_format, TABLE_FORMATS)
    if digits < 0:
        raise ArgumentError(f"digits must not be negative, got {digits}")
    named = table.reset_index() if table.index.names != [None] else table
    columns = [_texts(named[name], digits, missing="" if table_format == "csv" else MISSING) for name in named.columns]
    if table_format == "csv":
        return csv_file(pd.DataFrame(dict(enumerate(columns))).set_axis(named.columns, axis=1))
    is_number = [pd.api.types.is_numeric_dtype(dtype) for dtype in named.dtypes]
    signed = [
        [text.replace("-", "−") for text in column] if right else column
        for column, right in zip(columns, is_number, strict=True)
    ]
    lines = [[heading(str(name)) for name in named.columns], *map(list, zip(*signed, strict=True))]
    return _WRITERS[table_format](lines, is_number) + "\n"


def heading(name: str) -> str:
    """A column's name as people read it: ``capacity_mape`` is "Capacity, MAPE (%) ↓"."""
    for ending, shown in _UNITS.items():
        if name.endswith(ending):
            return heading(name.removesuffix(ending)) + shown
    words = name.replace("_", " ")
    return words[:1].upper() + words[1:]


def _texts(column: pd.Series, digits: int, missing: str) -> list[str]:
    is_float = pd.api.types.is_float_dtype(column.dtype)
    return [missing if pd.isna(value) else f"{value:.{digits}f}" if is_float else str(value) for value in column]


def _latex(lines: Lines, is_number: list[bool]) -> str:
    head, *rows = [" & ".join(map(latex_text, cells)) + r" \\" for cells in lines]
    columns = "".join("r" if right else "l" for right in is_number)
    start = [rf"\begin{{tabular}}{{{columns}}}", r"\toprule", head, r"\midrule"]
    return "\n".join([*start, *rows, r"\bottomrule", r"\end{tabular}"])


def _html(lines: Lines, is_number: list[bool]) -> str:  # noqa: ARG001 - one signature for all formats
    return str(pd.DataFrame(lines[1:], columns=lines[0]).to_html(index=False, escape=True, border=0))


def _markdown(lines: Lines, is_number: list[bool]) -> str:
    rules = ["---:" if right else "---" for right in is_number]
    escaped = [[markdown_text(cell) for cell in cells] for cells in lines]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (escaped[0], rules, *escaped[1:]))


_WRITERS: dict[str, Callable[[Lines, list[bool]], str]] = {"latex": _latex, "html": _html, "markdown": _markdown}
