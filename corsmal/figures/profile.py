"""The radii profile: what was fitted, what smoothing rejected, and where the ends are."""

import numpy as np

from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.style import BEST, DROPPED, PRESET_COLOURS, TRUTH, Part, axis, note, plain_layout, scatter
from corsmal.shape import Dimensions, Hull, KnownProfile


@Drawing
def profile_figure(
    hull: Hull,
    dimensions: Dimensions,
    *,
    preset: str = "paper",
    known: KnownProfile | None = None,
    beside: tuple[str, Hull] | None = None,
) -> Drawn:
    """Radius against height, to equal scales, as one would see the container from the side.

    Args:
        hull: the fitted hull.
        dimensions: marks what smoothing kept and the two ends.
        preset: whose colour the profile has.
        known: the container's profile as far as it is known, drawn where its base is or else from the lower end up.
        beside: preset and hull of another fit, drawn over it.
    """
    traces = _radii(hull, dimensions, PRESET_COLOURS[preset])
    ends = {"i_b, lower end": dimensions.bottom, "i_t, upper end": dimensions.top}
    marks = {
        f"{name}: {2 * hull.radii_mm[index]:.1f} mm wide": float(hull.heights_mm[index])
        for name, index in ends.items()
        if index is not None
    }
    base_mm = None if known is None else known.base_of(hull, dimensions)
    if known is not None and base_mm is not None:
        traces.append(_known(known, base_mm=base_mm))
    if beside is not None and beside[1].ok:
        traces.append(_beside(*beside))
    shown = [
        hull.radii_mm,
        *([] if beside is None else [beside[1].radii_mm]),
        *([] if known is None else [known.radii_mm]),
    ]
    widest_mm = float(np.concatenate(shown).max(initial=1.0))
    right = {"xref": "x domain", "x": 1, "xanchor": "right", "yanchor": "bottom"}
    layout = plain_layout(
        shapes=[_across(height_mm) for height_mm in marks.values()],
        annotations=[note(text, y=height_mm, **right) for text, height_mm in marks.items()],
        xaxis=axis("radius (mm)", range=[0, 1.1 * widest_mm], constraintoward="left"),
        yaxis=axis("height z above the table (mm)", scaleanchor="x"),
    )
    return traces, layout


def _radii(hull: Hull, dimensions: Dimensions, colour: str) -> list[Part]:
    kept = np.isin(np.arange(len(hull.converged)), dimensions.kept)
    groups = (
        ("kept", hull.converged & kept, {"color": colour, "size": 6}, "lines+markers"),
        ("rejected by d_max", hull.converged & ~kept, {"color": DROPPED, "size": 8, "symbol": "x"}, "markers"),
        ("unfitted", ~hull.converged, {"color": TRUTH, "size": 4, "symbol": "circle-open"}, "markers"),
    )
    look = {"line": {"color": colour, "width": 1}, "hovertemplate": "radius %{x:.1f} mm<br>z %{y:.1f} mm"}
    return [
        scatter(hull.radii_mm[chosen], hull.heights_mm[chosen], mode=mode, name=name, marker=marker, **look)
        for name, chosen, marker, mode in groups
        if chosen.any()
    ]


def _beside(name: str, hull: Hull) -> Part:
    shown = f"{name}: radius %{{x:.1f}} mm<br>z %{{y:.1f}} mm"
    radii_mm, heights_mm = hull.radii_mm[hull.converged], hull.heights_mm[hull.converged]
    line = {"color": PRESET_COLOURS[name], "width": 3}
    return scatter(radii_mm, heights_mm, mode="lines", name=name, line=line, hovertemplate=shown)


def _known(known: KnownProfile, *, base_mm: float) -> Part:
    radii_mm, heights_mm = [0, *known.radii_mm, 0], known.heights_mm + base_mm
    place = ", from the lower end up" if known.base_mm is None else ""
    look = {"name": f"{known.source}{place}", "hovertemplate": f"{known.source}: radius %{{x:.1f}} mm"}
    line = {"color": TRUTH, "width": 2, "dash": "dash"}
    return scatter(radii_mm, [heights_mm[0], *heights_mm, heights_mm[-1]], mode="lines", line=line, **look)


def _across(height_mm: float) -> Part:
    ends = {"xref": "x domain", "x0": 0, "x1": 1, "y0": height_mm, "y1": height_mm}
    return {"type": "line", **ends, "line": {"color": BEST, "width": 2}}
