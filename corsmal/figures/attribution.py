"""Errors before and after a stage is replaced by the truth."""

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from corsmal.figures.style import INSIDE, OUTSIDE, TRUTH, Part, axis, note, plain_layout, scatter, side_by_side

FADED = 0.35
"""Opacity of a change that may be chance."""


def stage_figure(table: pd.DataFrame, *, after: str = "with the truth") -> go.Figure:
    """A panel per stage: every error as it is, and with that stage replaced by the truth.

    Args:
        table: a row per stage and metric: ``stage`` and ``label`` as people read them, ``before`` and ``after`` (in %,
            the lower the better), ``is_clear`` (whether the change is more than chance) and ``told``, what is said
            where the mouse rests.
        after: what the points are, for the legend.

    Returns:
        Panels side by side with one scale. A grey ring is the error as it is, a point that with the truth: green where
        it is clearly smaller, red where it is clearly larger, faded where that may be chance.
    """
    stages, labels = (list(dict.fromkeys(table[name])) for name in ("stage", "label"))
    places = {label: len(labels) - 1 - number for number, label in enumerate(labels)}
    highest = max(1.0, float(np.nanmax(table[["before", "after"]].to_numpy(), initial=0.0)))
    layout = plain_layout(margin={"l": 60, "r": 12, "t": 54, "b": 46}, annotations=[], hovermode="closest")
    traces: list[Part] = []
    for number, (stage, (start, end)) in enumerate(
        zip(stages, side_by_side(len(stages), gap=0.03), strict=True), start=1
    ):
        ending = "" if number == 1 else str(number)
        on = {"xaxis": f"x{ending}", "yaxis": f"y{ending}"}
        traces += _panel(table[table["stage"] == stage], places, on, is_first=number == 1, after=after)
        layout[f"xaxis{ending}"] = axis(
            "error (%)", domain=[start, end], anchor=f"y{ending}", range=[-0.03 * highest, 1.06 * highest]
        )
        ticks = {"tickvals": list(places.values()), "ticktext": labels, "range": [-0.6, len(labels) - 0.4]}
        layout[f"yaxis{ending}"] = {
            **ticks,
            "anchor": f"x{ending}",
            "automargin": True,
            "showticklabels": number == 1,
            "zeroline": False,
        }
        where = {"x": start, "y": 1.0, "xref": "paper", "yref": "paper", "xanchor": "left", "yanchor": "bottom"}
        layout["annotations"].append(note(f"<b>{stage}</b>", **where))
    layout["legend"] = {**layout["legend"], "y": 1.09}
    return go.Figure(traces, layout)


def _panel(rows: pd.DataFrame, places: dict[str, int], on: Part, *, is_first: bool, after: str) -> list[Part]:
    heights = rows["label"].map(places).to_numpy(dtype=np.float64)
    old, new = (rows[name].to_numpy(dtype=np.float64) for name in ("before", "after"))
    gaps = np.full(len(rows), np.nan)
    is_clear = rows["is_clear"].to_numpy(dtype=bool)
    colours = np.where(~is_clear, TRUTH, np.where(new < old, INSIDE, OUTSIDE))
    lines = {"line": {"color": TRUTH, "width": 2}, "showlegend": False, "hoverinfo": "skip"}
    ring = {"size": 10, "color": TRUTH, "symbol": "circle-open", "line": {"width": 2}}
    point = {"size": 11, "color": colours.tolist(), "opacity": np.where(is_clear, 1.0, FADED + 0.3).tolist()}
    look = {"customdata": list(rows["told"]), "hovertemplate": "%{customdata}<extra></extra>"}
    x, y = (np.column_stack(each).ravel() for each in ([old, new, gaps], [heights, heights, gaps]))
    return [
        scatter(x, y, mode="lines", **lines, **on),
        scatter(old, heights, mode="markers", name="as it is", marker=ring, showlegend=is_first, **look, **on),
        scatter(
            new,
            heights,
            mode="markers",
            name=f"{after} (faded: no clear change)",
            marker=point,
            showlegend=is_first,
            **look,
            **on,
        ),
    ]
