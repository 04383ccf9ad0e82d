"""Training the demo's detector on rendered frames: other seeds, looks, lights and cameras than the demo's own."""

import pickle
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count, islice
from pathlib import Path
from typing import Any

import cv2
import lightning
import numpy as np
import torch
from lightning.pytorch.callbacks import EMAWeightAveraging, ModelCheckpoint
from lightning.pytorch.loggers import CSVLogger
from numpy.typing import NDArray
from torch import Tensor
from torch.utils.data import DataLoader, IterableDataset

from corsmal.demo.rendering import render_frame
from corsmal.demo.scene import VIEWS, training_scene
from corsmal.detection.small import SmallMaskRCNNConfig, read_weights, save_weights, small_mask_rcnn
from corsmal.errors import FileError

Sample = tuple[NDArray[np.uint8], NDArray[np.bool_], int]
Target = dict[str, Tensor]

FRAMES_PER_SCENE = 6
VISIBLE_PX_MIN, VISIBLE_SHARE_MIN = 24, 0.15
"""A container of which less can be seen is not asked for."""


@dataclass(frozen=True)
class DetectorTraining:
    """How the demo's detector is trained.

    Args:
        steps: optimiser steps.
        batch: frames per step; half of them are new, half seen before.
        crop: (width, height) of the windows around the container that most steps train on; the others see whole frames.
        whole: share of the steps that see whole frames.
        rate: highest learning rate of AdamW, reached after ``warm_up`` steps and lowered to zero by a cosine.
        warm_up: steps.
        weight_decay: of AdamW.
        replay: how many frames are kept to be seen again.
        seed: of the scenes.
    """

    steps: int = 4000
    batch: int = 8
    crop: tuple[int, int] = (320, 224)
    whole: float = 0.25
    rate: float = 1.5e-3
    warm_up: int = 200
    weight_decay: float = 1e-4
    replay: int = 1200
    seed: int = 0


