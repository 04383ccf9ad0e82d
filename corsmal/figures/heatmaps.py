"""Heat maps: who is taken for whom, errors over a grid of settings, and what goes away with a stage's errors."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from corsmal.dataset.annotation import Kind
from corsmal.figures.style import AXIS, Part, axis, heatmap, note, plain_layout, scatter, side_by_side

SHADE = [[0.0, "rgba(91,141,239,0.04)"], [1.0, "rgba(91,141,239,0.95)"]]
WORSE = [[0.0, "#14B8A6"], [0.5, "#F2C14E"], [1.0, "#D55E00"]]
REMOVED = [[0.0, "rgba(229,72,77,0.85)"], [0.5, "rgba(138,143,152,0.10)"], [1.0, "rgba(20,184,166,0.85)"]]
GAPS = {"xgap": 2, "ygap": 2}


def confusion_figure(tables: Mapping[Kind, pd.DataFrame]) -> go.Figure:
    """Confusion matrices of ``corsmal.evaluation.confusion_tables``, by kind of container, side by side (paper Fig. 3).

    Returns:
        A heat map per kind, in order, so that a click's ``curve`` is the number of its kind and its ``y`` and ``x`` are
        the true and the predicted class. Colours are shares of the true class, texts are counts.
    """
    traces, texts = [], []
    layout = plain_layout(margin={"l": 60, "r": 12, "t": 44, "b": 46}, annotations=[])
    places = side_by_side(len(tables), gap=0.06)
    for number, ((kind, table), (start, end)) in enumerate(zip(tables.items(), places, strict=True), start=1):
        ending = "" if number == 1 else str(number)
        across, down, counts = list(table.columns), list(table.index), table.to_numpy()
        totals = counts.sum(axis=1, keepdims=True)
        on = {"xaxis": f"x{ending}", "yaxis": f"y{ending}"}
        cells = heatmap(
            np.divide(100 * counts, totals, out=np.zeros(counts.shape), where=totals > 0),
            colours=SHADE,
            name=kind,
            x=across,
            y=down,
            customdata=counts.tolist(),
            zmin=0,
            zmax=100,
            hovertemplate="true %{y}, predicted %{x}<br>%{customdata} recordings, %{z:.0f} % of the class"
            f"<extra>{kind}</extra>",
        )
        traces.append(cells | GAPS | on)
        plain = {"type": "category", "showgrid": False}
        layout[f"xaxis{ending}"] = axis("predicted", domain=[start, end], anchor=f"y{ending}", **plain)
        layout[f"yaxis{ending}"] = axis(
            "true" if number == 1 else "", autorange="reversed", anchor=f"x{ending}", **plain
        )
        where = {"x": (start + end) / 2, "y": 1.02, "xref": "paper", "yref": "paper", "yanchor": "bottom"}
        layout["annotations"].append(note(f"<b>{kind}</b>, {int(counts.sum())}", **where))
        names = [str(value) if value else "" for value in counts.ravel()]
        texts.append(_texts(across, down, names, **on))
    return go.Figure([*traces, *texts], layout)


def sweep_figure(table: pd.DataFrame, *, metric: str, label: str, current: tuple[float, float]) -> go.Figure:
    """The error over a grid of L and d_max.

    Args:
        table: from ``corsmal.evaluation.sweep_table``: ``circumferences``, ``max_difference_mm``, the metric (%),
            ``recordings`` and ``failures``.
        metric: the column that is drawn.
        label: its name for people.
        current: the present L and d_max, marked by a ring; off the grid it is put where it lies between the cells.

    Returns:
        A heat map whose cells are equally large, whatever the steps between settings; ``customdata`` of a cell is L,
        d_max, failures and recordings. A star marks the smallest error.
    """
    errors, failures, recordings = (
        table.pivot_table(index="max_difference_mm", columns="circumferences", values=name, dropna=False)
        for name in (metric, "failures", "recordings")
    )
    values = errors.to_numpy()
    across, down = errors.columns.to_numpy(dtype=np.float64), errors.index.to_numpy(dtype=np.float64)
    cells = heatmap(
        values,
        colours=WORSE,
        x=np.arange(len(across)),
        y=np.arange(len(down)),
        customdata=np.dstack([*np.meshgrid(across, down), failures, recordings]).tolist(),
        text=[[f"{value:.1f}" if np.isfinite(value) else "–" for value in row] for row in values],
        texttemplate="%{text}",
        hovertemplate="L %{customdata[0]:.0f}, d_max %{customdata[1]:.2f} mm<br>"
        f"{label}: %{{z:.1f}} %<br>failed: %{{customdata[2]}} of %{{customdata[3]}}<extra></extra>",
    )
    bar = {"showscale": True, "colorbar": {"title": {"text": "MAPE (%)"}, "thickness": 12}}
    x, y = (
        np.interp(value, steps, np.arange(len(steps))) for value, steps in zip(current, (across, down), strict=True)
    )
    traces = [cells | GAPS | bar, _mark(float(x), float(y), "circle-open", "current setting", size=34)]
    if np.isfinite(values).any():
        row, column = np.unravel_index(np.nanargmin(values), values.shape)
        traces.append(_mark(float(column) - 0.34, float(row), "star", "smallest error", size=11))
    layout = plain_layout(
        xaxis=axis("L, circumferences", tickvals=np.arange(len(across)), ticktext=[f"{x:g}" for x in across]),
        yaxis=axis("d_max (mm)", tickvals=np.arange(len(down)), ticktext=[f"{y:g}" for y in down]),
    )
    return go.Figure(traces, layout)


def blame_figure(table: pd.DataFrame, *, rows: str, columns: str, value: str, label: str) -> go.Figure:
    """How much of an error goes away with a stage's mistakes, as a heat map.

    From −100 % (the error doubled) to 100 % (nothing is left of it); cells without a number are empty.

    Args:
        table: rows of ``corsmal.evaluation.attribution_table``, or a melted form of it.
        rows: the column that names the rows.
        columns: the column that names the columns.
        value: the column with the part of the error that is gone, %.
        label: what is drawn, for people.
    """
    down, across = (list(dict.fromkeys(table[name])) for name in (rows, columns))
    parts = table.pivot_table(index=rows, columns=columns, values=value, dropna=False)
    values = parts.reindex(index=down, columns=across).to_numpy()
    cells = heatmap(
        np.clip(values, -100, 100),
        colours=REMOVED,
        x=across,
        y=down,
        customdata=values.tolist(),
        zmin=-100,
        zmax=100,
        hovertemplate=f"%{{y}}, %{{x}}<br>{label}: %{{customdata:.0f}} %<extra></extra>",
    )
    layout = plain_layout(
        xaxis={"type": "category", "side": "top", "tickangle": 0, "showgrid": False},
        yaxis={"type": "category", "autorange": "reversed", "automargin": True, "showgrid": False},
        margin={"l": 60, "r": 12, "t": 60, "b": 12},
    )
    names = [f"{value:+.0f} %" if np.isfinite(value) else "" for value in values.ravel()]
    return go.Figure([cells | GAPS, _texts(across, down, names)], layout)


def _mark(x: float, y: float, symbol: str, name: str, *, size: int) -> Part:
    marker = {"symbol": symbol, "size": size, "color": AXIS, "line": {"width": 3, "color": AXIS}}
    return scatter([x], [y], mode="markers", name=name, marker=marker, hoverinfo="skip")


def _texts(across: Sequence[str], down: Sequence[str], names: Sequence[str], **axes: str) -> Part:
    """What is written on the cells, row by row, in the colour of the theme's text: shades let its ground through."""
    x, y = [column for _ in down for column in across], [row for row in down for _ in across]
    return scatter(x, y, mode="text", text=list(names), showlegend=False, hoverinfo="skip", **axes)
