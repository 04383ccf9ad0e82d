"""A frame with its detections drawn on it."""

import base64

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.detection import Detections, Filtered
from corsmal.errors import ArgumentError
from corsmal.figures.style import CONTAINER, DROPPED, TRUTH, VIEW_COLOURS, rgb
from corsmal.parameters import CONTAINER_CLASSES

Image = NDArray[np.uint8]

FILL = 0.45
FILL_DROPPED = 0.18


def draw_detections(image: Image, detections: Detections, filtered: Filtered) -> Image:
    """Boxes, masks and scores over a frame: the container strong, what else was kept plain, the rest dimmed.

    Args:
        image: (H, W, 3) uint8 RGB.
        detections: of this frame, masks of the image's size.
        filtered: which of them were kept, and in which order.

    Returns:
        A new (H, W, 3) uint8 RGB image. Numbers at the boxes are the detections' positions, starting from 1.
    """
    if image.shape[:2] != tuple(detections.size):
        raise ArgumentError(f"image must be of the masks' size {tuple(detections.size)}, got {image.shape[:2]}")
    picture = image.copy()
    kept = [int(index) for index in filtered.kept]
    dropped = [index for index in range(len(detections)) if index not in kept]
    for index in [*dropped, *kept[::-1]]:
        strong = index == filtered.container
        colour = rgb(CONTAINER if strong else VIEW_COLOURS["view1"] if index in kept else TRUTH)
        paint_mask(picture, detections.mask(index), rgb_colour=colour, opacity=FILL if index in kept else FILL_DROPPED)
        _draw_box(picture, detections.boxes[index], rgb(DROPPED) if index in dropped else colour, 3 if strong else 1)
        _label(picture, f"{index + 1}: {detections.scores[index]:.2f}", detections.boxes[index], colour)
    return picture


def paint_mask(picture: Image, mask: NDArray[np.bool_], *, rgb_colour: tuple[int, int, int], opacity: float) -> None:
    """Tint the pixels of an (H, W) bool mask in an (H, W, 3) picture, in place, and draw its outlines."""
    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    part, inside = picture[y : y + height, x : x + width], mask[y : y + height, x : x + width]
    filled = np.ascontiguousarray(inside, np.uint8)
    if width:
        tinted = (1 - opacity) * np.arange(256)[:, None] + opacity * np.array(rgb_colour)  # (256, 3), by old value
        cv2.copyTo(cv2.LUT(np.ascontiguousarray(part), tinted.astype(np.uint8)[None]), filled, part)
    contours, _ = cv2.findContours(filled, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE, offset=(x, y))
    cv2.drawContours(picture, contours, -1, rgb_colour, 1, cv2.LINE_AA)


def jpeg(image: Image, *, quality: int = 85, width: int | None = None) -> bytes:
    """An (H, W, 3) RGB image as JPEG bytes, made smaller to ``width`` pixels if it is wider."""
    if width is not None and image.shape[1] > width:
        size = (width, round(image.shape[0] * width / image.shape[1]))
        image = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    return bytes(cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])[1])


def jpeg_uri(image: Image) -> str:
    """An (H, W, 3) RGB image as a JPEG in a ``data:`` address."""
    return "data:image/jpeg;base64," + base64.b64encode(jpeg(image, quality=92)).decode("ascii")


def class_name(label: int) -> str:
    """The name of a COCO class that counts as a container, else its number."""
    return CONTAINER_CLASSES.get(label, f"class {label}")


def _draw_box(picture: Image, box: NDArray[np.float64], colour: tuple[int, int, int], thickness: int) -> None:
    x1, y1, x2, y2 = np.rint(box).astype(int).tolist()
    cv2.rectangle(picture, (x1, y1), (x2, y2), colour, thickness, cv2.LINE_AA)


def _label(picture: Image, text: str, box: NDArray[np.float64], colour: tuple[int, int, int]) -> None:
    scale = picture.shape[1] / 1280
    (width, height), baseline = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, 0.8 * scale, 2)
    x = int(np.clip(box[0], 0, max(0, picture.shape[1] - width)))
    y = int(max(height + baseline, box[1] - 4))
    cv2.rectangle(picture, (x, y - height - baseline), (x + width, y + baseline // 2), (20, 20, 24), -1)
    cv2.putText(picture, text, (x, y - baseline // 2), cv2.FONT_HERSHEY_SIMPLEX, 0.8 * scale, colour, 2, cv2.LINE_AA)
