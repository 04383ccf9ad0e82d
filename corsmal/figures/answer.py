"""The answer of one head of the filling network: probabilities and logits."""

from collections.abc import Mapping
from typing import Literal

from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.style import LEVEL_COLOURS, SIGHT, SOUND, TRUTH, TYPE_COLOURS, Part, bars, plain_layout, scatter
from corsmal.filling import FillingPrediction

Head = Literal["type", "level"]

HEAD_COLOURS: dict[Head, dict[str, str]] = {"type": TYPE_COLOURS, "level": LEVEL_COLOURS}
RANGE_PCT, NUMBERS_PCT = [0, 246], 110
"""Beyond 100 % the numbers are written."""

ROW_PX = 24

MARKS: dict[str, Part] = {
    "whole recording": {"symbol": "line-ns-open", "size": 18, "color": TRUTH, "line": {"width": 2}},
    "sound": {"symbol": "circle", "size": 10, "color": SOUND, "line": {"color": "#FFFFFF", "width": 1.5}},
    "sight": {"symbol": "square", "size": 10, "color": SIGHT, "line": {"color": "#FFFFFF", "width": 1.5}},
}
"""Of what stands beside an answer."""


@Drawing
def answer_figure(
    prediction: FillingPrediction,
    *,
    head: Head,
    beside: Mapping[str, FillingPrediction] | None = None,
    true: str | None = None,
) -> Drawn:
    """A bar per class with its probability in percent, and its logit in brackets; classes from above in their order.

    Args:
        prediction: of what is heard; it did not fail.
        head: which of its two answers.
        beside: other predictions by a key of ``MARKS``, drawn as marks on each bar.
        true: the annotated class, where it is known; marked by a diamond.
    """
    colours = HEAD_COLOURS[head]
    rows = list(range(len(colours)))
    shares, logits = (getattr(prediction, f"{head}_{kind}") for kind in ("probabilities", "logits"))
    texts = [f"{100 * share:.0f} % ({logit:+.1f})" for share, logit in zip(shares, logits, strict=True)]
    silent = {"hoverinfo": "skip"}
    traces = [
        bars(100 * shares, rows, marker={"color": list(colours.values())}, name=head, **silent),
        scatter(
            [NUMBERS_PCT] * len(rows),
            rows,
            mode="text",
            text=texts,
            textposition="middle right",
            name="numbers",
            **silent,
        ),
    ]
    for name, other in (beside or {}).items():
        percent = 100 * getattr(other, f"{head}_probabilities")
        shown = f"{name}: %{{x:.0f}} %<extra></extra>"
        traces.append(scatter(percent, rows, mode="markers", marker=MARKS[name], name=name, hovertemplate=shown))
    ticks = {"tickvals": rows, "ticktext": [f"<b>◆ {name}</b>" if name == true else name for name in colours]}
    layout = plain_layout(
        height=ROW_PX * len(rows) + 6,
        margin={"l": 70, "r": 4, "t": 2, "b": 4},
        showlegend=False,
        bargap=0.25,
        xaxis={"range": RANGE_PCT, "visible": False, "fixedrange": True},
        yaxis={
            "range": [len(rows) - 0.5, -0.5],
            "ticklabelstandoff": 4,
            "showgrid": False,
            "zeroline": False,
            "fixedrange": True,
            **ticks,
        },
    )
    return traces, layout
