"""Table 2 as a file: for a spreadsheet, a page, or a paper."""

from collections.abc import Sequence
from typing import Any

import pandas as pd

from corsmal.errors import ArgumentError
from corsmal.evaluation.cells import comparison_note
from corsmal.evaluation.escaping import latex_text, markdown_text, one_line
from corsmal.evaluation.exporting import MISSING, TableFormat, export_table, heading
from corsmal.evaluation.protocols import STAMPS, Protocol
from corsmal.evaluation.tables import METRICS
from corsmal.quantities import BY_METRIC

TITLES: dict[Protocol, str] = {"held-out": "Held-out", "paper": "Paper's protocol", "in-sample": "In-sample"}
PUBLISHED = "Published"
UNLIKE = (
    "The published numbers are of the challenge's training recordings, not of these: they are for orientation, not for "
    "comparison."
)
_KEY = (
    "MPF1: mean percentage of class-wise F1-scores. MAPE: mean absolute percentage error. Brackets: 95 % bootstrap "
    "interval over recordings."
)


def typeset_table_2(
    cells: pd.DataFrame, *, table_format: TableFormat, notes: Sequence[str] = (), is_like_with_like: bool = True
) -> str:
    """Table 2 as text, a column group per protocol and the published numbers beside them.

    Args:
        cells: from ``cell_table``; the tables of several protocols one below the other.
        table_format: ``csv`` (a row per cell, with everything that ``cell_table`` gives), ``html``, ``markdown`` or
            ``latex``: a ``table*`` in the published table's rows and order, which needs ``booktabs`` and ``graphicx``.
        notes: sentences below the table, such as those on what was left out; in LaTeX they are comments.
        is_like_with_like: whether the recordings are the published table's, so that the best number is set in bold. An
            in-sample number never is.

    Raises:
        ArgumentError: it is no such table, or the format is unknown.
    """
    if not {"protocol", "metric", "published"} <= set(cells.columns) or not len(cells):
        raise ArgumentError("cells must come from cell_table")
    if table_format == "csv":
        return export_table(cells, table_format="csv", digits=3)
    stamps = [STAMPS[protocol] for protocol in dict.fromkeys(cells["protocol"])]
    compared = [comparison_note(cells), "" if is_like_with_like else UNLIKE]
    caption = [_KEY, *stamps, *filter(None, compared)]
    if table_format == "latex":
        return _latex(cells, caption, notes, is_like_with_like=is_like_with_like)
    sentences = list(dict.fromkeys((*caption, *notes)))
    table = export_table(table_2_texts(cells), table_format=table_format)
    if table_format == "html":
        return table + export_table(pd.DataFrame({"notes": sentences}), table_format="html")
    return "\n".join([table, *(f"- {markdown_text(sentence)}" for sentence in sentences), ""])


def table_2_texts(cells: pd.DataFrame) -> pd.DataFrame:
    """Table 2 with all of a cell in one text, such as ``77.1 [70.2, 84.0], n = 84, 2 failed``.

    Returns:
        A row per container: ``container``, and under headings for people the metrics of each protocol, then the
        published ones.
    """
    table = _Table(cells)
    columns = {"container": list(table.rows.values())}
    for protocol in table.protocols:
        for metric in METRICS:
            texts = [_cell_text(table.cells.get((protocol, row, metric))) for row in table.rows]
            columns[f"{TITLES[protocol]}: {heading(metric)}"] = texts
    for metric in METRICS:
        texts = [_number(table.published[row, metric]) for row in table.rows]
        columns[f"{PUBLISHED}: {heading(metric)}"] = texts
    return pd.DataFrame(columns)


class _Table:
    """The cells by protocol, row and metric, and the published number of each row and metric.

    ``rows`` holds the containers' names by number in order; the average is number −1.
    """

    def __init__(self, cells: pd.DataFrame) -> None:
        keyed = cells.assign(row=cells["container_id"].fillna(-1).astype("int64"))
        self.protocols: list[Protocol] = list(dict.fromkeys(keyed["protocol"]))
        self.rows = {
            row: name[:1].upper() + name[1:] for row, name in zip(keyed["row"], keyed["container"], strict=True)
        }
        self.rows[-1] = self.rows.pop(-1)
        rows: list[Any] = list(keyed.itertuples())
        self.cells: dict[tuple[str, int, str], Any] = {(cell.protocol, cell.row, cell.metric): cell for cell in rows}
        self.published = keyed.groupby(["row", "metric"])["published"].first()

    def recordings(self, protocol: Protocol, row: int) -> int:
        """How many recordings of a container the protocol's fullest cell counts."""
        cells = [self.cells.get((protocol, row, metric)) for metric in METRICS]
        return max(0 if cell is None else int(cell.recordings) for cell in cells)

    def best(self, row: int, metric: str) -> float | None:
        """The best of a row's numbers as they are printed; None where there is nothing to compare."""
        cells = [self.cells.get((protocol, row, metric)) for protocol in self.protocols if protocol != "in-sample"]
        values = [self.published[row, metric], *(cell.value for cell in cells if cell is not None)]
        known = [round(float(value), 1) for value in values if pd.notna(value)]
        if len(known) < 2:
            return None
        return max(known) if BY_METRIC[metric].is_class else min(known)