class RenderedFrames(IterableDataset[list[tuple[Tensor, Target]]]):
    """Endless batches of frames with their targets, half new and half seen before, flipped and coloured at random.

    Args:
        training: the seed of the scenes, the size of batches and windows, how many frames are kept.
        start: how many batches were drawn before: a run that goes on sees other scenes.
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
                batch = [cropped(sample, settings.crop, rng) for sample in batch]
            yield [as_target(*sample) for sample in batch]

    def _samples(self, rng: np.random.Generator) -> Iterator[Sample]:
        settings = self._training
        seen: deque[Sample] = deque(maxlen=settings.replay)
        for index in count(self._start * settings.batch):
            scene = training_scene(settings.seed * 10**9 + index)
            for _ in range(FRAMES_PER_SCENE):
                view, frame = VIEWS[rng.integers(len(VIEWS))], int(rng.integers(scene.frames))
                truth = render_frame(scene, view, frame)
                enough = truth.visible.sum() >= max(VISIBLE_PX_MIN, VISIBLE_SHARE_MIN * truth.amodal.sum())
                seen.append((truth.image, truth.visible & enough, scene.container.label))
                yield seen[-1]
                yield seen[rng.integers(len(seen))]


def augmented(sample: Sample, rng: np.random.Generator) -> Sample:
    """A frame mirrored at random, with other contrast, brightness and colour, and compressed as videos are."""
    image, mask, label = sample
    if rng.random() < 0.5:
        image, mask = image[:, ::-1], mask[:, ::-1]
    gain = rng.uniform(0.75, 1.3) * rng.uniform(0.92, 1.08, 3)
    shifted = np.clip(image * gain + rng.uniform(-25, 25), 0, 255).astype(np.uint8)
    quality = int(rng.integers(40, 96))
    compressed = cv2.imencode(".jpg", shifted, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    return np.asarray(cv2.imdecode(compressed, cv2.IMREAD_COLOR), np.uint8), np.ascontiguousarray(mask), label


def cropped(sample: Sample, size: tuple[int, int], rng: np.random.Generator) -> Sample:
    """A window of (width, height) that holds the container's middle somewhere; anywhere, where there is none."""
    image, mask, label = sample
    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    corner = []
    for middle, side, whole in ((x + width // 2, size[0], image.shape[1]), (y + height // 2, size[1], image.shape[0])):
        low, high = (middle - 3 * side // 4, middle - side // 4) if width else (0, whole - side)
        corner.append(int(np.clip(rng.integers(low, high + 1), 0, whole - side)))
    window = np.s_[corner[1] : corner[1] + size[1], corner[0] : corner[0] + size[0]]
    return image[window], np.ascontiguousarray(mask[window]), label


def as_target(image: NDArray[np.uint8], mask: NDArray[np.bool_], label: int) -> tuple[Tensor, Target]:
    """A (3, H, W) image in 0..1 and torchvision's target; no object where the mask is empty."""
    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    boxes = torch.tensor([[x, y, x + width, y + height]] if width and height else [], dtype=torch.float32)
    objects = len(boxes)
    target = {
        "boxes": boxes.reshape(-1, 4),
        "labels": torch.full((objects,), SmallMaskRCNNConfig().labels.index(label) + 1),
        "masks": torch.from_numpy(mask[None].astype(np.uint8))[:objects],
    }
    return torch.from_numpy(np.ascontiguousarray(image)).permute(2, 0, 1) / 255, target


class DetectorModule(lightning.LightningModule):
    """The network with its losses and its optimiser."""

    def __init__(self, training: DetectorTraining) -> None:
        super().__init__()
        self._training = training
        self.network = small_mask_rcnn().to(memory_format=torch.channels_last)
        self.network.transform._skip_resize = True  # windows are not to be enlarged

    def training_step(self, batch: tuple[list[Tensor], list[Target]]) -> Tensor:
        """The sum of Mask R-CNN's five losses."""
        losses: dict[str, Tensor] = self.network(*batch)
        self.log_dict({name: loss.detach() for name, loss in losses.items()}, batch_size=len(batch[0]))
        return torch.stack(list(losses.values())).sum()

    def configure_optimizers(self) -> Any:
        """AdamW, warmed up and lowered by a cosine."""
        settings = self._training
        optimiser = torch.optim.AdamW(self.parameters(), settings.rate, weight_decay=settings.weight_decay)
        schedule = torch.optim.lr_scheduler.SequentialLR(
            optimiser,
            [
                torch.optim.lr_scheduler.LinearLR(optimiser, 0.05, 1.0, settings.warm_up),
                torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, max(1, settings.steps - settings.warm_up)),
            ],
            [settings.warm_up],
        )
        return {"optimizer": optimiser, "lr_scheduler": {"scheduler": schedule, "interval": "step"}}


def train_detector(folder: Path, training: DetectorTraining | None = None, *, init: Path | None = None) -> Path:
    """Train the demo's detector, or go on where a run in the same folder was stopped.

    Args:
        folder: gets checkpoints, ``metrics.csv`` and the weights.
        training: its settings.
        init: weights to begin with, as ``save_weights`` writes them; default: random ones.

    Returns:
        The file with the weights, averaged over the last steps.

    Raises:
        FileError: the folder cannot be written, or its checkpoint or the weights to begin with are broken.
    """
    training = training or DetectorTraining()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(folder, f"cannot be written ({error.strerror}); choose another folder") from error
    last = folder / "checkpoints" / "last.ckpt"
    frames = RenderedFrames(training, start=_steps_done(last))
    module = DetectorModule(training)
    if init is not None:
        module.network.load_state_dict(read_weights(init)[1])
    loader = DataLoader(frames, batch_size=None, num_workers=1, collate_fn=_collated, prefetch_factor=4)
    trainer = lightning.Trainer(
        max_steps=training.steps,
        precision="bf16-mixed",
        gradient_clip_val=5.0,
        logger=CSVLogger(folder, name="", version="log"),
        log_every_n_steps=20,
        callbacks=[
            EMAWeightAveraging(decay=0.998, use_buffers=True),
            ModelCheckpoint(folder / "checkpoints", save_last=True, save_top_k=0, every_n_train_steps=100),
        ],
        enable_model_summary=False,
    )
    trainer.fit(module, loader, ckpt_path=last if last.exists() else None, weights_only=True)
    path = folder / "detector.safetensors"
    save_weights(path, module.network, SmallMaskRCNNConfig())
    return path


def _steps_done(checkpoint: Path) -> int:
    try:
        return int(torch.load(checkpoint, map_location="cpu", weights_only=True)["global_step"])
    except FileNotFoundError:
        return 0
    except (OSError, RuntimeError, EOFError, LookupError, TypeError, ValueError, pickle.UnpicklingError) as error:
        raise FileError(checkpoint, "is no checkpoint of this training; delete it to begin again") from error


def _collated(samples: list[tuple[Tensor, Target]]) -> tuple[list[Tensor], list[Target]]:
    return [image for image, _ in samples], [target for _, target in samples]
