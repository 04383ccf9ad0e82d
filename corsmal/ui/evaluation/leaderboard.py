"""The leaderboard of the Evaluation page: the challenge's scores of a run, among the teams or apart from them."""

import numpy as np
import pandas as pd
import streamlit as st

from corsmal.evaluation import SPLITS, leaderboard, leaderboard_row, leaderboard_with
from corsmal.evaluation.exporting import heading
from corsmal.evaluation.published import LEADERBOARD_SPLITS, THIS_PAPER, LeaderboardSplit
from corsmal.evaluation.splits import SPLIT_NAMES, FoundSplit
from corsmal.ui.evaluation.downloads import downloads, notes, submission
from corsmal.ui.evaluation.judged import Judged
from corsmal.ui.one_of import one_of

OVERALL = "overall_without_simulator"
MARK = "▶ "


def leaderboard_section(judged: Judged) -> None:
    """The challenge's scores of the run: among the teams if it is of their recordings, else apart."""
    left, right = st.columns(2)
    with left:
        found = _scored_as(judged)
    own_board: LeaderboardSplit = found.split if found.split in ("public", "private") else "combined"
    boards = {name: name for name in LEADERBOARD_SPLITS}
    with right:
        board = one_of("Leaderboard", boards, key=f"leaderboard_split {found.split}", default=own_board)
    is_zero = st.toggle(
        "Recordings without an estimate count 0 (the challenge's rule)",
        value=found.split == own_board,
        key=f"absent {found.split}",
    )
    scores = judged.scores(found.split, "zero" if is_zero else "skip")
    run, protocol = judged.run, judged.protocol
    name = f"{MARK}{run.name} (this run, {protocol})"
    st.caption(
        f"{found} {scores.attrs['scored']} of {len(judged.dataset)} recordings are scored. "
        f"JFTL {scores['JFTL']:.1f}, CMD {scores['CMD']:.1f}."
    )
    if found.split == board and scores.attrs["is_whole"]:
        table = leaderboard_with(scores, split=board, name=name)
    else:
        own = leaderboard_row(scores, name=name)
        scores_table(own, key=f"own {run.name} {found.split} {protocol} {is_zero}")
        downloads(own.assign(team=run.name, protocol=protocol, scored_as=found.split), name=f"{run.name}_scores")
        st.info(_apart(found, board), icon=":material/balance:")
        table = leaderboard(board).sort_values(OVERALL, ascending=False, ignore_index=True)
    scores_table(table, key=f"leaderboard {run.name} {found.split} {board}")
    st.caption(
        "Scores in %. *The overall score without what only the simulator gives, which sorts the table. "
        f"{THIS_PAPER} is the paper's team."
    )
    notes(scores.attrs["notes"])
    marked = table.assign(protocol=np.where(table["team"] == name, protocol, ""))
    downloads(marked.assign(team=table["team"].str.removeprefix(MARK)), name=f"{run.name}_leaderboard")
    submission(judged)


def _scored_as(judged: Judged) -> FoundSplit:
    """Which of the challenge's sets the run is scored as; the visitor may know better, but not of synthetic ones."""
    found = judged.split
    if judged.dataset[judged.run.rows[0]["recording_id"]].is_synthetic:
        return FoundSplit("other", "its recordings are synthetic")
    chosen = st.selectbox(
        "These recordings are",
        SPLITS,
        SPLITS.index(found.split),
        format_func=SPLIT_NAMES.__getitem__,
        key="score_split",
    )
    return found if chosen == found.split else FoundSplit(chosen, "it was chosen here")


def _apart(found: FoundSplit, board: LeaderboardSplit) -> str:
    teams = "both test sets" if board == "combined" else SPLIT_NAMES[board]
    own = "only a part of it" if found.split == board else SPLIT_NAMES[found.split]
    return (
        f"The teams below were scored on {teams}, this run on {own}: the numbers cannot be ranked against each other."
    )


def scores_table(table: pd.DataFrame, *, key: str, own: str = MARK) -> None:
    """A leaderboard; rows of teams whose names begin with ``own`` stand out."""
    shown = table.copy()
    shown.insert(1, OVERALL, shown.pop(OVERALL))

    def look(row: pd.Series) -> list[str]:
        bold = "font-weight: 600" if row["team"] == THIS_PAPER or row["team"].startswith(own) else ""
        return [f"{bold}; background-color: rgba(20,184,166,0.28)" if row["team"].startswith(own) else bold] * len(row)

    st.dataframe(
        shown.style.format(precision=1).apply(look, axis=1),
        hide_index=True,
        key=key,
        height=38 + 35 * len(shown),
        placeholder="–",
        column_config={each: st.column_config.Column(heading(each), width=96) for each in shown.columns.drop("team")}
        | {OVERALL: st.column_config.Column("Overall*", width=80), "team": st.column_config.Column(pinned=True)},
    )
