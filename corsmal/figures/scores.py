"""The score of every frame of a pair of views, with its parts."""

import plotly.graph_objects as go

from corsmal.figures.style import BEST, PENALTY, TOTAL, TRUTH, VIEW_COLOURS, plain_layout
from corsmal.selection import BestFrame


def score_figure(best: BestFrame, *, frame: int | None = None) -> go.Figure:
    """Scores by frame: the pair's score, the mask pixels of each view and the penalties that are taken off.

    Args:
        best: the selection of one pair.
        frame: the frame that is being looked at, marked by a line.

    Returns:
        A figure whose points' ``x`` is the frame index; frames without a container in both views leave a gap.
    """
    scores = best.scores
    frames = [score.frame for score in scores]
    figure = go.Figure(layout=plain_layout(hovermode="x unified"))
    for side, view in enumerate(best.pair):
        figure.add_scatter(
            x=frames,
            y=[score.mask_pixels[side] for score in scores],
            name=f"N, {view}",
            mode="lines+markers",
            line={"color": VIEW_COLOURS[view], "width": 1.5},
            marker={"size": 4},
            hovertemplate="%{y:,} px",
        )
    figure.add_scatter(
        x=frames,
        y=[-2 * sum(score.penalties) if score.total is not None else None for score in scores],
        name="penalties, twice both views' TP",
        mode="lines",
        fill="tozeroy",
        line={"color": PENALTY, "width": 1},
        hovertemplate="%{y:,} px",
    )
    figure.add_scatter(
        x=frames,
        y=[score.total for score in scores],
        name="score of the pair",
        mode="lines+markers",
        line={"color": TOTAL, "width": 3},
        marker={"size": 6},
        hovertemplate="%{y:,} px",
    )
    if best.score is not None:
        figure.add_scatter(
            x=[best.frame],
            y=[best.score.total],
            name=f"best frame: {best.frame}",
            mode="markers",
            marker={"color": BEST, "size": 16, "symbol": "star"},
            hoverinfo="skip",
        )
    if frame is not None:
        figure.add_vline(x=frame, line={"color": TRUTH, "width": 2, "dash": "dot"})
    figure.update_xaxes(title="frame", rangemode="tozero")
    figure.update_yaxes(title="pixels", zeroline=True)
    return figure
