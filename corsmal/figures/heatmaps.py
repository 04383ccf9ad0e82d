"""Heat maps: who is taken for whom, errors over a grid of settings, and what goes away with a stage's errors."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from corsmal.dataset.annotation import Kind
from corsmal.figures.style import AXIS, Part, axis, heatmap, note, plain_layout, scatter, side_by_side

SHADE = [[0.0, "rgba(91,141,239,0.04)"], [1.0, "rgba(91,141,239,0.95)"]]
BETTER_WORSE = [
    *([0.0, "rgba(20,184,166,0.9)"], [0.495, "rgba(20,184,166,0.35)"], [0.4951, "rgba(138,143,152,0.10)"]),
    *([0.5049, "rgba(138,143,152,0.10)"], [0.505, "rgba(213,94,0,0.35)"], [1.0, "rgba(213,94,0,0.9)"]),
]
"""The smallest difference that is one stands out, too."""

FULL_POINTS = 20.0
"""The difference, in percentage points, from which on the colour is full."""

GONE = [[0.0, "rgba(138,143,152,0.10)"], [1.0, "rgba(20,184,166,0.85)"]]
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


def sweep_figure(
    table: pd.DataFrame,
    *,
    metric: str,
    axes: tuple[str, str],
    labels: tuple[str, str, str],
    current: tuple[float, float],
) -> go.Figure:
    """The error over a grid of two parameters, coloured where it differs from the reference by more than noise.

    Args:
        table: from ``corsmal.evaluation.sweep_table``: the two parameters, the metric (%) with its ``_difference``,
            ``_low`` and ``_high``, ``recordings`` and ``failures``.
        metric: the column that is drawn.
        axes: the columns of the parameters, across and down.
        labels: what people read for the two parameters and for the metric.
        current: the present values, marked by a ring; off the grid it is put where it lies between the cells.

    Returns:
        A heat map whose cells are equally large, whatever the steps between settings; ``customdata`` of a cell is the
        two values, failures, recordings and the interval of the difference. A cell has a colour if that excludes 0. A
        star marks the smallest error, if its difference is one.
    """
    names = (metric, "failures", "recordings", *(f"{metric}_{part}" for part in ("difference", "low", "high")))
    errors, failures, recordings, differences, low, high = (
        table.pivot_table(index=axes[1], columns=axes[0], values=name, dropna=False) for name in names
    )
    values, is_clear = errors.to_numpy(), ((low > 0) | (high < 0)).to_numpy()
    shown = np.where(is_clear, differences.to_numpy(), 0.0)
    across, down = errors.columns.to_numpy(dtype=np.float64), errors.index.to_numpy(dtype=np.float64)
    ticks = [[f"{value:g}" for value in steps] for steps in (across, down)]
    largest = min(FULL_POINTS, max(1.0, float(np.nanmax(np.abs(shown), initial=0.0))))
    known = np.isfinite(values)
    cells = heatmap(
        np.where(known, shown, np.nan),
        colours=BETTER_WORSE,
        x=np.arange(len(across)),
        y=np.arange(len(down)),
        zmin=-largest,
        zmax=largest,
        customdata=np.dstack([*np.meshgrid(across, down), failures, recordings, low, high, values]).tolist(),
        hovertemplate=f"{labels[0]} %{{customdata[0]:g}}, {labels[1]} %{{customdata[1]:g}}<br>"
        f"{labels[2]}: %{{customdata[6]:.1f}} %<br>to the run's setting: %{{customdata[4]:+.1f}} to "
        "%{customdata[5]:+.1f} points<br>failed: %{customdata[2]} of %{customdata[3]}<extra></extra>",
    )
    bar = {"showscale": True, "colorbar": {"title": {"text": "points"}, "thickness": 12}}
    places = [(x, y) for y in range(len(down)) for x in range(len(across))]
    texts = [f"{values[y, x]:.1f}" if known[y, x] else "–" for x, y in places]
    x, y = (
        np.interp(value, steps, np.arange(len(steps))) for value, steps in zip(current, (across, down), strict=True)
    )
    traces = [
        cells | GAPS | bar,
        scatter(*zip(*places, strict=True), mode="text", text=texts, showlegend=False, hoverinfo="skip"),
        _mark(float(x), float(y), "circle-open", "the run's setting", size=34),
    ]
    if (is_clear & known).any():
        row, column = np.unravel_index(np.nanargmin(np.where(is_clear & (shown < 0), values, np.inf)), values.shape)
        if shown[row, column] < 0:
            traces.append(_mark(float(column) - 0.34, float(row), "star", "smallest error", size=11))
    layout = plain_layout(
        xaxis=axis(labels[0], tickvals=np.arange(len(across)), ticktext=ticks[0], zeroline=False, showgrid=False),
        yaxis=axis(labels[1], tickvals=np.arange(len(down)), ticktext=ticks[1], zeroline=False, showgrid=False),
    )
    return go.Figure(traces, layout)


def share_figure(table: pd.DataFrame, *, rows: str, columns: str) -> go.Figure:
    """How much of an error goes away with a stage's mistakes, as a heat map of shares from 0 to 100 %.

    Args:
        table: rows of ``corsmal.evaluation.attribution_table`` with the columns ``text``, what is written on a cell,
            and ``told``, what is said where the mouse rests.
        rows: the column that names the rows.
        columns: the column that names the columns.
    """
    down, across = (list(dict.fromkeys(table[name])) for name in (rows, columns))
    shares, texts, told = (
        table.set_index([rows, columns])[value].unstack().reindex(index=down, columns=across).to_numpy()  # noqa: PD010
        for value in ("share", "text", "told")
    )
    texts, told = (np.where(pd.isna(each), "", each) for each in (texts, told))
    cells = heatmap(
        np.nan_to_num(shares.astype(np.float64)),
        colours=GONE,
        x=across,
        y=down,
        customdata=told.tolist(),
        zmin=0,
        zmax=100,
        hovertemplate="%{y}, %{x}<br>%{customdata}<extra></extra>",
    )
    layout = plain_layout(
        xaxis={"type": "category", "side": "top", "tickangle": 0, "showgrid": False},
        yaxis={"type": "category", "autorange": "reversed", "automargin": True, "showgrid": False},
        margin={"l": 60, "r": 12, "t": 60, "b": 12},
    )
    return go.Figure([cells | GAPS, _texts(across, down, list(texts.ravel()))], layout)


def _mark(x: float, y: float, symbol: str, name: str, *, size: int) -> Part:
    marker = {"symbol": symbol, "size": size, "color": AXIS, "line": {"width": 3, "color": AXIS}}
    return scatter([x], [y], mode="markers", name=name, marker=marker, hoverinfo="skip")


def _texts(across: Sequence[str], down: Sequence[str], names: Sequence[str], **axes: str) -> Part:
    """What is written on the cells, row by row, in the colour of the theme's text: shades let its ground through."""
    x, y = [column for _ in down for column in across], [row for row in down for _ in across]
    return scatter(x, y, mode="text", text=list(names), showlegend=False, hoverinfo="skip", **axes)
