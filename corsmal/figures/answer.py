"""The answer of one head of the filling network: probabilities and logits."""

from typing import Literal

from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.style import LEVEL_COLOURS, TRUTH, TYPE_COLOURS, Part, plain_layout
from corsmal.filling import FillingPrediction

Head = Literal["type", "level"]

HEAD_COLOURS: dict[Head, dict[str, str]] = {"type": TYPE_COLOURS, "level": LEVEL_COLOURS}
RANGE_PCT, NUMBERS_PCT = [0, 180], 104
"""Beyond 100 % the numbers are written."""

ROW_PX = 24


@Drawing
def answer_figure(
    prediction: FillingPrediction, *, head: Head, whole: FillingPrediction | None = None, true: str | None = None
) -> Drawn:
    """A bar per class with its probability, and its logit in brackets.

    Args:
        prediction: of what is heard; it did not fail.
        head: which of its two answers.
        whole: of the whole recording, drawn as a mark on each bar.
        true: the annotated class, where it is known; marked by a diamond.

    Returns:
        Probabilities in percent, classes from above in their order; the figure's height is set.
    """
    colours = HEAD_COLOURS[head]
    names = [f"<b>◆ {name}</b>" if name == true else name for name in colours]
    traces = [_bars(prediction, head), _numbers(prediction, head)]
    if whole is not None:
        traces.append(_marks(whole, head))
    layout = plain_layout(
        height=ROW_PX * len(names) + 6,
        margin={"l": 70, "r": 4, "t": 2, "b": 4},
        showlegend=False,
        bargap=0.25,
        xaxis={"range": RANGE_PCT, "visible": False, "fixedrange": True},
        yaxis={
            "range": [len(names) - 0.5, -0.5],
            "tickvals": list(range(len(names))),
            "ticktext": names,
            "ticklabelstandoff": 4,
            "showgrid": False,
            "zeroline": False,
            "fixedrange": True,
        },
    )
    return traces, layout


def _bars(prediction: FillingPrediction, head: Head) -> Part:
    return {
        "type": "bar",
        "orientation": "h",
        "x": 100 * getattr(prediction, f"{head}_probabilities"),
        "y": list(range(len(HEAD_COLOURS[head]))),
        "marker": {"color": list(HEAD_COLOURS[head].values())},
        "hoverinfo": "skip",
        "name": head,
    }


def _numbers(prediction: FillingPrediction, head: Head) -> Part:
    shares, logits = (getattr(prediction, f"{head}_{kind}").tolist() for kind in ("probabilities", "logits"))
    return {
        "type": "scatter",
        "mode": "text",
        "x": [NUMBERS_PCT] * len(shares),
        "y": list(range(len(shares))),
        "text": [f"{100 * share:.0f} % ({logit:+.1f})" for share, logit in zip(shares, logits, strict=True)],
        "textposition": "middle right",
        "hoverinfo": "skip",
        "name": "numbers",
    }


def _marks(whole: FillingPrediction, head: Head) -> Part:
    percent = 100 * getattr(whole, f"{head}_probabilities")
    return {
        "type": "scatter",
        "mode": "markers",
        "x": percent,
        "y": list(range(len(percent))),
        "marker": {"symbol": "line-ns-open", "size": 18, "color": TRUTH, "line": {"width": 2}},
        "name": "whole recording",
        "hovertemplate": "whole recording: %{x:.0f} %<extra></extra>",
    }
