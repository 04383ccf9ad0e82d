"""Masks and dimensions for the mass network from rendered recordings, with the truth beside them."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa

from corsmal.detection.rle import decode_mask, encode_masks
from corsmal.errors import ArgumentError, FileError
from corsmal.files import writing
from corsmal.geometry import Camera
from corsmal.mass.physics import mm_per_pixel
from corsmal.mass.records import MassRow
from corsmal.parameters import PAIRS, ShapeParameters
from corsmal.shape import Dimensions, Hull, fit_hull, measure_hull
from corsmal.synthetic.render.frame import FrameTruth, render_frame
from corsmal.synthetic.scene.containers import ANNOTATED_IDS, demo_container
from corsmal.synthetic.scene.scene import Scene, training_scene

MASS_PAIR = PAIRS[0]
"""The views that are rendered; the mask comes from the first, the robot's."""

FRAMES_PER_SCENE = 12
VISIBLE_PX_MIN = 24
"""A frame that shows less of the container in either view is left out."""

_STREAM = 5 * 10**12
"""Seeds from here on are no other training's."""

DIMENSIONS = ("width_top_mm", "width_bottom_mm", "height_mm")

COLUMNS = (
    *("container_id", "seed", "frame", "score", "best", "tilt_deg", "height", "width", "visible", "amodal"),
    *DIMENSIONS,
    *("capacity_ml", "mm_per_px", "reason"),
)


@dataclass(frozen=True)
class MassDataPlan:
    """Which recordings are rendered.

    Args:
        recordings: of each container.
        containers: numbers of the containers.
        seed: another seed, other recordings.
        frames: equally spaced frames that are looked at in each.

    Raises:
        ArgumentError: a number is not positive, or there is no container.
    """

    recordings: int = 120
    containers: tuple[int, ...] = ANNOTATED_IDS
    seed: int = 0
    frames: int = FRAMES_PER_SCENE

    def __post_init__(self) -> None:
        if self.recordings < 1 or self.frames < 1 or self.seed < 0 or not self.containers:
            raise ArgumentError(f"recordings and frames must be at least 1, seed at least 0, got {self}")


def make_mass_data(
    plan: MassDataPlan, *, shape: ShapeParameters | None = None, progress: Callable[[int, int], None] | None = None
) -> pd.DataFrame:
    """Render recordings and measure the container in them as the method would with a perfect detector.

    Args:
        plan: which recordings.
        shape: parameters of the fit; default: the paper's.
        progress: called with the numbers of recordings done and wanted.

    Returns:
        A row per frame (``COLUMNS``): the visible and the amodal mask of view3 as COCO run lengths, the four
        quantities of the hull fitted to both views' visible masks (NaN with a ``reason`` where the fit failed), the mm
        that a pixel spans at the hull's centroid, the true tilt of the axis in the image, the pair's score, and
        whether it is the recording's ``best`` frame (equation 5).
    """
    shape = shape or ShapeParameters.paper()
    rows: list[dict[str, Any]] = []
    for index in range(plan.recordings):
        for number in plan.containers:
            seed = _STREAM + (plan.seed * 10**6 + index) * 100 + number
            rows += _scene_rows(training_scene(seed, containers=(number,)), plan.frames, shape)
        if progress is not None:
            progress((index + 1) * len(plan.containers), plan.recordings * len(plan.containers))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def write_mass_data(path: Path, table: pd.DataFrame) -> None:
    """Write a table of ``make_mass_data`` as Parquet.

    Raises:
        FileError: it cannot be written.
    """
    with writing(path, advice="choose another place", errors=(pa.ArrowException,)) as part:
        table.to_parquet(part, index=False)


def read_mass_data(path: Path) -> pd.DataFrame:
    """Read what ``write_mass_data`` wrote.

    Raises:
        FileError: there is no such file, or it holds something else.
    """
    try:
        table = pd.read_parquet(path)
    except FileNotFoundError as error:
        raise FileError(path, "is not there; make the data first") from error
    except (OSError, ValueError, pa.ArrowException) as error:
        raise FileError(path, "is broken; delete it and make the data again") from error
    if not set(COLUMNS) <= set(table.columns):
        raise FileError(path, "is no table of masks; delete it and make the data again")
    return table


