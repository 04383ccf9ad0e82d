"""The tables of the Evaluation page, Table 2 and that of every recording, and their downloads."""

from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
import streamlit as st
from pandas.io.formats.style import Styler

from corsmal.evaluation import METRICS, PROTOCOLS, comparison_note, container_table, typeset_table_2
from corsmal.evaluation.protocols import Protocol
from corsmal.evaluation.tables import AVERAGE
from corsmal.evaluation.typesetting import TITLES, UNLIKE
from corsmal.ui import session
from corsmal.ui.evaluation.downloads import downloads, submission
from corsmal.ui.evaluation.judged import METRIC_NAMES, Judged
from corsmal.ui.evaluation.links import clicked_row
from corsmal.ui.evaluation.panel import beside_panel, focus_container, newly_selected
from corsmal.ui.one_of import one_of

SECTION = "table"
GOOD, BAD, GREY = "#0D9488", "#E5484D", "#8A8F98"
WORST_PERCENT = 60.0
"""A shortfall that is shaded to the full."""

SHORT = {"width_top_mape": "Top", "width_bottom_mape": "Bottom"}
SIDES = {
    "difference": ("difference to the paper", "Δ", 54),
    "published": ("published number", "paper", 54),
    "interval": ("95 % interval", "95 %", 96),
    "counts": ("recordings (failed)", "n", 84),
}
"""What stands beside a number: its name, heading, and width in px."""


def container_section(judged: Judged) -> None:
    """Table 2 beside the paper's; a click on a number lists its recordings."""
    run, protocol, errors = judged.run, judged.protocol, judged.errors()
    left, right = st.columns([5, 3], vertical_alignment="bottom")
    with left:
        names = {"nothing": "nothing"} | {side: name for side, (name, _, _) in SIDES.items()}
        side = one_of("Beside each number", names, key="table_side", field="beside")
    others = [name for name in PROTOCOLS if name != protocol]
    more = right.pills(
        "Further column groups", others, selection_mode="multi", format_func=TITLES.__getitem__, key=f"more {protocol}"
    )
    cells = pd.concat([replace(judged, protocol=name).cells() for name in (protocol, *more)], ignore_index=True)
    shown, styled = table_2(container_table(errors), cells, side=side)
    key = f"table_2 {run.name} {side} {protocol} {more}"
    _focus_clicked(errors, shown, key=key)
    with beside_panel(judged, section=SECTION):
        st.dataframe(
            styled,
            key=key,
            on_select="rerun",
            selection_mode="single-cell",
            hide_index=True,
            height=38 + 35 * len(shown),
            column_config=_columns(shown),
            placeholder="–",
        )
    is_like_with_like = judged.split.split == "train"
    st.caption(
        "Level and type: MPF1 in %, the higher the better; the others: MAPE in %, the lower the better. The more "
        "orange, the worse. Click a number to list its recordings, a heading to sort."
    )
    for sentence in (_left_out(cells), comparison_note(cells), "" if is_like_with_like else f"**{UNLIKE}**"):
        if sentence:
            st.caption(sentence)
    export = partial(typeset_table_2, notes=errors.attrs["notes"], is_like_with_like=is_like_with_like)
    downloads(cells, name=f"{run.name}_table2", export=export)


def _focus_clicked(errors: pd.DataFrame, shown: pd.DataFrame, *, key: str) -> None:
    """Look at the recordings behind the number of the table that was clicked in the browser."""
    clicked = newly_selected(key)
    if clicked is not None and clicked[0] < len(shown):
        container = str(shown["container"].iloc[clicked[0]])
        one = None if container == AVERAGE else container
        focus_container(errors, section=SECTION, metric=_metric_of(clicked[1]), container=one)


def table_2(table: pd.DataFrame, cells: pd.DataFrame, *, side: str) -> tuple[pd.DataFrame, Styler]:
    """Table 2 as the page shows it, and with its colours.

    Args:
        table: from ``container_table``.
        cells: from ``cell_table``, of one or several protocols, of the same recordings.
        side: a key of ``SIDES``, or ``nothing``.

    Returns:
        A row per container; a metric's column is named after it, with what stands beside it before, and before that
        the protocol where it is not the first.
    """
    shown = pd.DataFrame({"container": table["container"], "n": table["recordings"], "failed": table["failures"]})
    protocols = list(dict.fromkeys(cells["protocol"]))
    for protocol, metric in product(protocols, METRICS):
        own = cells[(cells["protocol"] == protocol) & (cells["metric"] == metric)]
        prefix = "" if protocol == protocols[0] else f"{protocol}: "
        shown[f"{prefix}{metric}"] = own["value"].to_numpy(dtype=np.float64)
        if side != "nothing":
            shown[f"{prefix}{side} {metric}"] = _beside(own, side)
    styled = shown.style.format(precision=1).map(
        lambda count: f"color: {BAD}; font-weight: 600" if count else "", subset=["failed"]
    )
    for name in shown.columns[3:]:
        lower = name.endswith("_mape")
        what = next((each for each in SIDES if f"{each} " in name), None)
        if what is None:
            styled = styled.map(lambda value, lower=lower: _shade(value if lower else 100 - value), subset=[name])
        elif what == "difference":
            styled = styled.format("{:+.1f}", subset=[name])
            styled = styled.map(lambda value, lower=lower: _sign(value, lower_is_better=lower), subset=[name])
        else:
            styled = styled.map(lambda _: f"color: {GREY}", subset=[name])
    return shown, styled


