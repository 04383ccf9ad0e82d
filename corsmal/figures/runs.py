"""Several runs in one figure, by container."""

import html
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from corsmal.figures.style import BEST, Part, axis, plain_layout, run_colour, scatter

SYMBOLS = ("circle", "square", "triangle-up", "cross", "star", "hexagon")
"""Tell runs of the same preset apart, which have the same colour."""

SPREAD = 0.5
"""How far the runs of a container are moved apart, of the distance between two rows."""

ROW_PX = 18


@dataclass(frozen=True, eq=False)
class RunNumbers:
    """What is drawn of a run.

    Args:
        name: of the run.
        preset: of its parameters, which gives the colour.
        cells: from ``corsmal.evaluation.cell_table``, of one protocol.
    """

    name: str
    preset: str
    cells: pd.DataFrame


def runs_figure(runs: Sequence[RunNumbers], *, metric: str, label: str) -> go.Figure:
    """One metric of several runs, container by container.

    Args:
        runs: in the order in which they are listed.
        metric: a column of Table 2.
        label: of the metric, with its unit, for people.

    Returns:
        A row per container, the average last; a point with its 95 % interval per run, whose ``customdata`` is the
        container, and the paper's diamond, at the edge where it is far beyond the runs.
    """
    parts = [run.cells[run.cells["metric"] == metric].set_index("container") for run in runs]
    names = list(dict.fromkeys(name for part in parts for name in part.index[:-1]))
    names += [str(parts[0].index[-1])]
    rows = {name: len(names) - 1 - place for place, name in enumerate(names)}
    published = pd.concat([part["published"] for part in parts]).groupby(level=0).first().reindex(names)
    values = np.concatenate([part["value"].to_numpy(dtype=np.float64) for part in parts])
    limit = max(100.0, 1.05 * float(np.nanmax(values))) if np.isfinite(values).any() else 100.0
    diamond = {"symbol": "diamond", "size": 10, "color": BEST, "line": {"color": "#FFFFFF", "width": 1}}
    heights = np.array([rows[name] for name in names], dtype=np.float64)
    traces = [
        scatter(
            np.minimum(published.to_numpy(dtype=np.float64), limit),
            heights,
            mode="markers",
            name="paper (real recordings)",
            marker=diamond,
            customdata=[float(value) for value in published],
            hovertemplate="paper: %{customdata:.1f} %<extra></extra>",
        )
    ]
    offsets = np.linspace(SPREAD / 2, -SPREAD / 2, len(runs)) if len(runs) > 1 else np.zeros(1)
    for number, (run, part, offset) in enumerate(zip(runs, parts, offsets, strict=True)):
        before = sum(other.preset == run.preset for other in runs[:number])
        places = heights + offset
        traces.append(_points(run, part.reindex(names), places, SYMBOLS[before % len(SYMBOLS)]))
    texts = [f"<b>{name}</b>" if name == names[-1] else name for name in names]
    ticks = {"tickvals": heights, "ticktext": texts, "range": [-0.7, len(names) - 0.3], "zeroline": False}
    return go.Figure(
        traces,
        plain_layout(
            xaxis=axis(label, range=[-2, 1.04 * limit]), yaxis={"automargin": True, **ticks}, hovermode="closest"
        ),
    )


def runs_height_px(containers: int, *, runs: int) -> int:
    """How high ``runs_figure`` is to be."""
    return 120 + containers * max(24, ROW_PX * runs)


def _points(run: RunNumbers, part: pd.DataFrame, places: np.ndarray, symbol: str) -> Part:
    values, low, high = (part[name].to_numpy(dtype=np.float64) for name in ("value", "low", "high"))
    colour = run_colour(run.preset)
    bars = {
        "type": "data",
        "symmetric": False,
        "array": np.nan_to_num(high - values),
        "arrayminus": np.nan_to_num(values - low),
        "thickness": 1.5,
        "width": 0,
        "color": colour,
    }
    return scatter(
        values,
        places,
        mode="markers",
        name=html.escape(run.name),
        customdata=[str(name) for name in part.index],
        marker={"size": 9, "color": colour, "symbol": symbol},
        error_x=bars,
        hovertemplate="%{customdata}: %{x:.1f} %",
    )