def _number(value: float) -> str:
    return MISSING if pd.isna(value) else f"{value:.1f}"


def _interval(cell: Any) -> str:
    return "" if cell is None or pd.isna(cell.low) else f"[{cell.low:.1f}, {cell.high:.1f}]"


def _cell_text(cell: Any) -> str:
    if cell is None or not cell.recordings:
        return MISSING
    value = " ".join(filter(None, [_number(cell.value), _interval(cell)]))
    return f"{value}, n = {cell.recordings}" + (f", {cell.failures} failed" if cell.failures else "")


def _latex(cells: pd.DataFrame, caption: Sequence[str], notes: Sequence[str], *, is_like_with_like: bool) -> str:
    table, metrics = _Table(cells), list(METRICS)
    own, width, groups = len(table.protocols), len(metrics), len(table.protocols) + 1
    titles = [rf"\multicolumn{{{width + 1}}}{{c}}{{{TITLES[protocol]}}}" for protocol in table.protocols]
    starts = [2 + (width + 1) * place for place in range(groups)]
    rules = [rf"\cmidrule(lr){{{start}-{start + width - (start == starts[-1])}}}" for start in starts]
    names = [_heading(metric) for metric in metrics]
    kinds = [r"MPF1 $\uparrow$" if BY_METRIC[metric].is_class else r"MAPE $\downarrow$" for metric in metrics]
    text = latex_text(" ".join(caption)) + (
        " $n$: recordings; a subscript is their number where it differs. Superscripts: recordings without an estimate "
        "of their own." + (" Best in bold." if is_like_with_like else "")
    )
    lines = [
        *(f"% {one_line(sentence)}" for sentence in (*(STAMPS[protocol] for protocol in table.protocols), *notes)),
        r"\begin{table*}",
        r"\centering",
        rf"\caption{{{text}}}",
        r"\resizebox{\textwidth}{!}{%",
        rf"\begin{{tabular}}{{l{('r' * (width + 1)) * own}{'r' * width}}}",
        r"\toprule",
        _line(["", *titles, rf"\multicolumn{{{width}}}{{c}}{{{PUBLISHED}}}"]),
        "".join(rules),
        _line(["Container", *["$n$", *names] * own, *names]),
        _line(["", *["", *kinds] * own, *kinds]),
        r"\midrule",
    ]
    for row in table.rows:
        lines += [r"\midrule"] if row == -1 else []
        lines += _latex_row(table, row, is_like_with_like=is_like_with_like)
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}}", r"\end{table*}", ""])


def _heading(metric: str) -> str:
    quantity = BY_METRIC[metric]
    return f"Filling {quantity.label}" if quantity.is_class else quantity.label.title()


def _latex_row(table: _Table, row: int, *, is_like_with_like: bool) -> list[str]:
    """A container's line of numbers and its line of intervals."""
    best = {metric: table.best(row, metric) if is_like_with_like else None for metric in METRICS}
    numbers, intervals = [latex_text(table.rows[row])], [""]
    for protocol in table.protocols:
        recordings = table.recordings(protocol, row)
        numbers.append(str(recordings))
        intervals.append("")
        for metric in METRICS:
            cell = table.cells.get((protocol, row, metric))
            numbers.append(_marked(cell, recordings, best[metric] if protocol != "in-sample" else None))
            intervals.append(rf"\scriptsize {_interval(cell)}" if _interval(cell) else "")
    numbers += [_bold(table.published[row, metric], best[metric]) for metric in METRICS]
    return [_line(numbers), _line([*intervals, *[""] * len(METRICS)])]


def _marked(cell: Any, recordings: int, best: float | None) -> str:
    """A number with the counts that the table's reader cannot see otherwise."""
    if cell is None:
        return latex_text(MISSING)
    below = f"_{{{cell.recordings}}}" if cell.recordings != recordings else ""
    above = f"^{{{cell.failures}}}" if cell.failures else ""
    return _bold(cell.value, best) + (f"${below}{above}$" if below or above else "")


def _bold(value: float, best: float | None) -> str:
    text = latex_text(_number(value))
    return rf"\textbf{{{text}}}" if best is not None and pd.notna(value) and round(float(value), 1) == best else text


def _line(cells: Sequence[str]) -> str:
    return " & ".join(cells) + r" \\"
