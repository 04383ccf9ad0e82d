"""The score of every frame of a pair of views, with its parts."""

from collections.abc import Sequence

import pandas as pd
import plotly.graph_objects as go

from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.style import BEST, PENALTY, TOTAL, VIEW_COLOURS, Part, axis, plain_layout, scatter
from corsmal.selection import BestFrame


@Drawing
def score_figure(best: BestFrame) -> Drawn:
    """Scores by frame: the pair's score, the mask pixels of each view and the penalties that are taken off.

    Frames that do not count, such as those without a container in both views, leave a gap. A point's ``x`` is the
    frame index.
    """
    scores = best.scores
    penalties = [-score.total_penalty if score.total is not None else None for score in scores]
    is_shared = all(score.is_shared for score in scores)
    lines: list[tuple[str, Sequence[float | None], Part]] = [
        (
            f"N, {view}",
            [score.mask_pixels[side] for score in scores],
            {"line": {"color": VIEW_COLOURS[view], "width": 1.5}, "marker": {"size": 4}},
        )
        for side, view in enumerate(best.pair)
    ]
    under = {"line": {"color": PENALTY, "width": 1}, "mode": "lines", "fill": "tozeroy"}
    lines.append(("penalties, twice both views' TP" if is_shared else "penalties of both views", penalties, under))
    totals = [score.total for score in scores]
    lines.append(("score of the pair", totals, {"line": {"color": TOTAL, "width": 3}, "marker": {"size": 6}}))
    frames = [score.frame for score in scores]
    traces = [
        scatter(frames, pixels, mode="lines+markers", hovertemplate="%{y:,.0f} px", name=name) | look
        for name, pixels, look in lines
    ]
    if best.score is not None:
        star = {"color": BEST, "size": 16, "symbol": "star"}
        name = f"best frame: {best.score.frame}"
        x, y = [best.score.frame], [best.score.total]
        traces.append(scatter(x, y, mode="markers", name=name, marker=star, hoverinfo="skip"))
    layout = plain_layout(
        hovermode="x unified",
        xaxis=axis("frame", rangemode="tozero"),
        yaxis=axis("pixels", zeroline=True),
    )
    return traces, layout


def score_error_figure(table: pd.DataFrame) -> go.Figure:
    """Is the best frame a good one: the error of the fit in a frame against the frame's View Score.

    Args:
        table: from ``corsmal.runs.view_scores.score_errors``; a point per frame, coloured by container.
    """
    import plotly.express as px  # noqa: PLC0415 - takes long to import, and no page draws this

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
