"""The hull in 3D, with its circumferences, the table and the cameras that saw it."""

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.hull_scene import Surroundings, camera, camera_names, light, lines, table, views
from corsmal.figures.style import BEST, DROPPED, ERROR_COLOURS, PRESET_COLOURS, RING, Part, plain_layout
from corsmal.geometry import Camera, Floats
from corsmal.shape import Dimensions, Hull, KnownProfile, circumference_points, hull_mesh

SIDES = 36
WIRES = 12
"""Circumferences that are drawn of a hull beside the fitted one."""
ERROR_STEP_MM = 5.0
"""The colours of errors end at a multiple of this, so that they do not change with every step of a slider."""
LIGHT = {"ambient": 0.6, "diffuse": 0.75, "specular": 0.25, "roughness": 0.55, "fresnel": 0.1}
EVEN_LIGHT = {"ambient": 0.85, "diffuse": 0.3, "specular": 0.05}
"""For colours that are read."""

Scope = Literal["container", "cameras"]


@Drawing
def hull_figure(
    hull: Hull,
    dimensions: Dimensions,
    *,
    cameras: Mapping[str, Camera],
    preset: str = "paper",
    scope: Scope = "container",
    beside: tuple[str, Hull] | None = None,
    known: KnownProfile | None = None,
    has_axes: bool = False,
) -> Drawn:
    """The hull as a lit surface above the table, its circumferences, each camera's frustum and its ray to the centroid.

    Args:
        hull: the fitted hull; only the cameras are drawn for a failed one. World millimetres.
        dimensions: marks the circumferences that smoothing rejected and the two ends.
        cameras: by view.
        preset: whose colour the surface has.
        scope: ``container`` frames the hull, ``cameras`` the whole set-up. Both are to scale.
        beside: preset and hull of another fit, drawn over it.
        known: colours the surface by its distance from this profile instead, mm, positive outside.
        has_axes: whether axes are drawn.
    """
    around = _surroundings(hull, cameras, scope)
    target_m = hull.centroid_m
    traces = [*table(around)]
    if hull.ok:
        lit = {"lighting": LIGHT, "lightposition": light(cameras, target_m=target_m)}
        traces += [_surface(hull, preset) | lit | _colours(hull, dimensions, known), *_circumferences(hull, dimensions)]
    if beside is not None and beside[1].ok:
        traces.append(_wires(beside[1], beside[0]))
    traces += [camera(view, seen, target_m=target_m) for view, seen in cameras.items()]
    placed = views(cameras, around, target_m=target_m)
    scene = around.scene(has_axes=has_axes) | {
        "camera": placed["start"],
        "annotations": camera_names(cameras, around, target_m=target_m),
    }
    menu = _view_buttons({name: at for name, at in placed.items() if name != "start"})
    return traces, plain_layout(margin={"l": 0, "r": 0, "t": 34, "b": 0}, scene=scene, updatemenus=[menu])


def _surroundings(hull: Hull, cameras: Mapping[str, Camera], scope: Scope) -> Surroundings:
    heights_mm, radii_mm = hull.heights_mm[hull.converged], hull.radii_mm[hull.converged]
    if hull.centroid_m is None or not len(heights_mm):
        return Surroundings.of_cameras(cameras, np.empty((0, 3)))
    axis_mm, ends_mm = hull.centroid_m[:2] * 1000, (float(heights_mm[0]), float(heights_mm[-1]))
    if scope == "cameras":
        return Surroundings.of_cameras(cameras, np.array([[*axis_mm, height_mm] for height_mm in ends_mm]))
    reach_mm = float(np.hypot(radii_mm.max(), (hull.depth_mm or 0.0) / 2))
    return Surroundings.of_container(axis_mm, ends_mm, reach_mm)


