"""The radii profile: what was fitted, what smoothing rejected, and where the ends are."""

import numpy as np

from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.style import BESIDE, BEST, DROPPED, HULL, TRUTH, Part, axis, note, plain_layout, scatter
from corsmal.shape import Dimensions, Hull


@Drawing
def profile_figure(
    hull: Hull,
    dimensions: Dimensions,
    *,
    truth_mm: tuple[float, float, float] | None = None,
    beside: tuple[str, Hull] | None = None,
) -> Drawn:
    """Radius against height, to equal scales, as one would see the container from the side.

    Args:
        hull: the fitted hull.
        dimensions: marks what smoothing kept and the two ends.
        truth_mm: annotated bottom width, top width and height, drawn as a frustum that starts at the lower end.
        beside: name and hull of another fit, drawn over it.
    """
    traces = _radii(hull, dimensions)
    ends = {"i_b, lower end": dimensions.bottom, "i_t, upper end": dimensions.top}
    marks = {
        f"{name}: {2 * hull.radii_mm[index]:.1f} mm wide": float(hull.heights_mm[index])
        for name, index in ends.items()
        if index is not None
    }
    if truth_mm is not None and dimensions.bottom is not None:
        traces.append(_annotated(*truth_mm, base_mm=float(hull.heights_mm[dimensions.bottom])))
    if beside is not None and beside[1].ok:
        traces.append(_beside(*beside))
    radii_mm = hull.radii_mm if beside is None else np.concatenate([hull.radii_mm, beside[1].radii_mm])
    widest_mm = max(float(radii_mm.max(initial=1.0)), *(width / 2 for width in (truth_mm or (0.0, 0.0))[:2]))
    right = {"xref": "x domain", "x": 1, "xanchor": "right", "yanchor": "bottom"}
    layout = plain_layout(
        shapes=[_across(height_mm) for height_mm in marks.values()],
        annotations=[note(text, font={"color": BEST}, y=height_mm, **right) for text, height_mm in marks.items()],
        xaxis=axis("radius (mm)", range=[0, 1.1 * widest_mm], constraintoward="left"),
        yaxis=axis("height z above the table (mm)", scaleanchor="x"),
    )
    return traces, layout


def _radii(hull: Hull, dimensions: Dimensions) -> list[Part]:
    kept = np.isin(np.arange(len(hull.converged)), dimensions.kept)
    groups = (
        ("kept", hull.converged & kept, {"color": HULL, "size": 6}, "lines+markers"),
        ("rejected by d_max", hull.converged & ~kept, {"color": DROPPED, "size": 8, "symbol": "x"}, "markers"),
        ("unfitted", ~hull.converged, {"color": TRUTH, "size": 4, "symbol": "circle-open"}, "markers"),
    )
    look = {"line": {"color": HULL, "width": 1}, "hovertemplate": "radius %{x:.1f} mm<br>z %{y:.1f} mm"}
    return [
        scatter(hull.radii_mm[chosen], hull.heights_mm[chosen], mode=mode, name=name, marker=marker, **look)
        for name, chosen, marker, mode in groups
        if chosen.any()
    ]


def _beside(name: str, hull: Hull) -> Part:
    shown = f"{name}: radius %{{x:.1f}} mm<br>z %{{y:.1f}} mm"
    radii_mm, heights_mm = hull.radii_mm[hull.converged], hull.heights_mm[hull.converged]
    line = {"color": BESIDE, "width": 3}
    return scatter(radii_mm, heights_mm, mode="lines", name=name, line=line, hovertemplate=shown)


def _annotated(bottom_mm: float, top_mm: float, height_mm: float, *, base_mm: float) -> Part:
    radii_mm, heights_mm = [0, bottom_mm / 2, top_mm / 2, 0], [base_mm] * 2 + [base_mm + height_mm] * 2
    line = {"color": TRUTH, "width": 2, "dash": "dash"}
    look = {"name": "annotated size, from the lower end up", "hovertemplate": "annotated: radius %{x:.1f} mm"}
    return scatter(radii_mm, heights_mm, mode="lines", line=line, **look)


def _across(height_mm: float) -> Part:
    ends = {"xref": "x domain", "x0": 0, "x1": 1, "y0": height_mm, "y1": height_mm}
    return {"type": "line", **ends, "line": {"color": BEST, "width": 2}}
