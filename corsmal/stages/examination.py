"""Whether a recording's files can be read, and whether its calibration and its detections agree."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from corsmal.dataset import Recording
from corsmal.dataset.findings import Finding
from corsmal.dataset.layout import WORN_VIEW
from corsmal.errors import CorsmalError, FileError
from corsmal.estimation import container_mask
from corsmal.estimation.plausibility import reprojection_miss
from corsmal.geometry import Camera
from corsmal.parameters import PAIRS, SelectionParameters
from corsmal.selection import select_best_frame
from corsmal.shape.cropped import contour_centroid
from corsmal.stages.detections import DetectionSet, load_detections
from corsmal.stages.media_findings import (
    calibration_findings,
    detection_findings,
    offset_findings,
    sound_findings,
    video_findings,
)
from corsmal.store import Store

FRAMES_MAX = 12
"""Frames of a recording that are reprojected: as many more would say the same."""

FRAMES_AT_FIRST = 4
"""Frames that are reprojected where hundreds of recordings are to be examined in less than a minute."""


@dataclass(frozen=True)
class ExamineTask:
    """Examining a recording: of videos and sound the headers, everything else whole.

    The row has ``findings``, one for every file that cannot be used, and ``reprojection``, what
    ``reprojection_error`` says.

    Args:
        cache: folder of the store, for detections that are not beside the videos.
        deep: read the sound whole, decode the videos at both ends, and look for offsets between the views.
    """

    cache: Path
    deep: bool = False

    def __call__(self, recording: Recording) -> dict[str, Any]:
        """The row of one recording."""
        findings: list[Finding] = []
        cameras: dict[str, Camera] = {}
        for name, view in recording.views.items():
            with _noting(findings, "video"):
                findings += video_findings(view)
                if self.deep:
                    with view.video() as video:
                        video[0], video[-1]
            if name != WORN_VIEW and view.calibration_path is not None:
                with _noting(findings, "calibration"):
                    cameras[name] = view.camera()
                    findings += calibration_findings(view)
        with _noting(findings, "sound"):
            findings += sound_findings(recording, deep=self.deep)
        detections = load_detections(recording, store=Store(self.cache))
        findings += detection_findings(recording, detections.notes)
        findings += offset_findings(recording, detections.views) if self.deep else ()
        return {
            "recording_id": recording.id,
            "status": "examined",
            "findings": [finding.of(recording.id) for finding in dict.fromkeys(findings)],
            "reprojection": reprojection_error(
                detections, cameras, frames=FRAMES_MAX if self.deep else FRAMES_AT_FIRST
            ),
            "notes": "",
        }


def reprojection_error(
    detections: DetectionSet, cameras: Mapping[str, Camera], *, frames: int = FRAMES_MAX
) -> float | None:
    """How far the container's triangulated centroid falls from the centroids of its masks, of the image's width.

    One or two hundredths come from the method: the centroids of silhouettes, and of what a hand leaves of them, are not
    quite images of one point. More indicates a calibration of other cameras or detections of different objects, but not
    every such fault: two cameras that see the container from mirrored places can be exchanged unnoticed.

    Returns:
        The largest of the views' distances, the median over up to ``frames`` frames with a container in two views;
        infinite where the rays meet behind a camera; None where there is no such frame.
    """
    seen = {name: view for name, view in detections.views.items() if name in cameras}
    best = next((best for pair in PAIRS if (best := select_best_frame(seen, pair=pair)).ok), None)
    if best is None:
        return None
    qualified = [score.frame for score in best.scores if score.total is not None]
    chosen = np.unique(np.linspace(0, len(qualified) - 1, frames).astype(int))
    errors = []
    for frame in (qualified[index] for index in chosen):
        centroids = {
            name: contour_centroid(
                container_mask(view[frame], centre_rule=best.centre_rule, parameters=SelectionParameters())
            )
            for name, view in seen.items()
            if frame in view
        }
        found = {name: centroid for name, centroid in centroids.items() if centroid is not None}
        if len(found) > 1:
            errors.append(reprojection_miss([cameras[name] for name in found], list(found.values())))
    return float(np.median(errors)) if errors else None


@contextmanager
def _noting(findings: list[Finding], kind: str) -> Iterator[None]:
    """Note the error that the block raises, and continue."""
    try:
        yield
    except FileError as error:
        what, _, advice = error.problem.rpartition("; ")
        findings.append(Finding("error", kind, what or advice, str(error.path), advice=advice if what else ""))
    except CorsmalError as error:
        findings.append(Finding("error", kind, str(error)))