def _beside(cells: pd.DataFrame, side: str) -> Any:
    """What stands beside a metric's numbers."""
    rows = cells.to_dict("records")
    if side == "interval":
        return [None if pd.isna(row["low"]) else f"{row['low']:.1f}–{row['high']:.1f}" for row in rows]
    if side == "counts":
        return [f"{row['recordings']}" + (f" ({row['failures']})" if row["failures"] else "") for row in rows]
    return cells[side].to_numpy(dtype=np.float64)


def _left_out(cells: pd.DataFrame) -> str:
    """How many recordings the protocols leave out, per metric."""
    counts: dict[Protocol, list[str]] = {}
    for row in cells[cells["container_id"].isna() & (cells["left_out"] > 0)].to_dict("records"):
        counts.setdefault(row["protocol"], []).append(f"{METRIC_NAMES[row['metric']]} {row['left_out']}")
    texts = "; ".join(f"{TITLES[protocol]}: {', '.join(own)}" for protocol, own in counts.items())
    return f"Recordings left out, because a network was trained on them or may have been: {texts}." if texts else ""


def _columns(shown: pd.DataFrame) -> dict[str, Any]:
    """Headings and widths: all of Table 2 on one screen."""
    columns: dict[str, Any] = {
        "container": st.column_config.TextColumn("Container", pinned=True, width=112),
        "n": st.column_config.Column("n", width=36, help="Recordings"),
        "failed": st.column_config.Column("Failed", width=48, help="Recordings without an estimate of their own"),
    }
    for name in set(shown.columns) - set(columns):
        group, _, rest = name.rpartition(": ")
        side, _, metric = rest.rpartition(" ")
        arrow = "↓" if metric.endswith("_mape") else "↑"
        label, width, helped = f"{SHORT.get(metric, METRIC_NAMES[metric])} {arrow}", 66, METRIC_NAMES[metric]
        if side:
            beside, label, width = SIDES[side]
            helped = f"{helped}: {beside}"
        if group:
            label, width, helped = f"{label} {group}", width + 60, f"{helped} ({group})"
        columns[name] = st.column_config.Column(label, width=width, help=helped)
    return columns


def rows_section(judged: Judged) -> None:
    """Every recording of the run with its errors, to be filtered and sorted."""
    run, errors = judged.run, judged.errors()
    left, right = st.columns([3, 1], vertical_alignment="bottom")
    names = sorted(errors["container"].unique())
    session.keep_among("rows", names)
    state = st.session_state
    state["rows_container"] = [name for name in session.choice().rows if name in names]
    state["rows_failed"] = session.choice().only_failed
    containers = left.multiselect("Container", names, key="rows_container", on_change=_filtered)
    only_failed = right.toggle("Failed only", key="rows_failed", on_change=_filtered)
    rows = errors[errors["container"].isin(containers)] if containers else errors
    rows = rows[rows["failed"]] if only_failed else rows
    st.caption(
        f"{len(rows)} of {len(errors)} recordings; errors in %. Click a heading to sort, a number to open the "
        "recording on the page of its stage."
    )
    shown = rows[["container", "status"]].copy()
    for metric, column in METRICS.items():
        correct = f"{column}_correct"
        shown[METRIC_NAMES[metric]] = rows[correct] if correct in rows else rows[column].round(1)
    shown = shown.assign(frame=rows["best_frame"], notes=rows["notes"]).rename_axis("recording")
    key = f"rows {run.name} {containers} {only_failed}"
    clicked_row(shown, run=run, metric="capacity_mape", key=key, height=min(560, 38 + 35 * max(1, len(rows))))
    downloads(rows.reset_index(), name=f"{run.name}_errors")
    submission(judged)


def _filtered() -> None:
    session.choose(rows=tuple(st.session_state["rows_container"]), only_failed=st.session_state["rows_failed"])


def _metric_of(column: str) -> str:
    """The metric that a column of the shown table belongs to."""
    name = "failures" if column == "failed" else column.rpartition(" ")[2]
    return name if name in (*METRICS, "failures") else "capacity_mape"


def _shade(shortfall: float) -> str:
    if not np.isfinite(shortfall):
        return f"color: {GREY}"
    return f"background-color: rgba(213,94,0,{0.75 * min(max(shortfall, 0) / WORST_PERCENT, 1):.2f})"


def _sign(value: float, *, lower_is_better: bool) -> str:
    if not np.isfinite(value) or round(value, 1) == 0:
        return f"color: {GREY}"
    return f"color: {GOOD if (value < 0) == lower_is_better else BAD}"
