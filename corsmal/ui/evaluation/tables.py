"""The tables of the Evaluation page: Table 2, the leaderboard, every recording; and their downloads."""

from typing import Any

import numpy as np
import pandas as pd
import streamlit as st
from pandas.io.formats.style import Styler

from corsmal.dataset import Dataset
from corsmal.evaluation import (
    METRICS,
    beside_paper,
    leaderboard_with,
    paper_table_2,
)
from corsmal.evaluation.challenge import SPLITS, Split
from corsmal.evaluation.exporting import heading
from corsmal.evaluation.published import LEADERBOARD_SPLITS, THIS_PAPER, LeaderboardSplit
from corsmal.evaluation.tables import AVERAGE
from corsmal.runs.run import Run
from corsmal.ui.evaluation import cached as evaluation
from corsmal.ui.evaluation.cached import METRIC_NAMES
from corsmal.ui.evaluation.downloads import downloads, notes, submission
from corsmal.ui.evaluation.links import clicked_row, focus_container, recordings_list

SECTION = "table"
GOOD, BAD, GREY = "#0D9488", "#E5484D", "#8A8F98"
OVERALL = "overall_without_simulator"
WORST_PERCENT = 60.0
"""A shortfall that is shaded to the full."""

SHORT = {"width_top_mape": "Top", "width_bottom_mape": "Bottom"}
UNLIKE = (
    " The paper's numbers are of the real training recordings, not of these: the difference is **not like with like**."
)
SIDES = {"difference": "difference to the paper", "paper": "the paper's number", "nothing": "nothing"}
SPLIT_NAMES = {
    "train": "the training set",
    "public": "the public test set",
    "private": "the private test set",
    "other": "none of the challenge's sets",
}


def container_section(run: Run, dataset: Dataset) -> None:
    """Table 2 beside the paper's; a click on a number lists its recordings."""
    errors, table = evaluation.errors(run, dataset), evaluation.containers(run, dataset)
    left, right = st.columns([5, 4], vertical_alignment="bottom")
    side = left.segmented_control(
        "Beside each number",
        list(SIDES),
        default="difference",
        required=True,
        format_func=SIDES.__getitem__,
        key="table_side",
    )
    with right:
        downloads(table, name=f"{run.name}_table2")
    shown, styled = table_2(table, side=str(side))
    event = st.dataframe(
        styled,
        key=f"table_2 {run.name} {side}",
        on_select="rerun",
        selection_mode="single-cell",
        hide_index=True,
        height=38 + 35 * len(shown),
        column_config=_columns(shown),
        placeholder="–",
    )
    of_paper = "" if evaluation.is_training_set(dataset) else UNLIKE
    st.caption(
        "Level and type: MPF1 in %, the higher the better; the others: MAPE in %, the lower the better. The more "
        f"orange, the worse. Click a number to see what is behind it, a heading to sort.{of_paper}"
    )
    if event.selection.cells:
        row, column = event.selection.cells[0]
        container = str(shown["container"].iloc[row])
        one = None if container == AVERAGE else container
        focus_container(errors, section=SECTION, metric=_metric_of(column), container=one)
    recordings_list(run, dataset, section=SECTION, errors=errors)


def table_2(table: pd.DataFrame, *, side: str) -> tuple[pd.DataFrame, Styler]:
    """Table 2 as the page shows it, and with its colours."""
    paper = paper_table_2().set_index("container_id").reindex(table["container_id"]).reset_index(drop=True)
    beside = {"difference": beside_paper(table), "paper": paper}.get(side)
    shown = pd.DataFrame({"container": table["container"], "n": table["recordings"], "failed": table["failures"]})
    for metric in METRICS:
        shown[metric] = table[metric].astype("float64")
        if beside is not None:
            shown[f"{side} {metric}"] = beside[metric].to_numpy(dtype=np.float64)
    styled = shown.style.format(precision=1).map(
        lambda count: f"color: {BAD}; font-weight: 600" if count else "", subset=["failed"]
    )
    for metric in METRICS:
        lower = metric.endswith("_mape")
        styled = styled.map(lambda value, lower=lower: _shade(value if lower else 100 - value), subset=[metric])
        if side == "difference":
            styled = styled.format("{:+.1f}", subset=[f"{side} {metric}"])
            styled = styled.map(
                lambda value, lower=lower: _sign(value, lower_is_better=lower), subset=[f"{side} {metric}"]
            )
        elif side == "paper":
            styled = styled.map(lambda _: f"color: {GREY}", subset=[f"{side} {metric}"])
    return shown, styled


