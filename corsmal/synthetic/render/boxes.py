"""Boxes of cardboard and the pictures printed on them."""

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.geometry import Floats
from corsmal.synthetic.render.kernels import Vector, kernel
from corsmal.synthetic.render.shading import Depth, Image, Mask, Rays, Window, lit, paint, ray, solid_pose
from corsmal.synthetic.render.tracing import INF, at, block_entry
from corsmal.synthetic.scene.containers import DemoContainer

Prints = tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.uint8]]

PIXELS_PER_MM = 2
_TITLES = {7: "CRUNCHY", 8: "Biscuits", 9: "TEA", 14: "Fusilli", 15: "Spaghetti"}
_INKS = {
    7: ((214, 52, 40), (250, 236, 196)),
    8: ((238, 206, 96), (206, 150, 84)),
    9: ((240, 232, 200), (176, 60, 48)),
    14: ((246, 214, 120), (214, 40, 44)),
    15: ((240, 208, 110), (236, 236, 240)),
}


@cache
def box_prints(container: DemoContainer) -> Prints:
    """The pictures on the broad sides, the narrow sides and the lids, (rows, columns, 3) RGB."""
    sizes = (container.width_top_mm, container.depth_mm, container.height_mm)
    width, depth, height = (round(size * PIXELS_PER_MM) for size in sizes)
    front = np.empty((height, width, 3), dtype=np.uint8)
    front[:] = container.colour
    title, (first, second) = _TITLES[container.container_id], _INKS[container.container_id]
    _picture(front, first, second, is_tall=height > 2.5 * width)
    _write(front, title, row=0.24, ink=second if container.container_id != 7 else (255, 255, 255))
    side = np.empty((height, depth, 3), dtype=np.uint8)
    side[:] = tuple(int(value * 0.92) for value in container.colour)
    _small_print(side, first)
    lid = np.empty((depth, width, 3), dtype=np.uint8)
    lid[:] = tuple(int(value * 0.96) for value in container.colour)
    cv2.line(lid, (0, depth // 2), (width, depth // 2), tuple(int(value * 0.6) for value in container.colour), 2)
    return front, side, lid


def _picture(image: Image, first: tuple[int, ...], second: tuple[int, ...], *, is_tall: bool) -> None:
    """A band, a plate and what is on it."""
    height, width = image.shape[:2]
    cv2.rectangle(image, (0, int(0.12 * height)), (width, int(0.32 * height)), first, -1)
    centre = (width // 2, int(0.66 * height))
    axes = (int(0.38 * width), int((0.24 if is_tall else 0.2) * height))
    cv2.ellipse(image, centre, axes, 0, 0, 360, second, -1, cv2.LINE_AA)
    rng = np.random.default_rng(int(image[0, 0, 0]) * 7 + width)
    for _ in range(46):
        angle, far = rng.uniform(0, 2 * np.pi), rng.uniform(0, 0.8)
        place = (int(centre[0] + far * axes[0] * np.cos(angle)), int(centre[1] + far * axes[1] * np.sin(angle)))
        tone = np.clip(np.array((208, 150, 70)) * rng.uniform(0.7, 1.2), 0, 255)
        axes_px = (int(0.05 * width), int(0.025 * width))
        cv2.ellipse(image, place, axes_px, rng.uniform(0, 180), 0, 360, tuple(tone.tolist()), -1, cv2.LINE_AA)
    cv2.rectangle(image, (0, int(0.93 * height)), (width, height), tuple(int(value * 0.8) for value in first), -1)


def _write(image: Image, title: str, *, row: float, ink: tuple[int, ...]) -> None:
    height, width = image.shape[:2]
    scale = 0.84 * width / cv2.getTextSize(title, cv2.FONT_HERSHEY_DUPLEX, 1.0, 2)[0][0]
    thickness = max(2, round(2 * scale))
    text_width, text_height = cv2.getTextSize(title, cv2.FONT_HERSHEY_DUPLEX, scale, thickness)[0]
    place = ((width - text_width) // 2, int(row * height) + text_height // 2)
    cv2.putText(image, title, place, cv2.FONT_HERSHEY_DUPLEX, scale, ink, thickness, cv2.LINE_AA)


def _small_print(image: Image, ink: tuple[int, ...]) -> None:
    height, width = image.shape[:2]
    cv2.rectangle(image, (0, int(0.12 * height)), (width, int(0.32 * height)), ink, -1)
    cv2.rectangle(image, (width // 8, int(0.4 * height)), (width - width // 8, int(0.72 * height)), (236, 236, 230), -1)
    for row in np.linspace(0.43, 0.69, 10):
        start, end = (width // 6, int(row * height)), (width - width // 5, int(row * height))
        cv2.line(image, start, end, (90, 90, 90), 2)


def draw_box(
    image: Image,
    depth: Depth,
    container: DemoContainer,
    *,
    base_m: Floats,
    rotation: Floats,
    rays: Rays,
    light: Floats,
) -> tuple[Mask, Mask]:
    """Draw a box into an image where it is nearer than what is there; arguments and masks as in ``draw_vessel``."""
    visible, amodal = np.zeros(depth.shape, dtype=np.bool_), np.zeros(depth.shape, dtype=np.bool_)
    half = np.array([container.width_top_mm, container.depth_mm, container.height_mm]) / 2000
    centre = base_m + rotation @ np.array([0.0, 0.0, half[2]])
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    window = rays.windows(centre + corners @ rotation.T)
    if window[0] < window[1] and window[2] < window[3]:
        layers, shade = (image, depth, visible, amodal), (solid_pose(centre, rotation, rays), light)
        _draw(layers, window, (half[0], half[1], half[2]), box_prints(container), shade)
    return visible, amodal


@kernel
def _draw(
    layers: tuple[Image, Depth, Mask, Mask], window: Window, half: Vector, prints: Prints, shade: tuple[Floats, Floats]
) -> None:
    image, depth, visible, amodal = layers
    pose, light = shade
    origin = (pose[0, 0], pose[0, 1], pose[0, 2])
    for y in range(window[2], window[3]):
        for x in range(window[0], window[1]):
            direction = ray(pose, (y, x))
            t, axis, sign = block_entry(origin, direction, half)
            if t == INF:
                continue
            amodal[y, x] = True
            if t >= depth[y, x]:
                continue
            visible[y, x] = True
            depth[y, x] = t
            normal = (sign if axis == 0 else 0.0, sign if axis == 1 else 0.0, sign if axis == 2 else 0.0)
            place = at(origin, direction, t)
            u, v, w = place[0] / half[0] * 0.5 + 0.5, place[1] / half[1] * 0.5 + 0.5, 0.5 - place[2] / half[2] * 0.5
            if axis == 1:
                colour = _sample(prints[0], w, u if sign < 0 else 1 - u)
            elif axis == 0:
                colour = _sample(prints[1], w, v if sign > 0 else 1 - v)
            else:
                colour = _sample(prints[2], v, u)
            paint(image, (y, x), colour, lit(pose, normal, light), light)


@kernel
def _sample(picture: Image, row: float, column: float) -> Vector:
    i = min(max(int(row * picture.shape[0]), 0), picture.shape[0] - 1)
    j = min(max(int(column * picture.shape[1]), 0), picture.shape[1] - 1)
    return float(picture[i, j, 0]), float(picture[i, j, 1]), float(picture[i, j, 2])
