"""A tiny generated dataset in the dataset's own layout, true to the camera geometry, and the pieces it is made of."""

import itertools
import json
import pickle
from dataclasses import dataclass
from pathlib import Path

import av
import cv2
import numpy as np
import soundfile
from numpy.typing import NDArray
from pycocotools import mask as coco_mask

from corsmal.geometry import Camera

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Profile = tuple[Floats, Floats]
"""Heights (n,) above the base and radii (n,) there, both in mm, of a solid of revolution."""

CALIBRATED_SIZE = (1280, 720)
SIZE = (640, 360)
FRAMES = 12
SAMPLE_RATE_HZ = 44_100
CUP, BOOK, BOTTLE = 47, 84, 44

# centre (m), the point looked at (m), focal length and principal point (px at 1280x720)
_CAMERAS = {
    "view1": ((0.78, 1.28, 0.66), (0.0, 0.0, 0.08), 921.0, (648.0, 361.0)),
    "view2": ((-0.72, 1.32, 0.62), (0.0, 0.0, 0.08), 926.0, (645.0, 358.0)),
    "view3": ((0.05, 0.82, 0.27), (0.0, 0.0, 0.08), 922.0, (640.0, 355.0)),
}


@dataclass(frozen=True)
class TinyContainer:
    """What one generated recording shows: a frustum of a cone standing at ``base_m``, with its filling."""

    container_id: int
    width_bottom_mm: float
    width_top_mm: float
    height_mm: float
    mass_g: float
    base_m: tuple[float, float, float]
    filling_type: int
    filling_level: int
    colour: tuple[int, int, int]

    @property
    def profile(self) -> Profile:
        return np.array([0.0, self.height_mm]), np.array([self.width_bottom_mm, self.width_top_mm]) / 2


CONTAINERS = (
    TinyContainer(1, 61.0, 98.0, 119.0, 10.0, (0.0, 0.0, 0.02), 0, 0, (190, 40, 40)),
    # near the edge of the table: in view3 its centre is outside the middle third of the height
    TinyContainer(4, 64.0, 64.0, 140.0, 86.0, (0.0, 0.25, -0.02), 2, 1, (60, 150, 80)),
    TinyContainer(2, 42.0, 69.0, 72.0, 2.0, (0.02, 0.02, 0.03), 3, 2, (230, 230, 225)),
)
LACKS = {1: ("view2", "audio"), 2: ("detections",)}
"""What the recording of that number does not have."""

_FILLING_DENSITY_G_PER_ML = (0.0, 0.34, 0.82, 1.0)
_LEVEL_FRACTION = (0.0, 0.5, 0.9)
_CONTAINER_NAMES = {1: ("red cup", "cup"), 2: ("small white cup", "cup"), 4: ("green glass", "drinking glass")}


def tiny_cameras(size: tuple[int, int] = SIZE) -> dict[str, Camera]:
    """The three cameras, by view, for images of ``size`` (width, height): one near and frontal, two higher aside."""
    cameras = {}
    for view, (centre, target, focal, principal) in _CAMERAS.items():
        intrinsic = np.array([[focal, 0, principal[0]], [0, focal, principal[1]], [0, 0, 1]])
        forward = np.subtract(target, centre) / np.linalg.norm(np.subtract(target, centre))
        right = np.cross(forward, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        rotation = np.array([right, np.cross(forward, right), forward])
        camera = Camera(intrinsic, rotation, -rotation @ np.array(centre), CALIBRATED_SIZE)
        cameras[view] = camera if size == CALIBRATED_SIZE else camera.scaled(size)
    return cameras


def silhouette(camera: Camera, profile: Profile, centre_m: tuple[float, float, float] | Floats) -> Mask:
    """The pixels whose centre is inside the projection of a solid of revolution with a vertical axis.

    Args:
        camera: the camera that looks at it.
        profile: heights (n,) and radii (n,), mm; between neighbours the solid is a frustum of a cone.
        centre_m: (3,) metres, the point of the axis at which the profile's height is 0.

    Returns:
        (H, W) bool. A frustum is convex, so its silhouette is the convex hull of its two projected circles.
    """
    heights_m, radii_m = (np.asarray(values, dtype=np.float64) / 1000 for values in profile)
    angles = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    unit_circle = np.column_stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])
    circles = [
        camera.project(np.asarray(centre_m) + (0, 0, height) + radius * unit_circle)
        for height, radius in zip(heights_m, radii_m, strict=True)
    ]
    mask = np.zeros(camera.size[::-1], dtype=bool)
    for lower, upper in itertools.pairwise(circles):
        _fill_hull(mask, np.concatenate([lower, upper]))
    return mask


