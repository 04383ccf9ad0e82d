"""Whether a run's probabilities mean what they say, and what is wrong among its surest answers."""

import pandas as pd

from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.style import BEST, TRUTH, Part, axis, plain_layout, scatter, side_by_side

MARKER_MIN_PX, MARKER_ADDED_PX = 7, 20
"""Markers of bins: of one that holds next to nothing, and how much larger one is that holds all."""


@Drawing
def calibration_figure(reliability: pd.DataFrame, curve: pd.DataFrame, *, threshold: float, colour: str) -> Drawn:
    """Two panels: how often answers are right by their probability, and the risk by the share that is answered.

    Args:
        reliability: from ``corsmal.evaluation.reliability_table``.
        curve: from ``corsmal.evaluation.risk_coverage_table``.
        threshold: probability below which nothing is answered, 0..1; marked on the curve.
        colour: of the run.
    """
    (start, end), (start_right, end_right) = side_by_side(2, gap=0.12)
    percent = {"range": [0, 105], "zeroline": False}
    layout = plain_layout(
        xaxis=axis("probability of the answer (%)", domain=[start, end], **percent),
        yaxis=axis("right (%)", **percent),
        xaxis2=axis("answered, the surest first (%)", domain=[start_right, end_right], anchor="y2", **percent),
        yaxis2=axis("wrong among these (%)", anchor="x2", rangemode="tozero", zeroline=False),
        hovermode="closest",
    )
    return [*_reliability(reliability, colour), *_curve(curve, threshold, colour)], layout


def _reliability(table: pd.DataFrame, colour: str) -> list[Part]:
    share = table["recordings"] / table["recordings"].sum()
    bins = [f"{100 * low:.0f}–{100 * high:.0f} %" for low, high in zip(table["low"], table["high"], strict=True)]
    shown = "probability %{customdata}: %{text} answers, %{y:.0f} % right<extra></extra>"
    calibrated = {"line": {"color": TRUTH, "width": 2, "dash": "dash"}, "hoverinfo": "skip"}
    return [
        scatter([0, 100], [0, 100], mode="lines", name="calibrated", **calibrated),
        scatter(
            (100 * table["confidence"]).tolist(),
            (100 * table["accuracy"]).tolist(),
            mode="lines+markers",
            name="this run, larger where there are more answers",
            line={"color": colour, "width": 2},
            marker={"color": colour, "size": (MARKER_MIN_PX + MARKER_ADDED_PX * share**0.5).tolist()},
            text=table["recordings"].astype(str).tolist(),
            customdata=bins,
            hovertemplate=shown,
        ),
    ]


def _curve(curve: pd.DataFrame, threshold: float, colour: str) -> list[Part]:
    right = {"xaxis": "x2", "yaxis": "y2"}
    shown = "from %{customdata:.0f} % on: %{x:.0f} % answered, %{y:.1f} % of these wrong<extra></extra>"
    percent = 100 * curve[["coverage", "risk", "threshold"]]
    points = {"customdata": percent["threshold"].tolist(), "hovertemplate": shown, **right}
    line = {"color": colour, "width": 2, "shape": "hv"}
    traces = [
        scatter(
            percent["coverage"].tolist(),
            percent["risk"].tolist(),
            mode="lines",
            line=line,
            showlegend=False,
            name="",
            **points,
        )
    ]
    answered = percent[curve["threshold"] >= threshold]
    if len(answered):
        last = answered.iloc[-1]
        look = {"marker": {"color": BEST, "size": 12, "symbol": "diamond"}, "hoverinfo": "skip", **right}
        traces.append(scatter([last["coverage"]], [last["risk"]], mode="markers", name="the threshold", **look))
    return traces
