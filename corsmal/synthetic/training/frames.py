"""Frames for training the demo's detector: other seeds, looks, lights and cameras than the demo's own."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count, islice

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.utils.data import IterableDataset

from corsmal.detection.small import SmallMaskRCNNConfig
from corsmal.synthetic.render.frame import render_frame
from corsmal.synthetic.scene.cameras import VIEWS
from corsmal.synthetic.scene.scene import training_scene

Sample = tuple[NDArray[np.uint8], NDArray[np.uint8], int]
"""An image, its pixels' objects (0, ``CONTAINER`` or ``JUG``), and the container's COCO number."""

Target = dict[str, Tensor]
CONTAINER, JUG = 1, 2
NETWORK = SmallMaskRCNNConfig(mask_side=56, mask_scale=448, unreported=1)
"""Masks fine enough for the stems of glasses, and a class for the jug, which looks like a cup."""

FRAMES_PER_SCENE = 6
VISIBLE_PX_MIN, VISIBLE_SHARE_MIN = 24, 0.15
"""A container of which less can be seen is no target."""


@dataclass(frozen=True)
class DetectorTraining:
    """How the demo's detector is trained.

    Args:
        batch: frames per step; half of them are new, half seen before.
        crop: (width, height) of the windows around the container that most steps train on; the others see whole frames.
        whole: share of the steps that see whole frames.
        jug: share of the windows around the jug, where there is one.
        network: sizes of the network; the jug is the first of its unreported classes, where it has any.
        rate: highest learning rate of AdamW, reached after ``warm_up`` steps and lowered to zero by a cosine.
        replay: how many frames are kept to be seen again.
        seed: of the scenes.
    """

    steps: int = 4000
    batch: int = 8
    crop: tuple[int, int] = (320, 224)
    whole: float = 0.25
    jug: float = 0.3
    network: SmallMaskRCNNConfig = NETWORK
    rate: float = 1.5e-3
    warm_up: int = 200
    weight_decay: float = 1e-4
    replay: int = 1200
    seed: int = 0


class RenderedFrames(IterableDataset[list[tuple[Tensor, Target]]]):
    """Endless batches of frames with their targets, half new and half seen before, flipped and coloured at random.

    ``start`` says how many batches were drawn before: a resumed run sees other scenes.
    """

    def __init__(self, training: DetectorTraining, *, start: int = 0) -> None:
        super().__init__()
        self._training, self._start = training, start

    def __iter__(self) -> Iterator[list[tuple[Tensor, Target]]]:
        settings = self._training
        rng = np.random.default_rng([settings.seed, self._start])
        samples = self._samples(rng)
        while True:
            batch = [augmented(sample, rng) for sample in islice(samples, settings.batch)]
            if rng.random() >= settings.whole:
                batch = [cropped(sample, settings.crop, rng, jug=settings.jug) for sample in batch]
            yield [as_target(*sample, network=settings.network) for sample in batch]

    def _samples(self, rng: np.random.Generator) -> Iterator[Sample]:
        settings = self._training
        seen: deque[Sample] = deque(maxlen=settings.replay)
        for index in count(self._start * settings.batch):
            scene = training_scene(settings.seed * 10**9 + index)
            for _ in range(FRAMES_PER_SCENE):
                view, frame = VIEWS[rng.integers(len(VIEWS))], int(rng.integers(scene.frames))
                truth = render_frame(scene, view, frame)
                enough = truth.visible.sum() >= max(VISIBLE_PX_MIN, VISIBLE_SHARE_MIN * truth.amodal.sum())
                objects = np.where(truth.visible & enough, CONTAINER, np.where(truth.jug, JUG, 0)).astype(np.uint8)
                seen.append((truth.image, objects, scene.container.label))
                yield seen[-1]
                yield seen[rng.integers(len(seen))]


def augmented(sample: Sample, rng: np.random.Generator) -> Sample:
    """A frame mirrored at random, with other contrast, brightness and colour, and compressed as videos are."""
    image, objects, label = sample
    if rng.random() < 0.5:
        image, objects = image[:, ::-1], objects[:, ::-1]
    gain = rng.uniform(0.75, 1.3) * rng.uniform(0.92, 1.08, 3)
    shifted = np.clip(image * gain + rng.uniform(-25, 25), 0, 255).astype(np.uint8)
    quality = int(rng.integers(40, 96))
    compressed = cv2.imencode(".jpg", shifted, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    return np.asarray(cv2.imdecode(compressed, cv2.IMREAD_COLOR), np.uint8), np.ascontiguousarray(objects), label


def cropped(sample: Sample, size: tuple[int, int], rng: np.random.Generator, *, jug: float = 0.0) -> Sample:
    """A window of (width, height) around the container, at random; anywhere, where there is none.

    With probability ``jug`` it lies around the jug instead, where there is one.
    """
    image, objects, label = sample
    wanted = JUG if rng.random() < jug and (objects == JUG).any() else CONTAINER
    x, y, width, height = cv2.boundingRect((objects == wanted).view(np.uint8))
    corner = []
    for middle, side, whole in ((x + width // 2, size[0], image.shape[1]), (y + height // 2, size[1], image.shape[0])):
        low, high = (middle - 3 * side // 4, middle - side // 4) if width else (0, whole - side)
        corner.append(int(np.clip(rng.integers(low, high + 1), 0, whole - side)))
    window = np.s_[corner[1] : corner[1] + size[1], corner[0] : corner[0] + size[0]]
    return image[window], np.ascontiguousarray(objects[window]), label


def as_target(
    image: NDArray[np.uint8], objects: NDArray[np.uint8], label: int, *, network: SmallMaskRCNNConfig
) -> tuple[Tensor, Target]:
    """A (3, H, W) image in 0..1 and its target: the container, and the jug where the network has a class for it."""
    classes = {CONTAINER: network.labels.index(label) + 1}
    if network.unreported:
        classes[JUG] = len(network.labels) + 1
    masks = {value: objects == value for value in classes}
    shown = {value: mask for value, mask in masks.items() if mask.sum() >= VISIBLE_PX_MIN}
    corners = [cv2.boundingRect(mask.view(np.uint8)) for mask in shown.values()]
    boxes = torch.tensor([[x, y, x + width, y + height] for x, y, width, height in corners], dtype=torch.float32)
    target = {
        "boxes": boxes.reshape(-1, 4),
        "labels": torch.tensor([classes[value] for value in shown], dtype=torch.int64),
        "masks": torch.from_numpy(np.array(list(shown.values()), np.uint8).reshape(-1, *objects.shape)),
    }
    return torch.from_numpy(np.ascontiguousarray(image)).permute(2, 0, 1) / 255, target
