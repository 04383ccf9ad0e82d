"""Detections as files of annotation tools: to be corrected there, and read again.

Masks become polygons without holes. COCO results keep the masks as they are.
"""

import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.dataset import Recording
from corsmal.detection import Detections, ViewDetections
from corsmal.detection.coco_classes import CLASS_NAMES
from corsmal.errors import check_choice
from corsmal.files import writing

AnnotationForm = Literal["coco", "cvat", "label-studio"]
ANNOTATION_FORMS: tuple[AnnotationForm, ...] = get_args(AnnotationForm)
"""``coco``: results, as beside a dataset's videos; ``cvat``: COCO instances with named pictures and classes;
``label-studio``: tasks with predictions."""

FOLDERS = {"coco": "detections", "cvat": "cvat", "label-studio": "label-studio"}

Polygon = NDArray[np.float64]


def export_detections(
    recording: Recording,
    detections: Mapping[str, ViewDetections],
    folder: Path,
    *,
    form: AnnotationForm = "coco",
    with_frames: bool = False,
) -> list[Path]:
    """Write a recording's detections, a file for each view: ``VIEW/detections/ID.json``, or after the form's name.

    Args:
        recording: whose they are.
        detections: by view, such as ``load_detections`` gives.
        folder: where the views' folders are, or are to be.
        form: of the files.
        with_frames: also write the inspected frames, as ``VIEW/frames/ID/frame_000012.jpg``.

    Returns:
        The files of detections.

    Raises:
        ArgumentError: there is no such form.
        FileError: a file cannot be written, or a video not be read.
    """
    check_choice("form", form, ANNOTATION_FORMS)
    content: Callable[[ViewDetections], Any] = {"coco": _results, "cvat": _instances, "label-studio": _tasks}[form]
    written = []
    for name, view in detections.items():
        path = folder / name / FOLDERS[form] / f"{recording.id}.json"
        path.parent.mkdir(parents=True, exist_ok=True)
        with writing(path, advice="choose another folder") as part:
            part.write_text(json.dumps(content(view)), encoding="utf-8")
        written.append(path)
        if with_frames:
            _write_frames(recording, name, view, folder / name / "frames" / recording.id)
    return written


def frame_name(frame: int) -> str:
    """The picture of a frame, as annotation tools name those of a video."""
    return f"frame_{frame:06d}.jpg"


def polygons(mask: NDArray[np.bool_]) -> list[Polygon]:
    """The outer outlines of an (H, W) mask, (n, 2) each, a quarter of a pixel inside its edge.

    Coordinates are those of COCO's polygons: the first pixel reaches from 0 to 1. The outlines are those of the mask
    drawn twice as large, because that of a single line of pixels would have no area.
    """
    doubled = cv2.resize(mask.view(np.uint8), None, fx=2, fy=2, interpolation=cv2.INTER_NEAREST)
    found, _ = cv2.findContours(doubled, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    return [(contour[:, 0] + 0.5) / 2 for contour in found]


def _found(view: ViewDetections) -> Iterator[tuple[int, Detections, int]]:
    """Every detection: its frame, the frame's detections, and its place among them."""
    for frame, detections in view.items():
        for index in range(len(detections)):
            yield frame, detections, index


def _results(view: ViewDetections) -> list[dict[str, Any]]:
    return [entry for frame, detections in view.items() for entry in detections.to_coco(frame)]


def _instances(view: ViewDetections) -> dict[str, Any]:
    """What CVAT, FiftyOne and Roboflow call COCO: pictures by number and name, named classes, polygons."""
    height, width = view.size
    annotations: list[dict[str, Any]] = []
    for frame, detections, index in _found(view):
        left, top, right, bottom = detections.boxes[index].tolist()
        annotations.append(
            {
                "id": len(annotations) + 1,
                "image_id": frame + 1,
                "category_id": int(detections.labels[index]),
                "score": float(detections.scores[index]),
                "bbox": [left, top, right - left, bottom - top],
                "area": int(detections.mask_areas[index]),
                "segmentation": [outline.ravel().tolist() for outline in polygons(detections.mask(index))],
                "iscrowd": 0,
            }
        )
    used = sorted({entry["category_id"] for entry in annotations})
    return {
        "images": [
            {"id": frame + 1, "file_name": frame_name(frame), "width": width, "height": height} for frame in view
        ],
        "categories": [{"id": number, "name": CLASS_NAMES.get(number, str(number))} for number in used],
        "annotations": annotations,
    }


def _tasks(view: ViewDetections) -> list[dict[str, Any]]:
    """A task of Label Studio for each frame, with its detections as predictions: polygons in % of the picture."""
    height, width = view.size
    percent = np.array([100 / width, 100 / height])
    shown: dict[int, list[dict[str, Any]]] = {frame: [] for frame in view}
    for frame, detections, index in _found(view):
        name = CLASS_NAMES.get(int(detections.labels[index]), str(detections.labels[index]))
        for outline in polygons(detections.mask(index)):
            shown[frame].append(
                {
                    "from_name": "label",
                    "to_name": "image",
                    "type": "polygonlabels",
                    "original_width": width,
                    "original_height": height,
                    "score": float(detections.scores[index]),
                    "value": {"points": (outline * percent).tolist(), "polygonlabels": [name], "closed": True},
                }
            )
    return [
        {"data": {"image": frame_name(frame)}, "predictions": [{"model_version": view.source, "result": result}]}
        for frame, result in shown.items()
    ]


def frame_jpeg(image: NDArray[np.uint8]) -> bytes:
    """An (H, W, 3) RGB picture as JPEG."""
    return bytes(cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 90])[1])


def _write_frames(recording: Recording, name: str, view: ViewDetections, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with recording.video(name) as video:
        for frame in view:
            with writing(folder / frame_name(frame), advice="choose another folder") as part:
                part.write_bytes(frame_jpeg(video[frame]))
