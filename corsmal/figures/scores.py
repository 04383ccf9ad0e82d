"""The score of every frame of a pair of views, with its parts."""

import pandas as pd
import plotly.express as px
import plotly.graph_objects as go

from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.style import BEST, PENALTY, TOTAL, TRUTH, VIEW_COLOURS, Part, axis, plain_layout
from corsmal.selection import BestFrame, FrameScore


@Drawing
def score_figure(best: BestFrame, *, frame: int | None = None) -> Drawn:
    """Scores by frame: the pair's score, the mask pixels of each view and the penalties that are taken off.

    Args:
        best: the selection of one pair.
        frame: the chosen frame, marked by a line.

    Returns:
        A figure whose points' ``x`` is the frame index; frames without a container in both views leave a gap.
    """
    scores = best.scores
    frames = [score.frame for score in scores]
    traces = [
        _line(
            frames,
            [score.mask_pixels[side] for score in scores],
            name=f"N, {view}",
            line={"color": VIEW_COLOURS[view], "width": 1.5},
            marker={"size": 4},
        )
        for side, view in enumerate(best.pair)
    ]
    penalties = [-2 * sum(score.penalties) if score.total is not None else None for score in scores]
    traces += [
        _line(
            frames,
            penalties,
            name="penalties, twice both views' TP",
            line={"color": PENALTY, "width": 1},
            mode="lines",
            fill="tozeroy",
        ),
        _line(
            frames,
            [score.total for score in scores],
            name="score of the pair",
            line={"color": TOTAL, "width": 3},
            marker={"size": 6},
        ),
    ]
    if best.score is not None:
        traces.append(_star(best.score))
    layout = plain_layout(
        hovermode="x unified",
        xaxis=axis("frame", rangemode="tozero"),
        yaxis=axis("pixels", zeroline=True),
    )
    if frame is not None:
        layout["shapes"] = [_cursor(frame)]
    return traces, layout


def score_error_figure(table: pd.DataFrame) -> go.Figure:
    """Is the best frame a good one: the error of the fit in a frame against the frame's View Score.

    Args:
        table: a row per frame with columns ``container``, ``recording``, ``frame``, ``score`` (pixels) and
            ``error_pct`` (mean of the four quantities' absolute errors).

    Returns:
        One point per frame, coloured by container.
    """
    figure = px.scatter(
        table,
        x="score",
        y="error_pct",
        color="container",
        hover_data=["recording", "frame"],
        opacity=0.55,
        labels={"score": "score of the pair (pixels)", "error_pct": "mean error of the four quantities (%)"},
    )
    return figure.update_layout(plain_layout(legend={"title": {"text": ""}}))


def _line(frames: list[int], pixels: list[int | None], **changes: object) -> Part:
    look = {"mode": "lines+markers", "hovertemplate": "%{y:,} px"}
    return {"type": "scatter", "x": frames, "y": pixels, **look, **changes}


def _cursor(frame: int) -> Part:
    ends = {"x0": frame, "x1": frame, "yref": "y domain", "y0": 0, "y1": 1}
    return {"type": "line", **ends, "line": {"color": TRUTH, "width": 2, "dash": "dot"}}


def _star(score: FrameScore) -> Part:
    return {
        "type": "scatter",
        "x": [score.frame],
        "y": [score.total],
        "name": f"best frame: {score.frame}",
        "mode": "markers",
        "marker": {"color": BEST, "size": 16, "symbol": "star"},
        "hoverinfo": "skip",
    }
