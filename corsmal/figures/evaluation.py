"""Figures of an evaluation: how errors spread over containers, and how two runs differ."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from corsmal.figures.style import (
    BEST,
    INSIDE,
    OUTSIDE,
    TRUTH,
    Part,
    axis,
    bars,
    note,
    plain_layout,
    scatter,
    side_by_side,
)
from corsmal.quantities import QUANTITIES

VERDICT_COLOURS = {"better": INSIDE, "worse": OUTSIDE, "no significant difference": TRUTH}
POINT_JITTER = 0.32
"""How far points are moved apart, of the distance between two rows."""

BOX_MIN = 5
"""Of fewer recordings a box says nothing that the points do not."""


def spread_figure(
    table: pd.DataFrame, points: pd.DataFrame | None, *, metric: str, unit: str, colour: str, seed: int = 0
) -> go.Figure:
    """One metric by container: how bad each is, and how its recordings' errors spread.

    Args:
        table: a row per container, from the worst to the best: ``container``, ``value`` (%), ``paper`` (%, NaN where
            the paper has no such container) and ``recordings``.
        points: a row per recording with ``container``, ``error`` (with its sign, %) and ``failed``, indexed by
            recording id; None where the metric has no errors of single recordings.
        metric: its name for people.
        unit: of ``error``, for people.
        colour: of the run.
        seed: of the points' places across their row.

    Returns:
        Trace 0 holds a bar per container, whose ``customdata`` is the container's name; the points' ``customdata`` are
        recording ids.
    """
    names = list(table["container"])
    rows = {name: len(names) - 1 - place for place, name in enumerate(names)}
    heights = [rows[name] for name in names]
    traces = [
        bars(
            table["value"].to_numpy(),
            heights,
            name="this run",
            customdata=names,
            text=[f"{value:.1f}" if np.isfinite(value) else "no number" for value in table["value"]],
            textposition="auto",
            marker={"color": colour},
            hovertemplate="%{customdata}: %{x:.1f} %<extra></extra>",
        )
    ]
    if table["paper"].notna().any():
        diamond = {"symbol": "diamond", "size": 11, "color": BEST, "line": {"color": "#FFFFFF", "width": 1}}
        look = {"marker": diamond, "hovertemplate": "paper: %{x:.1f} %<extra></extra>"}
        traces.append(
            scatter(table["paper"].to_numpy(), heights, mode="markers", name="paper, real recordings", **look)
        )
    ticks = {"tickvals": heights, "ticktext": names, "range": [-0.6, len(names) - 0.4], "zeroline": False}
    layout = plain_layout(
        barmode="overlay",
        xaxis=axis(f"{metric} (%)", rangemode="tozero", domain=[0, 0.42] if points is not None else [0, 1]),
        yaxis={"automargin": True, **ticks},
        hovermode="closest",
    )
    if points is not None:
        traces += _strips(points, rows, unit=unit, colour=colour, seed=seed)
        layout["xaxis2"] = axis(f"error of each recording ({unit})", domain=[0.47, 1], anchor="y2", zeroline=True)
        layout["yaxis2"] = {**ticks, "anchor": "x2", "showticklabels": False}
    return go.Figure(traces, layout)


def errors_figure(errors: pd.DataFrame, *, colour: str, seed: int = 0) -> go.Figure:
    """How the errors of every number spread, a panel each: a box per container and a point per recording.

    Args:
        errors: from ``corsmal.evaluation.error_table``, with an error at least.
        colour: of the run.
        seed: of the points' places across their row.

    Returns:
        The points' ``customdata`` are recording ids.
    """
    known = [each for each in QUANTITIES if not each.is_class and errors[each.error_column].notna().any()]
    names = sorted(errors["container"].unique(), reverse=True)
    rows = {name: place for place, name in enumerate(names)}
    ticks = {"tickvals": list(rows.values()), "ticktext": names, "range": [-0.6, len(names) - 0.4], "zeroline": False}
    layout = plain_layout(margin={"l": 60, "r": 12, "t": 56, "b": 46}, annotations=[], hovermode="closest")
    traces: list[Part] = []
    places = side_by_side(len(known), gap=0.025)
    for number, (quantity, (start, end)) in enumerate(zip(known, places, strict=True), start=1):
        ending = "" if number == 1 else str(number)
        points = errors[["container", "failed"]].assign(error=errors[quantity.error_column])
        strips = _strips(points, rows, unit="%", colour=colour, seed=seed, ending=ending)
        traces += strips if number == 1 else [strip | {"showlegend": False} for strip in strips]
        layout[f"xaxis{ending}"] = axis("error (%)", domain=[start, end], anchor=f"y{ending}", zerolinewidth=2)
        own = {"automargin": True} if number == 1 else {"showticklabels": False}
        layout[f"yaxis{ending}"] = {**ticks, "anchor": f"x{ending}", **own}
        where = {"x": (start + end) / 2, "y": 1, "xref": "paper", "yref": "paper", "yanchor": "bottom"}
        layout["annotations"].append(note(f"<b>{quantity.label}</b>", **where))
    layout["legend"] |= {"y": 1, "yref": "container", "yanchor": "top"}
    return go.Figure(traces, layout)


def _strips(
    points: pd.DataFrame, rows: Mapping[str, int], *, unit: str, colour: str, seed: int, ending: str = "2"
) -> list[Part]:
    """A box per container over its recordings, and a point per recording, on the axes whose names end so."""
    known = points[points["error"].notna() & points["container"].isin(rows)]
    errors, places = known["error"].to_numpy(), known["container"].map(rows).to_numpy(dtype=np.float64)
    is_many = (known.groupby("container")["error"].transform("size") >= BOX_MIN).to_numpy()
    jitter = np.random.default_rng(seed).uniform(-POINT_JITTER, POINT_JITTER, len(known)) * is_many
    on = {"xaxis": f"x{ending}", "yaxis": f"y{ending}"}
    box: Part = {
        "type": "box",
        "orientation": "h",
        "x": errors[is_many],
        "y": places[is_many],
        "boxpoints": False,
        "showlegend": False,
        "hoverinfo": "skip",
        "line": {"color": TRUTH, "width": 1},
        "fillcolor": "rgba(138,143,152,0.12)",
        **on,
    }
    traces = [box]
    for failed, name, own_colour in ((False, "measured", colour), (True, "failed: training mean", OUTSIDE)):
        own = (known["failed"] == failed).to_numpy()
        look = {
            "name": name,
            "marker": {"size": 7, "color": own_colour, "opacity": 0.75},
            "showlegend": bool(own.any()),
        }
        shown = f"%{{customdata}}: %{{x:+.1f}} {unit}<extra></extra>"
        ids = list(known.index[own])
        traces.append(
            scatter(
                errors[own], (places + jitter)[own], mode="markers", customdata=ids, hovertemplate=shown, **look, **on
            )
        )
    return traces


def comparison_figure(rows: pd.DataFrame, *, label: str) -> go.Figure:
    """Differences of two runs with their intervals, a point per row from above, whose ``customdata`` is its label.

    Args:
        rows: ``label``'s column, ``difference``, ``low``, ``high`` (percentage points; the ends NaN without a spread)
            and ``verdict``.
        label: the column that names the rows.
    """
    names = [str(name) for name in rows[label]]
    places = np.arange(len(names))[::-1]
    traces = []
    for verdict, colour in VERDICT_COLOURS.items():
        own = (rows["verdict"] == verdict).to_numpy()
        middle, low, high = (rows.loc[own, name].to_numpy() for name in ("difference", "low", "high"))
        traces.append(
            scatter(
                middle,
                places[own],
                mode="markers",
                name=f"second run {verdict}" if verdict in ("better", "worse") else verdict,
                customdata=[name for name, is_own in zip(names, own, strict=True) if is_own],
                error_x={
                    "type": "data",
                    "symmetric": False,
                    "array": high - middle,
                    "arrayminus": middle - low,
                    "thickness": 2,
                    "color": colour,
                },
                marker={"size": 11, "color": colour},
                showlegend=bool(own.any()),
                hovertemplate="%{customdata}: %{x:+.1f} points<extra></extra>",
            )
        )
    ticks = {"tickvals": places, "ticktext": names, "range": [-0.7, len(names) - 0.3], "zeroline": False}
    return go.Figure(
        traces,
        plain_layout(
            xaxis=axis("second run − first run (percentage points)", zeroline=True, zerolinewidth=2),
            yaxis={"automargin": True, **ticks},
            hovermode="closest",
        ),
    )