def _view_buttons(placed: Mapping[str, Part]) -> Part:
    """Buttons that move the camera."""
    buttons = [
        {"label": name.capitalize(), "method": "relayout", "args": [{"scene.camera": at}]}
        for name, at in placed.items()
    ]
    place = {"x": 0, "xanchor": "left", "y": 0, "yanchor": "bottom", "pad": {"l": 4, "b": 4}}
    return {"type": "buttons", "direction": "right", "showactive": False, "buttons": buttons, **place}


def _surface(hull: Hull, name: str) -> Part:
    vertices, faces = _with_edges(*hull_mesh(hull, sides=SIDES))
    return {
        "type": "mesh3d",
        **dict(zip("xyz", vertices.T.astype(np.float32), strict=True)),
        **dict(zip("ijk", faces.T.astype(np.min_scalar_type(len(vertices))), strict=True)),
        "color": PRESET_COLOURS[name],
        "name": name,
        "uid": "hull",
        "showlegend": True,
        "hoverinfo": "skip",
    }


def _with_edges(vertices: Floats, faces: NDArray[np.int64]) -> tuple[Floats, NDArray[np.int64]]:
    """A hull's mesh whose caps have corners of their own, so that its edges are not lit as if they were round."""
    if not len(vertices):
        return vertices, faces
    walls = len(vertices) - 2
    ends = np.concatenate([vertices[:SIDES], vertices[walls - SIDES : walls]])
    caps = faces[-2 * SIDES :]
    corners = np.where(caps < SIDES, caps + walls + 2, caps - (walls - SIDES) + walls + 2 + SIDES)
    moved = np.where(caps >= walls, caps, corners)
    return np.concatenate([vertices, ends]), np.concatenate([faces[: -2 * SIDES], moved])


def _colours(hull: Hull, dimensions: Dimensions, known: KnownProfile | None) -> Part:
    """What colours a surface by its distance from a known profile; nothing where there is none."""
    base_mm = None if known is None else known.base_of(hull, dimensions)
    if known is None or base_mm is None or hull.converged.sum() < 2:
        return {}
    errors = known.errors_mm(hull, base_mm=base_mm)[hull.converged]
    around = np.repeat(errors, SIDES)
    intensity = np.concatenate([around, errors[[0, -1]], around[:SIDES], around[-SIDES:]])
    limit = ERROR_STEP_MM * max(1.0, float(np.ceil(np.percentile(np.abs(errors), 90) / ERROR_STEP_MM)))
    bar = {"title": {"text": f"distance to the<br>{known.source} (mm)"}, "thickness": 12, "len": 0.7, "x": 1}
    return {
        "lighting": EVEN_LIGHT,
        "intensity": intensity.astype(np.float32),
        "colorscale": ERROR_COLOURS,
        "cmin": -limit,
        "cmax": limit,
        "colorbar": bar,
        "showlegend": False,
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
        lines(rings[chosen].reshape(-1, 3), colour=colour, width=width, name=name)
        | {"hoverinfo": "skip", "visible": True if colour == BEST else "legendonly"}
        for name, chosen, colour, width in groups
        if chosen.any()
    ]


def _wires(hull: Hull, name: str) -> Part:
    """Another hull as circumferences and lines along its wall, which leave the first one in sight."""
    rings = _closed_rings(hull)[hull.converged]
    chosen = rings[np.linspace(0, len(rings) - 1, min(len(rings), WIRES)).round().astype(np.intp)]
    along = np.concatenate([rings[:, ::4][:, : SIDES // 4], rings[:1, -1:].repeat(SIDES // 4, axis=1)]).swapaxes(0, 1)
    points = np.concatenate([chosen.reshape(-1, 3), along.reshape(-1, 3)])
    return lines(points, colour=PRESET_COLOURS[name], width=3, name=name) | {"hoverinfo": "skip", "uid": "beside"}


def _closed_rings(hull: Hull) -> Floats:
    """(L, SIDES + 2, 3) mm: each circumference closed, followed by a gap."""
    points = circumference_points(hull, points=SIDES) * 1000
    gap = np.full((len(points), 1, 3), np.nan)
    return np.concatenate([points, points[:, :1], gap], axis=1)
