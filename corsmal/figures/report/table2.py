"""The paper's Table 2 as HTML: its rows and columns, under each number its interval and the published one."""

import html
from collections.abc import Hashable, Mapping
from typing import Any

import pandas as pd

from corsmal.evaluation.exporting import MISSING
from corsmal.evaluation.tables import METRICS
from corsmal.figures.report.blocks import Table2
from corsmal.quantities import BY_METRIC


def table_2_html(block: Table2) -> str:
    """Table 2; a row per container, the average last."""
    keyed = block.cells.assign(row=block.cells["container_id"].fillna(-1).astype("int64"))
    groups = dict(list(keyed.groupby("row", sort=False)))
    rows = "".join(_row(group, block, is_average=row == -1) for row, group in groups.items())
    classes = [metric for metric in METRICS if BY_METRIC[metric].is_class]
    names = "".join(f'<th class="number">{BY_METRIC[metric].label}</th>' for metric in METRICS)
    return (
        f'<table class="table2"><caption>{html.escape(block.caption)}</caption><thead>'
        f'<tr><th rowspan="2">Container</th><th rowspan="2" class="number">Recordings</th>'
        f'<th colspan="{len(classes)}">MPF1 (%) ↑</th><th colspan="{len(METRICS) - len(classes)}">MAPE (%) ↓</th></tr>'
        f"<tr>{names}</tr></thead><tbody>{rows}</tbody></table>"
    )


def _row(cells: pd.DataFrame, block: Table2, *, is_average: bool) -> str:
    name = str(cells["container"].iloc[0])
    failed = int(cells["failures"].max())
    count = f"{int(cells['recordings'].max())}" + (f"<small>{failed} failed</small>" if failed else "")
    by_metric = {str(cell["metric"]): cell for cell in cells.to_dict("records")}
    numbers = "".join(_cell(by_metric[metric], metric, block) for metric in METRICS)
    kind = ' class="average"' if is_average else ""
    return f'<tr{kind}><th>{html.escape(name[:1].upper() + name[1:])}</th><td class="number">{count}</td>{numbers}</tr>'


def _cell(cell: Mapping[Hashable, Any], metric: str, block: Table2) -> str:
    own, paper = (None if pd.isna(cell[name]) else round(float(cell[name]), 1) for name in ("value", "published"))
    shown = MISSING if own is None else f"{own:.1f}"
    if block.is_like_with_like and own is not None and paper is not None:
        is_best = own >= paper if BY_METRIC[metric].is_class else own <= paper
        shown = f"<b>{shown}</b>" if is_best else shown
    spread = "" if pd.isna(cell["low"]) else f"<small>[{cell['low']:.1f}, {cell['high']:.1f}]</small>"
    beside = "" if paper is None else f'<small class="published">paper {paper:.1f}</small>'
    return f'<td class="number">{shown}{spread}{beside}</td>'
