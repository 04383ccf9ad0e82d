"""The answer of the filling network: probabilities and logits of both heads."""

from collections.abc import Mapping
from typing import Any

import plotly.graph_objects as go

from corsmal.figures.style import LEVEL_COLOURS, TRUTH, TYPE_COLOURS, Part, axis, plain_layout
from corsmal.filling import FillingPrediction

HEADS = {"type": TYPE_COLOURS, "level": LEVEL_COLOURS}
DOMAINS = {"type": [0.08, 0.48], "level": [0.6, 1.0]}
RANGE_PCT = [0, 150]
"""Beyond 100 % there is room for the numbers."""


def answer_figure(
    prediction: FillingPrediction,
    *,
    whole: FillingPrediction | None = None,
    truth: Mapping[str, str] | None = None,
) -> go.Figure:
    """A bar per class with its probability and its logit, the two heads side by side.

    Args:
        prediction: of what is heard; it did not fail.
        whole: of the whole recording, drawn as a mark on each bar.
        truth: annotated class by head, ``type`` and ``level``, as far as it is known; marked by a diamond.

    Returns:
        Probabilities in percent, classes from above in their order.
    """
    traces: list[Part] = []
    layout: dict[str, Any] = plain_layout(showlegend=False, margin={"l": 8, "r": 8, "t": 24, "b": 30}, bargap=0.3)
    layout["annotations"] = [
        {
            "text": f"<b>{head.capitalize()}</b>: probability and logit",
            **{"xref": "paper", "x": DOMAINS[head][0], "xanchor": "left", "yref": "paper", "y": 1, "yanchor": "bottom"},
            **{"showarrow": False, "font": {"size": 12}},
        }
        for head in HEADS
    ]
    for head, suffix in zip(HEADS, ("", "2"), strict=True):
        traces.append(_bars(prediction, head, suffix))
        if whole is not None:
            traces.append(_marks(whole, head, suffix))
        true = (truth or {}).get(head)
        names = [f"<b>◆ {name}</b>" if name == true else name for name in HEADS[head]]
        place = {"range": RANGE_PCT, "domain": DOMAINS[head], "anchor": f"y{suffix}", "fixedrange": True}
        layout[f"xaxis{suffix}"] = axis("%", tickvals=[0, 50, 100], title_standoff=0, **place)
        rows = {"tickvals": list(range(len(names))), "ticktext": names, "range": [len(names) - 0.5, -0.5]}
        layout[f"yaxis{suffix}"] = {"anchor": f"x{suffix}", "showgrid": False, "fixedrange": True, **rows}
    return go.Figure(traces, layout)


def _bars(prediction: FillingPrediction, head: str, suffix: str) -> Part:
    percent = 100 * getattr(prediction, f"{head}_probabilities")
    logits = getattr(prediction, f"{head}_logits")
    return {
        "type": "bar",
        "orientation": "h",
        "x": percent,
        "y": list(range(len(percent))),
        "marker": {"color": list(HEADS[head].values())},
        "text": [f"{share:.0f} %  ({logit:+.1f})" for share, logit in zip(percent, logits, strict=True)],
        "textposition": "outside",
        "cliponaxis": False,
        "hoverinfo": "skip",
        "name": head,
        "xaxis": f"x{suffix}",
        "yaxis": f"y{suffix}",
    }


def _marks(whole: FillingPrediction, head: str, suffix: str) -> Part:
    percent = 100 * getattr(whole, f"{head}_probabilities")
    return {
        "type": "scatter",
        "mode": "markers",
        "x": percent,
        "y": list(range(len(percent))),
        "marker": {"symbol": "line-ns-open", "size": 18, "color": TRUTH, "line": {"width": 2}},
        "name": f"{head}, whole recording",
        "hovertemplate": "whole recording: %{x:.0f} %<extra></extra>",
        "xaxis": f"x{suffix}",
        "yaxis": f"y{suffix}",
    }
