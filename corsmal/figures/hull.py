"""The hull in 3D, with its circumferences and the cameras that saw it."""

from collections.abc import Mapping
from typing import Literal

import numpy as np

from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.style import BESIDE, BEST, DROPPED, HULL, RING, VIEW_COLOURS, Part, axis, plain_layout
from corsmal.geometry import Camera, Floats
from corsmal.shape import Dimensions, Hull, circumference_points, hull_mesh

SIDES = 36
MARGIN_MM = 60.0
FRUSTUM_DEPTH_MM = 150.0

Scope = Literal["container", "cameras"]


@Drawing
def hull_figure(
    hull: Hull,
    dimensions: Dimensions,
    *,
    cameras: Mapping[str, Camera],
    scope: Scope = "container",
    beside: tuple[str, Hull] | None = None,
) -> Drawn:
    """The hull as a surface with its circumferences, each camera as a frustum with its ray to the centroid.

    Args:
        hull: the fitted hull; only the cameras are drawn for a failed one. World millimetres.
        dimensions: marks the circumferences that smoothing rejected and the two ends.
        cameras: by view.
        scope: ``container`` frames the hull, ``cameras`` the whole set-up. Both are to scale.
        beside: name and hull of another fit, drawn over it.
    """
    traces = [_surface(hull), *_circumferences(hull, dimensions)] if hull.ok else []
    if beside is not None and beside[1].ok:
        traces.append(_surface(beside[1]) | {"name": beside[0], "color": BESIDE, "opacity": 0.35, "showlegend": True})
    traces += [_camera(view, camera, target_m=hull.centroid_m) for view, camera in cameras.items()]
    scene = {
        **{f"{name}axis": axis(f"{name} (mm)") for name in "xyz"},
        "aspectmode": "data",
        "camera": {"eye": _viewpoint(cameras, hull)},
    }
    if scope == "container" and hull.centroid_m is not None and hull.converged.any():
        _frame_container(scene, hull, axis_mm=hull.centroid_m[:2] * 1000)
    return traces, plain_layout(margin={"l": 0, "r": 0, "t": 30, "b": 0}, scene=scene)


def _surface(hull: Hull) -> Part:
    vertices, faces = hull_mesh(hull, sides=SIDES)
    return {
        "type": "mesh3d",
        **dict(zip("xyz", vertices.T.astype(np.float32), strict=True)),
        **dict(zip("ijk", faces.T.astype(np.min_scalar_type(len(vertices))), strict=True)),
        "color": HULL,
        "opacity": 0.55,
        "lighting": {"ambient": 0.6, "diffuse": 0.7, "specular": 0.2, "roughness": 0.6},
        "name": "hull",
        "hoverinfo": "skip",
    }


def _circumferences(hull: Hull, dimensions: Dimensions) -> list[Part]:
    kept = np.zeros(len(hull.converged), dtype=bool)
    kept[dimensions.kept] = True
    ends = np.zeros_like(kept)
    ends[[index for index in (dimensions.bottom, dimensions.top) if index is not None]] = True
    groups = (
        ("circumferences", hull.converged & kept & ~ends, RING, 1),
        ("rejected by d_max", hull.converged & ~kept, DROPPED, 2),
        ("lower and upper end", hull.converged & ends, BEST, 6),
    )
    rings = _closed_rings(hull)
    return [
        _lines(rings[chosen].reshape(-1, 3), colour=colour, width=width, name=name) | {"hoverinfo": "skip"}
        for name, chosen, colour, width in groups
        if chosen.any()
    ]


def _lines(points_mm: Floats, *, colour: str, width: int, name: str) -> Part:
    return {
        "type": "scatter3d",
        **dict(zip("xyz", points_mm.T.astype(np.float32), strict=True)),
        "mode": "lines",
        "line": {"color": colour, "width": width},
        "name": name,
    }


def _closed_rings(hull: Hull) -> Floats:
    """(L, SIDES + 2, 3) mm: each circumference closed, followed by a gap."""
    points = circumference_points(hull, points=SIDES) * 1000
    gap = np.full((len(points), 1, 3), np.nan)
    return np.concatenate([points, points[:, :1], gap], axis=1)


def _camera(view: str, camera: Camera, *, target_m: Floats | None) -> Part:
    width, height = camera.size
    corners_px = np.array([[0, 0], [width, 0], [width, height], [0, height]]) - 0.5
    rays = np.column_stack([corners_px, np.ones(4)]) @ np.linalg.inv(camera.intrinsic).T
    centre = camera.centre_m * 1000
    corners = centre + FRUSTUM_DEPTH_MM * rays @ camera.rotation
    path = [centre, corners[0], corners[1], centre, corners[2], corners[3], centre, corners[0], corners[3]]
    path += [corners[2], corners[1]]
    if target_m is not None:
        path += [np.full(3, np.nan), centre, target_m * 1000]
    return _lines(np.array(path), colour=VIEW_COLOURS[view], width=4, name=view) | {"hoverinfo": "name"}


def _viewpoint(cameras: Mapping[str, Camera], hull: Hull) -> dict[str, float]:
    """Where to look from at first: the side of the first camera, a little above."""
    if not cameras or hull.centroid_m is None:
        return {"x": 1.2, "y": 1.2, "z": 0.8}
    away = next(iter(cameras.values())).centre_m - hull.centroid_m
    x, y = 1.7 * away[:2] / max(float(np.linalg.norm(away[:2])), 1e-6)
    return {"x": float(x), "y": float(y), "z": 0.7}


def _frame_container(scene: Part, hull: Hull, *, axis_mm: Floats) -> None:
    """Let a scene end a little outside the hull, still to scale."""
    heights = hull.heights_mm[hull.converged]
    reach = float(hull.radii_mm[hull.converged].max()) + MARGIN_MM
    bottom, top = float(heights[0]) - MARGIN_MM / 2, float(heights[-1]) + MARGIN_MM / 2
    for name, middle in zip(("xaxis", "yaxis"), axis_mm.tolist(), strict=True):
        scene[name]["range"] = [middle - reach, middle + reach]
    scene["zaxis"]["range"] = [bottom, top]
    scene["aspectmode"] = "manual"
    scene["aspectratio"] = {"x": 1, "y": 1, "z": (top - bottom) / (2 * reach)}
