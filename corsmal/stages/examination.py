"""Whether a recording's files can be read, and whether its calibration and its detections agree."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset import Recording
from corsmal.dataset.layout import WORN_VIEW
from corsmal.errors import CorsmalError
from corsmal.estimation import container_mask
from corsmal.geometry import Camera, triangulate
from corsmal.parameters import PAIRS, SelectionParameters
from corsmal.selection import select_best_frame
from corsmal.shape.circumferences import contour_centroid
from corsmal.stages.detections import DetectionSet, load_detections
from corsmal.store import Store

FRAMES_MAX = 12
"""Frames of a recording that are reprojected: as many more would say the same."""


@dataclass(frozen=True)
class ExamineTask:
    """Examining a recording: every file of it is opened, the videos at both ends.

    The row has ``broken``, a sentence for every file that cannot be used, and ``reprojection``, what
    ``reprojection_error`` says.

    Args:
        cache: folder of the store, for detections that are not beside the videos.
    """

    cache: Path

    def __call__(self, recording: Recording) -> dict[str, Any]:
        """The row of one recording."""
        broken: list[str] = []
        cameras: dict[str, Camera] = {}
        for name, view in recording.views.items():
            with _noting(broken), view.video() as video:
                video[0], video[-1]
            if name != WORN_VIEW and view.calibration_path is not None:
                with _noting(broken):
                    cameras[name] = view.camera()
        if recording.audio_path is not None:
            with _noting(broken):
                recording.audio()
        detections = load_detections(recording, store=Store(self.cache))
        broken += detections.notes
        return {
            "recording_id": recording.id,
            "status": "examined",
            "broken": list(dict.fromkeys(broken)),
            "reprojection": reprojection_error(detections, cameras),
            "notes": "",
        }


def reprojection_error(detections: DetectionSet, cameras: Mapping[str, Camera]) -> float | None:
    """How far the container's triangulated centroid falls from the centroids of its masks, of the image's width.

    One or two hundredths come from the method: the centroids of silhouettes, and of what a hand leaves of them, are not
    quite images of one point. More indicates a calibration of other cameras or detections of different objects, but not
    every such fault: two cameras that see the container from mirrored places can be exchanged unnoticed.

    Returns:
        The largest of the views' distances, the median over up to twelve frames with a container in two views or more;
        infinite where the rays meet behind a camera; None where there is no such frame.
    """
    seen = {name: view for name, view in detections.views.items() if name in cameras}
    best = next((best for pair in PAIRS if (best := select_best_frame(seen, pair=pair)).ok), None)
    if best is None:
        return None
    frames = [score.frame for score in best.scores if score.total is not None]
    chosen = np.unique(np.linspace(0, len(frames) - 1, FRAMES_MAX).astype(int))
    errors = []
    for frame in (frames[index] for index in chosen):
        centroids = {
            name: contour_centroid(
                container_mask(view[frame], centre_rule=best.centre_rule, parameters=SelectionParameters())
            )
            for name, view in seen.items()
            if frame in view
        }
        found = {name: centroid for name, centroid in centroids.items() if centroid is not None}
        if len(found) > 1:
            errors.append(_distance([cameras[name] for name in found], list(found.values())))
    return float(np.median(errors)) if errors else None


def _distance(cameras: list[Camera], centroids: list[NDArray[np.float64]]) -> float:
    """The largest distance between a centroid and the image of the point that they all show, of the image's width."""
    point_m = triangulate(cameras, centroids)
    if not np.isfinite(point_m).all():
        return np.inf
    distances = [
        float(np.linalg.norm(camera.project(point_m[None])[0] - centroid)) / camera.size[0]
        for camera, centroid in zip(cameras, centroids, strict=True)
    ]
    return max(distances) if np.isfinite(distances).all() else np.inf


@contextmanager
def _noting(broken: list[str]) -> Iterator[None]:
    """Note the error that the block raises, and continue."""
    try:
        yield
    except CorsmalError as error:
        broken.append(str(error))
