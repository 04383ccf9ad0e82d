"""What a predicted mass depends on."""

from collections.abc import Mapping

import numpy as np

from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.style import CONTAINER, INPUT_COLOURS, TRUTH, Part, axis, plain_layout, scatter
from corsmal.geometry import Floats


@Drawing
def sensitivity_figure(
    changes: Floats, masses_g: Mapping[str, Floats], *, values: Mapping[str, float], true_g: float | None = None
) -> Drawn:
    """The mass as one of the network's numbers changes and the others stay.

    Args:
        changes: (n,) relative changes, 0 among them; 0.1 stands for 10 % more.
        masses_g: (n,) grams by number: a line each, against the change in %.
        values: what each number is without a change.
        true_g: the true mass, a dashed line.
    """
    percent = 100 * np.asarray(changes)
    traces = [
        _line(percent, name, np.asarray(masses), values[name], colour)
        for (name, masses), colour in zip(masses_g.items(), INPUT_COLOURS, strict=False)
    ]
    layout = plain_layout(
        xaxis=axis("change of one input, the others fixed (%)", range=[percent.min(), percent.max()]),
        yaxis=axis("container mass (g)", rangemode="tozero"),
    )
    if masses_g:
        mass_g = float(next(iter(masses_g.values()))[np.abs(percent).argmin()])
        point = {"color": CONTAINER, "size": 13, "line": {"color": "#FFFFFF", "width": 2}}
        shown = "now: %{y:.1f} g<extra></extra>"
        traces.append(scatter([0.0], [mass_g], mode="markers", name="now", marker=point, hovertemplate=shown))
    if true_g is not None:
        ends, line = [percent.min(), percent.max()], {"color": TRUTH, "width": 2, "dash": "dash"}
        name = f"true mass: {true_g:g} g"
        traces.append(scatter(ends, [true_g, true_g], mode="lines", name=name, line=line, hoverinfo="name"))
    return traces, layout


def _line(percent: Floats, name: str, masses_g: Floats, value: float, colour: str) -> Part:
    return scatter(
        percent,
        masses_g,
        mode="lines",
        customdata=value * (1 + percent / 100),
        name=f"{name} (+10 %: {np.interp(10, percent, masses_g) - np.interp(0, percent, masses_g):+.1f} g)",
        line={"color": colour, "width": 3},
        hovertemplate=f"{name}: %{{customdata:.1f}}<br>%{{y:.1f}} g<extra></extra>",
    )