def best_frames(table: pd.DataFrame, *, count: int = 1) -> pd.DataFrame:
    """The rows of each recording's frames with the highest scores, at most ``count`` of each; of equal ones the first.

    One is what the method looks at; more of them show the network a recording's container more often.
    """
    ranks = table.groupby("seed")["score"].rank(ascending=False, method="first")
    return table[ranks <= count]


def masks_of(table: pd.DataFrame, column: str = "visible") -> Iterator[np.ndarray]:
    """The (H, W) bool masks of a table's rows, one after the other; ``column`` is ``visible`` or ``amodal``."""
    for height, width, counts in zip(table["height"], table["width"], table[column], strict=True):
        yield decode_mask(counts, (int(height), int(width)))


def mass_rows(table: pd.DataFrame, *, true_dimensions: bool = False) -> Iterator[MassRow]:
    """What the network is trained on and judged by, a row per row of the table.

    Args:
        table: of ``make_mass_data``; mostly its ``best_frames``.
        true_dimensions: the container's own dimensions instead of the measured ones.
    """
    for row, mask in zip(table.to_dict("records"), masks_of(table), strict=True):
        container = demo_container(int(row["container_id"]))
        sizes = {name: getattr(container, name) if true_dimensions else row[name] for name in DIMENSIONS}
        yield MassRow(
            recording_id=str(row["seed"]),
            container=str(row["container_id"]),
            mask=mask,
            **{name: _number(value) for name, value in sizes.items()},
            mm_per_px=_number(row["mm_per_px"]),
            mass_g=container.mass_g,
        )


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _scene_rows(scene: Scene, frames: int, shape: ShapeParameters) -> list[dict[str, Any]]:
    rows = []
    for frame in np.unique(np.linspace(0, scene.frames - 1, frames).round().astype(int)).tolist():
        truths = [render_frame(scene, view, frame) for view in MASS_PAIR]
        if min(truth.visible.sum() for truth in truths) >= VISIBLE_PX_MIN:
            rows.append(_frame_row(scene, frame, truths, shape))
    if rows:
        max(rows, key=lambda row: row["score"])["best"] = True
    return rows


def _frame_row(scene: Scene, frame: int, truths: Sequence[FrameTruth], shape: ShapeParameters) -> dict[str, Any]:
    own = truths[0]
    height, width = own.visible.shape
    cameras = [scene.camera(view, (width, height)) for view in MASS_PAIR]
    hull = fit_hull(cameras, [truth.visible for truth in truths], shape)
    visible, amodal = encode_masks(np.array([own.visible, own.amodal]))
    return {
        "container_id": scene.container.container_id,
        "seed": scene.seed,
        "frame": frame,
        "score": int(sum(truth.visible.sum() for truth in truths)),
        "best": False,
        "tilt_deg": _tilt_deg(scene, frame, cameras[0]),
        "height": height,
        "width": width,
        "visible": visible,
        "amodal": amodal,
        **_measured(hull, measure_hull(hull, shape), cameras[0]),
    }


def _measured(hull: Hull, dimensions: Dimensions, camera: Camera) -> dict[str, Any]:
    values = {name: getattr(dimensions, name) for name in (*DIMENSIONS, "capacity_ml")}
    scale = mm_per_pixel(camera, hull.centroid_m) if dimensions.ok and hull.centroid_m is not None else None
    return {**values, "mm_per_px": scale, "reason": dimensions.reason}


def _tilt_deg(scene: Scene, frame: int, camera: Camera) -> float:
    """How far the container's axis leans in the image, degrees; positive to the right."""
    base, up = scene.motion.base_m[frame], scene.motion.rotation[frame][:, 2]
    low, high = camera.project(np.array([base, base + up * scene.container.height_mm / 1000]))
    return float(np.degrees(np.arctan2(high[0] - low[0], low[1] - high[1])))