def capacity_ml(profile: Profile) -> float:
    """Volume of a solid of revolution, by frusta of cones."""
    heights, radii = profile
    below, above = radii[:-1], radii[1:]
    return float((np.pi / 3 * np.diff(heights) * (below**2 + below * above + above**2)).sum() / 1000)


def base_in_frame(container: TinyContainer, frame: int) -> Floats:
    """Where the container's base stands in a frame, (3,) metres: it is lifted and comes nearer, 6 mm a frame."""
    return np.array(container.base_m) + frame * np.array([0.0, 0.006, 0.002])


def write_tiny_dataset(root: Path, *, recordings: int = 3, size: tuple[int, int] = SIZE, frames: int = FRAMES) -> Path:
    """Write recordings 000000, 000001, ... under ``root`` and return it.

    Every recording has views 1 to 3 (H.264), calibration, audio, detections and a row of annotation, but for what
    ``LACKS`` names. The detections hold the true silhouette (a cup, score 0.98), in every frame a decoy below the
    score threshold, and in frames 3, 7, 11, ... a second object whose box overlaps the container's.
    """
    cameras = tiny_cameras(size)
    rows = []
    for number in range(recordings):
        container = CONTAINERS[number % len(CONTAINERS)]
        lacks = LACKS.get(number, ())
        name = f"{number:06d}"
        rows.append(annotation_row(number, container))
        if "audio" not in lacks:
            write_audio(root / "audio" / f"{name}.wav", seed=number)
        for view, camera in cameras.items():
            write_calibration(root / view / "calib" / f"{name}.pickle", tiny_cameras(CALIBRATED_SIZE)[view])
            if view in lacks:
                continue
            masks = [silhouette(camera, container.profile, base_in_frame(container, i)) for i in range(frames)]
            write_video(root / view / "rgb" / f"{name}.mp4", [paint(mask, container.colour) for mask in masks])
            if "detections" not in lacks:
                write_json(root / view / "detections" / f"{name}.json", detections_of(masks))
    containers = [{"id": i, "name": name, "type": kind} for i, (name, kind) in _CONTAINER_NAMES.items()]
    write_json(root / "ccm_tiny_annotation.json", {"annotations": rows, "containers": containers})
    return root


def annotation_row(number: int, container: TinyContainer) -> dict[str, float]:
    """The annotation of one recording, with the keys of the dataset's own file."""
    capacity = capacity_ml(container.profile)
    density = _FILLING_DENSITY_G_PER_ML[container.filling_type]
    filling = capacity * density * _LEVEL_FRACTION[container.filling_level]
    return {
        "id": number,
        "container id": container.container_id,
        "scenario": number % 3,
        "background": number % 2,
        "illumination": 0,
        "width at the top": container.width_top_mm,
        "width at the bottom": container.width_bottom_mm,
        "height": container.height_mm,
        "depth": -1.0,
        "container capacity": round(capacity, 3),
        "container mass": container.mass_g,
        "filling type": container.filling_type,
        "filling level": container.filling_level,
        "filling density": density,
        "filling mass": round(filling, 3),
        "object mass": round(container.mass_g + filling, 3),
    }


