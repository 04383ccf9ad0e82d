"""The numbers that a figure shows, as a table."""

import base64
import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from corsmal.figures.paper import as_figure
from corsmal.figures.style import Part

_ENDS = {"error_x": ("x_low", "x_high"), "error_y": ("y_low", "y_high")}


def figure_data(figure: go.Figure | Part) -> pd.DataFrame:
    """What a figure draws, point by point.

    Args:
        figure: the figure, or the parts of a ``Drawing``.

    Returns:
        A row per point, cell or vertex: ``trace``, the trace's name; its place, in columns named after the axes, or
        ``x`` and ``y`` with the axes' names before them where panels differ; for points in space ``x (mm)``,
        ``y (mm)`` and ``z (mm)``; ``value`` of a cell or vertex with a colour; ``low`` and ``high`` of an interval;
        ``label``, what stands for the point in the figure. Columns that hold nothing are left out; gaps in lines too.
        Pictures have no rows.
    """
    drawn = go.Figure(unpacked(as_figure(figure).to_dict()))
    parts = [part for number, trace in enumerate(drawn.data) for part in _rows(trace, drawn.layout, number)]
    if not parts:
        return pd.DataFrame({"trace": []})
    table = pd.concat(parts, ignore_index=True)
    places = [name for name in ("x", "y") if name in table]
    table = table[table[[*places, *(name for name in table if str(name).endswith(" (mm)"))]].notna().any(axis=1)]
    for name in places:
        titles = set(table[f"{name} axis"].dropna()) - {""}
        if len(titles) == 1:
            table = table.drop(columns=f"{name} axis").rename(columns={name: titles.pop()})
    return table.replace("", None).dropna(axis="columns", how="all").infer_objects().reset_index(drop=True)


def unpacked(value: Any) -> Any:
    """Plotly's JSON with its packed arrays as arrays, which whoever reads the figure expects."""
    if isinstance(value, dict) and "bdata" in value:
        array = np.frombuffer(base64.b64decode(value["bdata"]), dtype=value["dtype"])
        return array.reshape([int(size) for size in str(value["shape"]).split(",")]) if "shape" in value else array
    if isinstance(value, dict):
        return {name: unpacked(part) for name, part in value.items()}
    return [unpacked(part) for part in value] if isinstance(value, list) else value


def _rows(trace: Any, layout: Any, number: int) -> Iterator[pd.DataFrame]:
    name = trace.name or f"trace {number + 1}"
    if trace.type in ("mesh3d", "scatter3d"):
        space = {f"{axis} (mm)": np.asarray(trace[axis], dtype=np.float64) for axis in "xyz"}
        value = trace.intensity if trace.type == "mesh3d" else None
        yield pd.DataFrame({"trace": name, **space} | ({} if value is None else {"value": value}))
    elif trace.type in ("heatmap", "scatter", "scattergl", "bar", "box"):
        yield _flat(trace, layout, name)


def _flat(trace: Any, layout: Any, name: str) -> pd.DataFrame:
    axes = {axis: layout[f"{axis}axis{(trace[f'{axis}axis'] or axis)[1:]}"] for axis in "xy"}
    points = _cells(trace) if trace.type == "heatmap" else _points(trace)
    columns: dict[str, Any] = {"trace": name}
    for axis, found in axes.items():
        columns[f"{axis} axis"] = found.title.text or ""
        columns[axis] = _named(points.pop(axis), found)
    return pd.DataFrame(columns | points)


def _cells(trace: Any) -> dict[str, Any]:
    """A heat map's cells, row by row."""
    values = np.asarray(trace.z)
    rows, columns = values.shape
    across = np.arange(columns) if trace.x is None else np.asarray(trace.x)
    down = np.arange(rows) if trace.y is None else np.asarray(trace.y)
    return {"x": np.tile(across, rows), "y": np.repeat(down, columns), "value": values.ravel()}


def _points(trace: Any) -> dict[str, Any]:
    given = {axis: [] if trace[axis] is None else list(trace[axis]) for axis in "xy"}
    count = max(map(len, given.values()))
    points: dict[str, Any] = {axis: values or [None] * count for axis, values in given.items()}
    for name, ends in _ENDS.items():
        error = _of(trace, name)
        if error is not None and error.array is not None:
            middle, above = np.asarray(points[name[-1]], dtype=np.float64), np.asarray(error.array)
            below = above if error.arrayminus is None else np.asarray(error.arrayminus)
            points |= dict(zip(ends, (middle - below, middle + above), strict=True))
    for source in ("customdata", "text"):
        labels = _of(trace, source)
        if isinstance(labels, list | tuple | np.ndarray) and len(labels) == count and np.ndim(labels) == 1:
            points["label"] = [_plain(label) for label in labels]
            break
    return points


def _of(trace: Any, name: str) -> Any:
    """A part of a trace; None where its kind of trace has none."""
    return trace[name] if name in trace else None  # noqa: SIM401 - a trace is no dict


def _named(values: Any, axis: Mapping[str, Any]) -> list[Any]:
    """Places on an axis; those that have a name by their names."""
    if axis["tickvals"] is None or axis["ticktext"] is None:
        return list(values)
    names = dict(zip(axis["tickvals"], map(_plain, axis["ticktext"]), strict=False))
    return [names.get(value, value) for value in values]


def _plain(label: Any) -> Any:
    """A number as it is, a text without the tags that Plotly reads."""
    return (
        label
        if isinstance(label, int | float | np.number)
        else re.sub(r"</?(b|i|br|sub|sup|span)\b[^>]*>", "", str(label))
    )
