"""Published figures to compare with: the paper's Table 2, and the challenge's leaderboard."""

import re
from pathlib import Path
from typing import Literal, get_args

import pandas as pd

from corsmal.errors import ArgumentError, check_choice
from corsmal.evaluation.challenge import SCORES, overall_score

LeaderboardSplit = Literal["public", "private", "combined"]
LEADERBOARD_SPLITS: tuple[LeaderboardSplit, ...] = get_args(LeaderboardSplit)

THIS_PAPER = "KEIO-ICS"
"""The team of the paper on the leaderboard."""

SCORE_NAMES = {score: re.sub("_(ml|mm|g)$", "", name) for score, name in SCORES.items()}
"""The leaderboard's columns, by score: those of estimates without their units."""


def paper_table_2() -> pd.DataFrame:
    """The paper's Table 2, in %: the columns of ``container_table`` without the counts, its last row ``Average``."""
    return _read("paper_table2").astype({"container_id": "Int64"})


def leaderboard(split: LeaderboardSplit) -> pd.DataFrame:
    """The challenge's leaderboard on one of its sets.

    Args:
        split: ``public``, ``private`` or both ``combined``.

    Returns:
        A row per team, scores in %: ``team``, the columns of ``SCORE_NAMES``, ``object_safety`` and
        ``delivery_accuracy`` (the simulator's), ``overall`` as published, and ``overall_without_simulator``, which is
        what ``challenge_scores`` calls overall: the one to compare with.

    Raises:
        ArgumentError: the split is unknown.
    """
    check_choice("split", split, LEADERBOARD_SPLITS)
    table = _read("challenge_leaderboard")
    table = table[table["split"] == split].drop(columns="split").reset_index(drop=True)
    scores = {score: table[name] for score, name in SCORE_NAMES.items()}
    simulator = ["object_safety", "delivery_accuracy"]
    order = ["team", *SCORE_NAMES.values(), *simulator, "overall"]
    return table[order].assign(overall_without_simulator=overall_score(scores))


def leaderboard_row(scores: pd.Series, *, name: str) -> pd.DataFrame:
    """Scores from ``challenge_scores`` as one row of a leaderboard, ``name`` as its team, without the simulator's."""
    row = {"team": name} | {column: scores[score] for score, column in SCORE_NAMES.items()}
    row["overall_without_simulator"] = scores["overall"]
    columns = leaderboard("combined").columns
    return pd.DataFrame([row], columns=columns).astype(dict.fromkeys(columns.drop("team"), "float64"))


def leaderboard_with(scores: pd.Series, *, split: LeaderboardSplit, name: str) -> pd.DataFrame:
    """The leaderboard of a set with one more row, ``name``, sorted by ``overall_without_simulator``, the best first.

    The scores, from ``challenge_scores``, must be of the same set, with every recording counted.

    Raises:
        ArgumentError: the split is unknown, or the scores are of other recordings than the leaderboard's.
    """
    table = leaderboard(split)
    if scores.attrs.get("split") != split or not scores.attrs.get("is_whole"):
        own = f"{scores.attrs.get('split')}, {'all' if scores.attrs.get('is_whole') else 'not all'} recordings"
        raise ArgumentError(f"scores must be of all recordings of the {split} set to stand among its teams, got {own}")
    table = pd.concat([table, leaderboard_row(scores, name=name)], ignore_index=True)
    return table.sort_values("overall_without_simulator", ascending=False, ignore_index=True)


def _read(name: str) -> pd.DataFrame:
    return pd.read_csv(Path(__file__).with_name(f"{name}.csv"))