def detections_of(masks: list[Mask], *, score: float = 0.98) -> list[dict]:
    """COCO results (compressed RLE) for the masks of a view, one list entry per detection, ``image_id`` = frame."""
    results = []
    for frame, mask in enumerate(masks):
        results.append(coco_result(frame, mask, category=CUP, score=score))
        decoy = np.zeros_like(mask)
        decoy[: len(mask) // 4, : mask.shape[1] // 5] = True
        results.append(coco_result(frame, decoy, category=BOTTLE, score=0.3))
        if frame % 4 == 3:
            aside = np.roll(mask, int(mask.any(axis=0).sum()) // 2, axis=1)
            results.append(coco_result(frame, aside & ~mask, category=BOOK, score=0.7))
    return results


def coco_result(frame: int, mask: Mask, *, category: int, score: float) -> dict:
    """One entry of a COCO results file."""
    rle = coco_mask.encode(np.asfortranarray(mask.astype(np.uint8)))
    segmentation = {"size": list(mask.shape), "counts": rle["counts"].decode("ascii")}
    bbox = [float(value) for value in coco_mask.toBbox(rle)]
    return {"image_id": frame, "category_id": category, "bbox": bbox, "score": score, "segmentation": segmentation}


def paint(mask: Mask, colour: tuple[int, int, int]) -> NDArray[np.uint8]:
    """An (H, W, 3) RGB picture: a table under a wall, and the silhouette in one shaded colour."""
    height, width = mask.shape
    image = np.empty((height, width, 3), dtype=np.uint8)
    image[:] = np.linspace((205, 210, 215), (150, 140, 125), height)[:, None]
    shade = 0.75 + 0.25 * np.sin(np.linspace(0, 12 * np.pi, width))
    image[mask] = (np.array(colour) * np.broadcast_to(shade[:, None], (height, width, 1))[mask]).astype(np.uint8)
    return image


def write_video(
    path: Path,
    images: list[NDArray[np.uint8]],
    *,
    codec: str = "libx264",
    gop: int = 12,
    bframes: int = 2,
    pts: list[int] | None = None,
    fps: int = 30,
) -> Path:
    """Write (H, W, 3) RGB images as a video; ``pts`` are presentation times in 1/fps s (default 0, 1, 2, ...)."""
    path.parent.mkdir(parents=True, exist_ok=True)
    options = {"bf": str(bframes), "g": str(gop)} | ({"preset": "ultrafast"} if codec == "libx264" else {})
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=fps, options=options)
        stream.width, stream.height = images[0].shape[1], images[0].shape[0]
        stream.pix_fmt = "yuv420p"
        for index, image in enumerate(images):
            frame = av.VideoFrame.from_ndarray(image, format="rgb24")
            frame.pts = index if pts is None else pts[index]
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def write_calibration(path: Path, camera: Camera) -> Path:
    """Write a camera as the dataset does: a text pickle of a list, rotation under ``rvec``, translation as a column."""
    path.parent.mkdir(parents=True, exist_ok=True)
    extrinsic = {
        "rvec": np.array(camera.rotation),
        "tvec": np.array(camera.translation)[:, None],
        "projMatrix": np.array(camera.projection),
    }
    names = ("ir1", "rgb", "ir2")
    content = [dict.fromkeys(names, np.array(camera.intrinsic)), dict.fromkeys(names, extrinsic), np.array([487, 341])]
    path.write_bytes(pickle.dumps(content, protocol=0).replace(b"numpy._core.", b"numpy.core."))
    return path


def write_audio(path: Path, *, seconds: float = 1.0, channels: int = 8, seed: int = 0) -> Path:
    """Write noise that grows from channel to channel as a 16 bit WAV."""
    path.parent.mkdir(parents=True, exist_ok=True)
    noise = np.random.default_rng(seed).uniform(-1, 1, (round(seconds * SAMPLE_RATE_HZ), channels))
    soundfile.write(path, noise * np.linspace(0.02, 0.2, channels), SAMPLE_RATE_HZ, subtype="PCM_16")
    return path


def write_json(path: Path, content: object) -> Path:
    """Write JSON, making the folder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def _fill_hull(mask: Mask, points_px: Floats) -> None:
    """Set the pixels whose centre is inside the convex hull of the points, one interval per row of the image."""
    start = cv2.convexHull(points_px.astype(np.float32))[:, 0].astype(np.float64)
    end = np.roll(start, -1, axis=0)
    top, bottom = max(0, np.ceil(start[:, 1].min())), min(len(mask) - 1, np.floor(start[:, 1].max()))
    rows = np.arange(int(top), int(bottom) + 1)[:, None]
    rise = end[:, 1] - start[:, 1]
    crossed = ((rows - start[:, 1]) * (rows - end[:, 1]) <= 0) & (rise != 0)
    x = start[:, 0] + (rows - start[:, 1]) * (end[:, 0] - start[:, 0]) / np.where(rise == 0, 1, rise)
    left = np.where(crossed, x, np.inf).min(axis=1, keepdims=True)
    right = np.where(crossed, x, -np.inf).max(axis=1, keepdims=True)
    columns = np.arange(mask.shape[1])
    mask[rows[:, 0]] |= (columns >= left) & (columns <= right)
