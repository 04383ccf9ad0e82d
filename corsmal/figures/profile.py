"""The radii profile: what was fitted, what smoothing rejected, and where the ends are."""

import numpy as np
from numpy.typing import NDArray

from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.style import BEST, DROPPED, PRESET_COLOURS, TRUTH, Part, axis, note, plain_layout, scatter
from corsmal.shape import Dimensions, Hull, KnownProfile

MARGIN_MM, MARGIN_SHARE = 30.0, 0.3
"""What is shown above and below the fitted heights: mm at least, and the share of their extent."""


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
    ends = {"i_b, lower end": dimensions.bottom, "i_t, upper end": dimensions.top}
    marks = {
        f"{name}: {2 * hull.radii_mm[index]:.1f} mm wide": float(hull.heights_mm[index])
        for name, index in ends.items()
        if index is not None
    }
    drawn_mm = [each.heights_mm[each.converged] for each in (hull, *([] if beside is None else [beside[1]]))]
    base_mm = None if known is None else known.base_of(hull, dimensions)
    if known is not None and base_mm is not None:
        drawn_mm.append(known.heights_mm + base_mm)
    limits_mm = _limits(hull, np.concatenate(drawn_mm))
    traces = _radii(hull, dimensions, PRESET_COLOURS[preset], is_part=limits_mm is not None)
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
    fixed = {} if limits_mm is None else {"range": limits_mm}
    layout = plain_layout(
        shapes=[_across(height_mm) for height_mm in marks.values()],
        annotations=[note(text, y=height_mm, **right) for text, height_mm in marks.items()],
        xaxis=axis("radius (mm)", range=[0, 1.1 * widest_mm], constraintoward="left"),
        yaxis=axis("height z above the table (mm)", scaleanchor="x", **fixed),
    )
    return traces, layout


def _limits(hull: Hull, drawn_mm: NDArray[np.float64]) -> list[float] | None:
    """Where the picture begins and ends, mm, if heights at which nothing fits would make the container small.

    Args:
        hull: the fitted hull.
        drawn_mm: (n,) heights of what is drawn but for unfitted circumferences.
    """
    if not hull.converged.any():
        return None
    margin_mm = max(MARGIN_MM, MARGIN_SHARE * float(np.ptp(drawn_mm)))
    low, high = float(drawn_mm.min()) - margin_mm, float(drawn_mm.max()) + margin_mm
    return [low, high] if hull.heights_mm.min() < low or hull.heights_mm.max() > high else None


def _radii(hull: Hull, dimensions: Dimensions, colour: str, *, is_part: bool) -> list[Part]:
    unfitted = "unfitted; double-click to see all" if is_part else "unfitted"
    kept = np.isin(np.arange(len(hull.converged)), dimensions.kept)
    groups = (
        ("kept", hull.converged & kept, {"color": colour, "size": 6}, "lines+markers"),
        ("rejected by d_max", hull.converged & ~kept, {"color": DROPPED, "size": 8, "symbol": "x"}, "markers"),
        (unfitted, ~hull.converged, {"color": TRUTH, "size": 4, "symbol": "circle-open"}, "markers"),
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
