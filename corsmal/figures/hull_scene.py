"""What a hull stands in: the table's plane, the cameras with their names, and where one looks from."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from corsmal.figures.style import TABLE, VIEW_COLOURS, Part, axis, note
from corsmal.geometry import Camera, Floats
from corsmal.parameters import FRONTAL_VIEW

FRUSTUM_DEPTH_MM = 150.0
MARGIN_MM = 45.0
GRID_MM = 50.0
"""Between the lines of the table."""
TABLE_NEAR_MM = 200.0
"""The table is part of a hull's surroundings where it is at most this far below it."""
DISTANCE = 1.6
"""From the camera to what it looks at, which is one unit high or wide: that then fills the frame."""
RAISED, FROM_ABOVE = 0.42, 60.0
"""Of the views' directions: height over horizontal distance; straight from above the turn would be undefined."""
ASIDE = np.deg2rad(-35.0)
"""The first view is turned by so much about the vertical from the first camera's, whose ray would cross the hull."""
LIT_FROM = np.deg2rad(30.0)
"""The light likewise, from the first view."""
LIGHT_DISTANCE = 1e5
NEARLY = 0.98
"""What lies on the side of the drawn box itself may not be drawn."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """A box of the world and what stands in its middle, mm.

    Args:
        low: (3,) one corner of the box that is drawn.
        high: (3,) the opposite corner.
        focus: (3,) the point at the centre of the view.
        unit: how large that is.
    """

    low: Floats
    high: Floats
    focus: Floats
    unit: float

    @classmethod
    def of_container(cls, axis_mm: Floats, ends_mm: tuple[float, float], reach: float) -> "Surroundings":
        """A little more than a container.

        Args:
            axis_mm: (2,) where its axis stands.
            ends_mm: heights of its lower and its upper end.
            reach: largest distance of its wall from the axis, mm.
        """
        bottom, top = ends_mm
        sides = reach + MARGIN_MM
        floor = min(bottom - MARGIN_MM / 2, -1.0) if bottom <= TABLE_NEAR_MM else bottom - MARGIN_MM / 2
        return cls(
            low=np.array([*(axis_mm - sides), floor]),
            high=np.array([*(axis_mm + sides), top + MARGIN_MM / 2]),
            focus=np.array([*axis_mm, (bottom + top) / 2]),
            unit=max(2 * reach, (top - bottom) + 0.5 * reach),
        )

    @classmethod
    def of_cameras(cls, cameras: Mapping[str, Camera], others_mm: Floats) -> "Surroundings":
        """All cameras, the table below them and (n, 3) other points."""
        centres = [camera.centre_m * 1000 for camera in cameras.values()]
        points = np.array([*centres, *others_mm, np.zeros(3)])
        low, high = points.min(axis=0) - FRUSTUM_DEPTH_MM, points.max(axis=0) + FRUSTUM_DEPTH_MM
        return cls(low, high, focus=(low + high) / 2, unit=float((high - low).max()))

    @property
    def has_table(self) -> bool:
        """Whether the table's plane, z = 0, lies in the box."""
        return bool(self.low[2] < 0 < self.high[2])

    def scene(self, *, has_axes: bool) -> Part:
        """The layout's scene without a camera: the box to scale."""
        axes = {
            f"{name}axis": axis(f"{name} (mm)", visible=has_axes, range=[float(low), float(high)])
            for name, low, high in zip("xyz", self.low, self.high, strict=True)
        }
        ratio = dict(zip("xyz", ((self.high - self.low) / self.unit).tolist(), strict=True))
        return {**axes, "aspectmode": "manual", "aspectratio": ratio}

    def camera(self, direction: Floats) -> Part:
        """Plotly's camera that looks at the focus from a (3,) direction."""
        centre = (self.focus - (self.low + self.high) / 2) / self.unit
        eye = centre + DISTANCE * direction / np.linalg.norm(direction)
        return {
            name: dict(zip("xyz", vector.tolist(), strict=True))
            for name, vector in (("eye", eye), ("center", centre), ("up", np.array([0.0, 0.0, 1.0])))
        }

    def leaving(self, target_mm: Floats, towards_mm: Floats) -> Floats:
        """(3,) where the way from a point in the box to another one is about to leave it; the end where it does not."""
        way = towards_mm - target_mm
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.where(way > 0, (self.high - target_mm) / way, (self.low - target_mm) / way)
        share = float(np.nanmin(np.where(way == 0, np.inf, shares)))
        return np.asarray(target_mm + way * min(1.0, NEARLY * share))