def _columns(shown: pd.DataFrame) -> dict[str, Any]:
    """Headings and widths: all of Table 2 on one screen."""
    columns: dict[str, Any] = {
        "container": st.column_config.TextColumn("Container", pinned=True, width=112),
        "n": st.column_config.Column("n", width=36, help="Recordings"),
        "failed": st.column_config.Column("Failed", width=48, help="Recordings that lack an estimate, or got the mean"),
    }
    for name in set(shown.columns) - set(columns):
        side, _, metric = name.rpartition(" ")
        if side:
            label = "Δ" if side == "difference" else "paper"
            helped = f"{METRIC_NAMES[metric]}: this run minus the paper, percentage points"
            columns[name] = st.column_config.Column(label, width=54, help=helped if side == "difference" else None)
        else:
            arrow = "↓" if metric.endswith("_mape") else "↑"
            columns[name] = st.column_config.Column(f"{SHORT.get(metric, METRIC_NAMES[metric])} {arrow}", width=66)
    return columns


def leaderboard_section(run: Run, dataset: Dataset) -> None:
    """The challenge's scores of the run among the published ones."""
    left, right = st.columns(2)
    guess: Split = "train" if evaluation.is_training_set(dataset) else "other"
    split: Split = left.selectbox(
        "These recordings are", SPLITS, SPLITS.index(guess), format_func=SPLIT_NAMES.__getitem__, key="score_split"
    )
    board: LeaderboardSplit = right.segmented_control(
        "Leaderboard", LEADERBOARD_SPLITS, default="combined", required=True, key="leaderboard_split"
    )
    if split != board:
        st.warning(
            f"**Not like with like**: this run is on {SPLIT_NAMES[split]}, the other rows are on the challenge's "
            f"{'two test sets' if board == 'combined' else f'{board} test set'}. An orientation, no rank.",
            icon=":material/balance:",
        )
    scores = evaluation.scores(run, dataset, split=split)
    name = f"▶ {run.name} (this run)"
    table = leaderboard_with(scores, split=board, name=name)
    table.insert(1, OVERALL, table.pop(OVERALL))
    looks = {name: "background-color: rgba(20,184,166,0.28); font-weight: 600", THIS_PAPER: "font-weight: 600"}
    styled = table.style.format(precision=1).apply(lambda row: [looks.get(row["team"], "")] * len(row), axis=1)
    st.dataframe(
        styled,
        hide_index=True,
        key=f"leaderboard {run.name} {split} {board}",
        height=38 + 35 * len(table),
        placeholder="–",
        column_config={each: st.column_config.Column(heading(each), width=96) for each in table.columns.drop("team")}
        | {OVERALL: st.column_config.Column("Overall*", width=80), "team": st.column_config.Column(pinned=True)},
    )
    st.caption(
        "Scores in %. *The overall score without what only the simulator gives, which sorts the table. "
        f"{THIS_PAPER} is the paper's team. This run: JFTL {scores['JFTL']:.1f}, CMD {scores['CMD']:.1f}."
    )
    notes(scores.attrs.get("notes", ()))
    downloads(table.assign(team=table["team"].str.removeprefix("▶ ")), name=f"{run.name}_leaderboard")
    submission(run, dataset)


def rows_section(run: Run, dataset: Dataset) -> None:
    """Every recording of the run with its errors, to be filtered and sorted."""
    errors = evaluation.errors(run, dataset)
    left, right = st.columns([3, 1], vertical_alignment="bottom")
    containers = left.multiselect("Container", sorted(errors["container"].unique()), key="rows_container")
    only_failed = right.toggle("Failed alone", key="rows_failed")
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
    submission(run, dataset)


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
