"""Texts from files and people in tables, so that no reader of them takes a text for a formula, a command or markup."""

import re
import unicodedata

import pandas as pd

_NUMBER = re.compile(r"[+-]?[\d.,]+(e[+-]?\d+)?( ?(%|mL|mm|g|s))?")
_FORMULA = "=+-@\t\r＝＋－＠"
"""What a spreadsheet takes for the beginning of a formula."""

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
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"''",
    "`": r"\textasciigrave{}",
    "↑": r"$\uparrow$",
    "↓": r"$\downarrow$",
    "→": r"$\rightarrow$",
    "−": "$-$",
    "–": "--",
    "—": "---",
    "×": r"$\times$",
    "±": r"$\pm$",
    "≤": r"$\leq$",
    "≥": r"$\geq$",
    "Δ": r"$\Delta$",
    "·": r"\textperiodcentered{}",
    "°": r"\textdegree{}",
    "µ": r"\textmu{}",
    "μ": r"\textmu{}",
    "…": r"\ldots{}",
    "“": "``",
    "”": "''",
    "‘": "`",
    "’": "'",
}


def one_line(text: str) -> str:
    """Text without line breaks and other control characters, each stretch of white space one blank."""
    return " ".join("".join(" " if unicodedata.category(sign)[0] in "CZ" else sign for sign in text).split())


def csv_text(text: str) -> str:
    """Text that no spreadsheet takes for a formula: an apostrophe stands before what would begin one.

    A number with its sign and unit is left as it is.
    """
    return f"'{text}" if text[:1] in _FORMULA and text and not _NUMBER.fullmatch(text) else text


def csv_file(table: pd.DataFrame, *, absent: str = "") -> str:
    """A table as the text of a CSV file without its index; texts and headings are those of ``csv_text``.

    Args:
        table: the table.
        absent: what stands where a value is missing.
    """
    columns = [table.iloc[:, number] for number in range(table.shape[1])]
    safe = {number: column if _is_numeric(column) else column.map(_safe) for number, column in enumerate(columns)}
    heads = [csv_text(str(name)) for name in table.columns]
    shown = pd.DataFrame(safe, index=table.index)
    return shown.to_csv(index=False, header=heads, lineterminator="\n", na_rep=absent)


def latex_text(text: str) -> str:
    """Text on one line with LaTeX's own signs escaped; for what pdfLaTeX has no sign stands a question mark."""
    escaped = "".join(_LATEX.get(sign) or _latin(sign) for sign in one_line(text))
    # after the end of a table's row these two would belong to it
    return f"{{{escaped[0]}}}{escaped[1:]}" if escaped[:1] in ("[", "*") else escaped


def markdown_text(text: str) -> str:
    """Text on one line that is no markup: neither a cell's end, nor HTML, a link, a picture or code."""
    escaped = re.sub(r"([\\|`])", r"\\\1", one_line(text)).replace("](", r"]\(")
    return escaped.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def _is_numeric(column: pd.Series) -> bool:
    return pd.api.types.is_numeric_dtype(column.dtype)


def _safe(value: object) -> object:
    return csv_text(value) if isinstance(value, str) else value


def _latin(sign: str) -> str:
    """A sign that pdfLaTeX has: Latin letters as they are, others without accents or as a question mark."""
    plain = unicodedata.normalize("NFKD", sign).encode("ascii", "ignore").decode()
    if sign < "\u0100" or sign in "łŁœŒı" or (sign < "\u0180" and plain):
        return sign
    return "".join(_LATEX.get(each, each) for each in plain) or "?"
