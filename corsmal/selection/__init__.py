"""Penalties, View Scores and the best frame of a pair of views (paper 3.1, equations 3 to 5)."""

from corsmal.parameters import Pair
from corsmal.selection.best import FrameDetections, best_frame_of_view, score_frames, select_best_frame, view_score
from corsmal.selection.penalties import total_penalty, union_penalty
from corsmal.selection.records import BestFrame, FrameScore
from corsmal.selection.verdicts import Verdict, frame_verdicts

__all__ = [
    "BestFrame",
    "FrameDetections",
    "FrameScore",
    "Pair",
    "Verdict",
    "best_frame_of_view",
    "frame_verdicts",
    "score_frames",
    "select_best_frame",
    "total_penalty",
    "union_penalty",
    "view_score",
]