def table(around: Surroundings) -> list[Part]:
    """The table's plane with a grid of ``GRID_MM``; nothing where it lies elsewhere."""
    if not around.has_table:
        return []
    (x0, y0), (x1, y1) = around.low[:2], around.high[:2]
    corners = np.array([[x0, y0, 0], [x1, y0, 0], [x1, y1, 0], [x0, y1, 0]])
    plane = {
        "type": "mesh3d",
        **dict(zip("xyz", corners.T.astype(np.float32), strict=True)),
        **dict(zip("ijk", np.array([[0, 0], [1, 2], [2, 3]], dtype=np.uint8), strict=True)),
    }
    look = {"color": TABLE, "opacity": 0.22, "hoverinfo": "skip", "name": "table", "uid": "table"}
    xs, ys = (np.arange(np.ceil(low / GRID_MM), high / GRID_MM) * GRID_MM for low, high in ((x0, x1), (y0, y1)))
    gap = [np.nan] * 3
    rows = [point for x in xs for point in ([x, y0, 0.0], [x, y1, 0.0], gap)]
    rows += [point for y in ys for point in ([x0, y, 0.0], [x1, y, 0.0], gap)]
    grid = lines(np.array(rows).reshape(-1, 3), colour=TABLE, width=1, name=f"table, grid of {GRID_MM:.0f} mm")
    return [plane | look, grid | {"hoverinfo": "skip", "opacity": 0.6, "showlegend": False}]


def camera(view: str, seen: Camera, *, target_m: Floats | None) -> Part:
    """A camera as a frustum, with its ray to the target."""
    width, height = seen.size
    corners_px = np.array([[0, 0], [width, 0], [width, height], [0, height]]) - 0.5
    rays = np.column_stack([corners_px, np.ones(4)]) @ np.linalg.inv(seen.intrinsic).T
    centre = seen.centre_m * 1000
    corners = centre + FRUSTUM_DEPTH_MM * rays @ seen.rotation
    path = [centre, corners[0], corners[1], centre, corners[2], corners[3], centre, corners[0], corners[3]]
    path += [corners[2], corners[1]]
    if target_m is not None:
        path += [np.full(3, np.nan), centre, target_m * 1000]
    return lines(np.array(path), colour=VIEW_COLOURS[view], width=4, name=view) | {
        "hoverinfo": "name",
        "showlegend": False,
    }


def camera_names(cameras: Mapping[str, Camera], around: Surroundings, *, target_m: Floats | None) -> list[Part]:
    """Each camera's name at its place; where that is outside the box, where its ray leaves it."""
    names = []
    for view, seen in cameras.items():
        place = seen.centre_m * 1000
        if target_m is not None:
            place = around.leaving(target_m * 1000, place)
        text = f"<span style='color:{VIEW_COLOURS[view]}'>●</span> {view}"
        names.append(note(text, **dict(zip("xyz", place.tolist(), strict=True)), xanchor="left"))
    return names


def views(cameras: Mapping[str, Camera], around: Surroundings, *, target_m: Floats | None) -> dict[str, Part]:
    """Plotly's cameras by name: the hull as it is seen at first, and from the frontal camera, its side and above."""
    first = _first_direction(cameras, target_m)
    front = _horizontal(cameras.get(FRONTAL_VIEW), target_m) if FRONTAL_VIEW in cameras else first
    directions = {
        "start": [*first, RAISED],
        "front": [*front, 0.0],
        "side": [-front[1], front[0], 0.0],
        "top": [*front, FROM_ABOVE],
    }
    return {name: around.camera(np.array(direction)) for name, direction in directions.items()}


def light(cameras: Mapping[str, Camera], *, target_m: Floats | None) -> Part:
    """Plotly's position of the light: on the side from which the hull is seen at first, and above."""
    direction = np.array([*_turned(_first_direction(cameras, target_m), LIT_FROM), 1.0])
    return dict(zip("xyz", (LIGHT_DISTANCE * direction).tolist(), strict=True))


def _first_direction(cameras: Mapping[str, Camera], target_m: Floats | None) -> Floats:
    """(2,) from where the hull is seen at first: beside the first camera."""
    return _turned(_horizontal(next(iter(cameras.values()), None), target_m), ASIDE)


def _turned(direction: Floats, angle: float) -> Floats:
    """(2,) a direction turned by an angle, radians."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine], [sine, cosine]]) @ direction


def _horizontal(seen: Camera | None, target_m: Floats | None) -> Floats:
    """(2,) unit vector from the target towards a camera, seen from above."""
    if seen is None or target_m is None:
        return np.array([1.0, 1.0]) / np.sqrt(2)
    away = (seen.centre_m - target_m)[:2]
    length = float(np.linalg.norm(away))
    return away / length if length > 1e-6 else np.array([1.0, 0.0])


def lines(points_mm: Floats, *, colour: str, width: int, name: str) -> Part:
    """A trace of lines through (n, 3) points with gaps where they are NaN."""
    return {
        "type": "scatter3d",
        **dict(zip("xyz", points_mm.T.astype(np.float32), strict=True)),
        "mode": "lines",
        "line": {"color": colour, "width": width},
        "name": name,
        "uid": re.sub(r"\W+", "-", name),  # a part of a selector of Plotly's
    }
