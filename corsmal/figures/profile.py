"""The radii profile: what was fitted, what was smoothed away, and where the ends are."""

import numpy as np
import plotly.graph_objects as go

from corsmal.figures.style import BEST, DROPPED, HULL, TRUTH, plain_layout
from corsmal.shape import Dimensions, Hull


def profile_figure(
    hull: Hull, dimensions: Dimensions, *, truth_mm: tuple[float, float, float] | None = None
) -> go.Figure:
    """Radius against height, as one would see the container from the side.

    Args:
        hull: the fitted hull.
        dimensions: marks what smoothing kept and the two ends.
        truth_mm: annotated bottom width, top width and height, drawn as a frustum that starts at the lower end.

    Returns:
        A figure with equal scales on both axes.
    """
    figure = go.Figure(layout=plain_layout())
    kept = np.zeros(len(hull.converged), dtype=bool)
    kept[dimensions.kept] = True
    groups = (
        ("kept", hull.converged & kept, {"color": HULL, "size": 6}, "lines+markers"),
        ("smoothed away", hull.converged & ~kept, {"color": DROPPED, "size": 8, "symbol": "x"}, "markers"),
        ("fits no view", ~hull.converged, {"color": TRUTH, "size": 4, "symbol": "circle-open"}, "markers"),
    )
    for name, chosen, marker, mode in groups:
        if chosen.any():
            figure.add_scatter(
                x=hull.radii_mm[chosen],
                y=hull.heights_mm[chosen],
                name=name,
                mode=mode,
                marker=marker,
                line={"color": HULL, "width": 1},
                hovertemplate="radius %{x:.1f} mm<br>z %{y:.1f} mm",
            )
    for name, index in (("i_b, lower end", dimensions.bottom), ("i_t, upper end", dimensions.top)):
        if index is not None:
            figure.add_hline(
                y=float(hull.heights_mm[index]),
                line={"color": BEST, "width": 2},
                annotation={"text": f"{name}: {2 * hull.radii_mm[index]:.1f} mm wide", "font": {"color": BEST}},
                annotation_position="top right",
            )
    if truth_mm is not None and dimensions.bottom is not None:
        bottom, top, height = truth_mm
        base = float(hull.heights_mm[dimensions.bottom])
        figure.add_scatter(
            x=[0, bottom / 2, top / 2, 0],
            y=[base, base, base + height, base + height],
            name="annotated size, from the lower end up",
            mode="lines",
            line={"color": TRUTH, "width": 2, "dash": "dash"},
            hovertemplate="annotated: radius %{x:.1f} mm",
        )
    figure.update_xaxes(title="radius (mm)", range=[0, 1.1 * float(hull.radii_mm.max(initial=1.0))])
    figure.update_yaxes(title="height z above the table (mm)", scaleanchor="x")
    return figure
