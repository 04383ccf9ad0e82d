"""The hull in 3D, with its circumferences and the cameras that saw it."""

from collections.abc import Mapping
from typing import Literal

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from corsmal.figures.style import BEST, DROPPED, HULL, RING, VIEW_COLOURS, plain_layout
from corsmal.geometry import Camera
from corsmal.shape import Dimensions, Hull, circumference_points, hull_mesh

Floats = NDArray[np.float64]

SIDES = 36
MARGIN_MM = 60.0
FRUSTUM_DEPTH_MM = 150.0

Scope = Literal["container", "cameras"]


def hull_figure(
    hull: Hull, dimensions: Dimensions, *, cameras: Mapping[str, Camera], scope: Scope = "container"
) -> go.Figure:
    """The hull as a surface with its circumferences, each camera as a frustum with its ray to the centroid.

    Args:
        hull: the fitted hull; a failed one leaves the cameras alone.
        dimensions: marks the circumferences that smoothing dropped and the two ends.
        cameras: by view.
        scope: ``container`` frames the hull, ``cameras`` the whole set-up. Both are to scale.

    Returns:
        A 3D figure in world millimetres.
    """
    figure = go.Figure(layout=plain_layout())
    figure.update_layout(margin={"l": 0, "r": 0, "t": 30, "b": 0})
    if hull.ok:
        _add_surface(figure, hull)
        _add_circumferences(figure, hull, dimensions)
    for view, camera in cameras.items():
        _add_camera(figure, view, camera, target_m=hull.centroid_m)
    figure.update_scenes(
        aspectmode="data",
        xaxis_title="x (mm)",
        yaxis_title="y (mm)",
        zaxis_title="z (mm)",
        camera={"eye": _viewpoint(cameras, hull)},
    )
    if scope == "container" and hull.converged.any():
        _frame_container(figure, hull)
    return figure


def _add_surface(figure: go.Figure, hull: Hull) -> None:
    vertices, faces = hull_mesh(hull, sides=SIDES)
    x, y, z = vertices.T.astype(np.float32)
    i, j, k = faces.T.astype(np.int32)
    lighting = {"ambient": 0.6, "diffuse": 0.7, "specular": 0.2, "roughness": 0.6}
    figure.add_mesh3d(
        x=x, y=y, z=z, i=i, j=j, k=k, color=HULL, opacity=0.55, lighting=lighting, name="hull", hoverinfo="skip"
    )


def _add_circumferences(figure: go.Figure, hull: Hull, dimensions: Dimensions) -> None:
    kept = np.zeros(len(hull.converged), dtype=bool)
    kept[dimensions.kept] = True
    ends = np.zeros_like(kept)
    ends[[index for index in (dimensions.bottom, dimensions.top) if index is not None]] = True
    groups = (
        ("circumferences", hull.converged & kept & ~ends, RING, 1),
        ("smoothed away", hull.converged & ~kept, DROPPED, 2),
        ("lower and upper end", hull.converged & ends, BEST, 6),
    )
    rings = _closed_rings(hull)
    for name, chosen, colour, width in groups:
        if chosen.any():
            x, y, z = rings[chosen].reshape(-1, 3).T
            figure.add_scatter3d(
                x=x, y=y, z=z, mode="lines", line={"color": colour, "width": width}, name=name, hoverinfo="skip"
            )


def _closed_rings(hull: Hull) -> Floats:
    """(L, SIDES + 2, 3) mm: each circumference closed, followed by a gap."""
    points = circumference_points(hull, points=SIDES) * 1000
    gap = np.full((len(points), 1, 3), np.nan)
    return np.concatenate([points, points[:, :1], gap], axis=1).astype(np.float32)


def _add_camera(figure: go.Figure, view: str, camera: Camera, *, target_m: Floats | None) -> None:
    width, height = camera.size
    corners_px = np.array([[0, 0], [width, 0], [width, height], [0, height]]) - 0.5
    rays = np.column_stack([corners_px, np.ones(4)]) @ np.linalg.inv(camera.intrinsic).T
    centre = camera.centre_m * 1000
    corners = centre + FRUSTUM_DEPTH_MM * rays @ camera.rotation
    path = [centre, corners[0], corners[1], centre, corners[2], corners[3], centre, corners[0], corners[3]]
    path += [corners[2], corners[1]]
    if target_m is not None:
        path += [np.full(3, np.nan), centre, target_m * 1000]
    x, y, z = np.array(path, dtype=np.float32).T
    figure.add_scatter3d(
        x=x, y=y, z=z, mode="lines", line={"color": VIEW_COLOURS[view], "width": 4}, name=view, hoverinfo="name"
    )


def _viewpoint(cameras: Mapping[str, Camera], hull: Hull) -> dict[str, float]:
    """Where to look from at first: the side of the first camera, a little above."""
    if not cameras or hull.centroid_m is None:
        return {"x": 1.2, "y": 1.2, "z": 0.8}
    away = next(iter(cameras.values())).centre_m - hull.centroid_m
    x, y = 1.7 * away[:2] / np.linalg.norm(away[:2])
    return {"x": float(x), "y": float(y), "z": 0.7}


def _frame_container(figure: go.Figure, hull: Hull) -> None:
    if hull.centroid_m is None:
        return
    x, y = hull.centroid_m[:2] * 1000
    heights = hull.heights_mm[hull.converged]
    reach = float(hull.radii_mm[hull.converged].max()) + MARGIN_MM
    bottom, top = float(heights[0]) - MARGIN_MM / 2, float(heights[-1]) + MARGIN_MM / 2
    figure.update_scenes(
        xaxis_range=[x - reach, x + reach],
        yaxis_range=[y - reach, y + reach],
        zaxis_range=[bottom, top],
        aspectmode="manual",
        aspectratio={"x": 1, "y": 1, "z": (top - bottom) / (2 * reach)},
    )
