"""All metrics of a run by container, as small multiples."""

from collections.abc import Mapping
from itertools import product

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from corsmal.figures.panels import TITLE
from corsmal.figures.style import BEST, Part, note, plain_layout, scatter, side_by_side

ACROSS = 4
"""Panels in a row."""

ROW_PX, HEAD_PX = 21, 62
GAP = 0.045
WIDEST_PERCENT = 100.0
"""Errors beyond this are drawn at the edge."""


def multiples_figure(cells: pd.DataFrame, *, labels: Mapping[str, str], colour: str) -> go.Figure:
    """A panel per metric: each container's number with its interval, and the paper's.

    Args:
        cells: from ``corsmal.evaluation.cell_table``, of one protocol; containers in its order, ``Average`` last.
        labels: the metrics that are drawn, in order, as people read them.
        colour: of the run.

    Returns:
        Panels in rows of four with one scale for all errors; ``customdata`` of a point is its metric and container.
        A number that is not there has no point.
    """
    names = list(dict.fromkeys(cells["container"]))
    down = -(-len(labels) // ACROSS)
    height_px = multiples_height_px(len(names), panels=len(labels))
    head, foot = 34 / height_px, 46 / height_px  # above and below the points of a row, titles included
    each = 1 / down
    layout = plain_layout(
        margin={"l": 60, "r": 12, "t": 30, "b": 8}, annotations=[], hovermode="closest", showlegend=True
    )
    top = _highest(cells, [metric for metric in labels if metric.endswith("_mape")])
    ticks = {"tickvals": [*range(len(names))], "ticktext": [_bold(name, names) for name in names[::-1]]}
    traces: list[Part] = []
    places = product(range(down), side_by_side(ACROSS, gap=GAP))
    for number, ((metric, label), (row, (start, end))) in enumerate(zip(labels.items(), places, strict=False), start=1):
        ending = "" if number == 1 else str(number)
        is_error = metric.endswith("_mape")
        low, high = 1 - (row + 1) * each + foot, 1 - row * each - head
        own = cells[cells["metric"] == metric].set_index("container").reindex(names)
        on = {"xaxis": f"x{ending}", "yaxis": f"y{ending}"}
        traces += _points(own, metric, label, colour, limit=top if is_error else 100.0, is_first=number == 1, on=on)
        layout[f"xaxis{ending}"] = {
            "title": {**TITLE, "text": "MAPE (%)" if is_error else "MPF1 (%)"},
            "domain": [start, end],
            "anchor": f"y{ending}",
            "range": [-0.03 * top, 1.04 * top] if is_error else [-3, 104],
            "tickvals": [0, 50, 100] if not is_error or top > 50 else None,
            "tickfont": {"size": 11},
            "zeroline": False,
            "fixedrange": True,
        }
        layout[f"yaxis{ending}"] = {
            **ticks,
            "domain": [low, high],
            "anchor": f"x{ending}",
            "range": [-0.6, len(names) - 0.4],
            "automargin": True,
            "showticklabels": number % ACROSS == 1,
            "zeroline": False,
            "fixedrange": True,
        }
        where = {"x": start, "y": high, "xref": "paper", "yref": "paper", "xanchor": "left", "yanchor": "bottom"}
        layout["annotations"].append(note(f"<b>{label}</b> {'↓' if is_error else '↑'}", font={"size": 12}, **where))
    return go.Figure(traces, layout)


def multiples_height_px(containers: int, *, panels: int) -> int:
    """How high ``multiples_figure`` is to be for a number of rows, the average included."""
    return 38 + -(-panels // ACROSS) * (80 + ROW_PX * containers)


def _points(
    own: pd.DataFrame, metric: str, label: str, colour: str, *, limit: float, is_first: bool, on: Part
) -> list[Part]:
    """The run's points with their intervals, and the paper's."""
    heights = np.arange(len(own))[::-1]
    values, low, high, paper = (own[name].to_numpy(dtype=np.float64) for name in ("value", "low", "high", "published"))
    custom = [[metric, str(name)] for name in own.index]
    texts = [
        f"{name}, {label}: {value:.1f} %" + ("" if np.isnan(start) else f"<br>95 % interval {start:.1f}–{end:.1f}")
        for name, value, start, end in zip(own.index, values, low, high, strict=True)
    ]
    shown = np.minimum(values, limit)
    bars = {
        "type": "data",
        "symmetric": False,
        "array": np.nan_to_num(np.minimum(high, limit) - shown),
        "arrayminus": np.nan_to_num(shown - low),
        "thickness": 1.5,
        "width": 0,
        "color": colour,
    }
    diamond = {"symbol": "diamond", "size": 9, "color": BEST, "line": {"color": "#FFFFFF", "width": 1}}
    look = {"mode": "markers", "customdata": custom, "showlegend": is_first, "cliponaxis": False, **on}
    return [
        scatter(
            np.minimum(paper, limit),
            heights,
            name="paper (real recordings)",
            marker=diamond,
            hovertemplate="paper: %{x:.1f} %<extra></extra>",
            **look,
        ),
        scatter(
            shown,
            heights,
            name="this run, 95 % interval",
            marker={"size": 9, "color": colour},
            error_x=bars,
            text=texts,
            hovertemplate="%{text}<extra></extra>",
            **look,
        ),
    ]


def _highest(cells: pd.DataFrame, metrics: list[str]) -> float:
    """The end of the scale of errors."""
    known = cells.loc[cells["metric"].isin(metrics), ["value", "published"]].to_numpy(dtype=np.float64)
    highest = float(np.nanmax(known)) if np.isfinite(known).any() else 100.0
    return min(WIDEST_PERCENT, max(10.0, 1.05 * highest))


def _bold(name: str, names: list[str]) -> str:
    return f"<b>{name}</b>" if name == names[-1] else name
