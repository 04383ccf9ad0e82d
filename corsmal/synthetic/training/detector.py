"""Training the demo's detector on rendered frames."""

import os
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import lightning
import torch
from lightning.pytorch.callbacks import EMAWeightAveraging, ModelCheckpoint
from lightning.pytorch.loggers import CSVLogger
from torch import Tensor
from torch.utils.data import DataLoader
from torchvision.models.detection import MaskRCNN

from corsmal.checkpoints import quiet_lightning, read_checkpoint
from corsmal.detection.small import SmallMaskRCNN, read_detector, save_detector
from corsmal.engines.lifeline import end_with
from corsmal.errors import FileError
from corsmal.synthetic.training.frames import DetectorTraining, RenderedFrames, Target


class DetectorModule(lightning.LightningModule):
    """The network with its losses and its optimiser."""

    def __init__(self, training: DetectorTraining) -> None:
        super().__init__()
        self._training = training
        self.network = SmallMaskRCNN(training.network).to(memory_format=torch.channels_last)
        self.network.transform._skip_resize = True  # windows are not to be enlarged

    def training_step(self, batch: tuple[list[Tensor], list[Target]]) -> Tensor:
        """The sum of Mask R-CNN's five losses."""
        losses: dict[str, Tensor] = self.network(*batch)
        self.log_dict({name: loss.detach() for name, loss in losses.items()}, batch_size=len(batch[0]))
        return torch.stack(list(losses.values())).sum()

    def on_before_optimizer_step(self, optimizer: torch.optim.Optimizer) -> None:
        """Leave out a step whose gradients are not finite: one of them would spoil all weights."""
        if not all(torch.isfinite(weights.grad).all() for weights in self.parameters() if weights.grad is not None):
            optimizer.zero_grad(set_to_none=True)

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
    """Train the demo's detector, or resume an interrupted run in the same folder.

    Args:
        folder: gets checkpoints, ``metrics.csv`` and the weights.
        training: its settings.
        init: weights to begin with, as ``save_detector`` writes them; default: random ones.

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
    begun = read_checkpoint(last)
    frames = RenderedFrames(training, start=0 if begun is None else begun["global_step"])
    module = DetectorModule(training)
    if init is not None:
        try:
            begin_with(module.network, read_detector(init).state_dict())
        except RuntimeError as error:
            raise FileError(
                init, "holds the weights of another network, which are no beginning for this one"
            ) from error
    lifeline = os.pipe()
    loader = DataLoader(
        frames,
        batch_size=None,
        num_workers=1,
        collate_fn=_collated,
        prefetch_factor=4,
        worker_init_fn=partial(_begin_to_render, lifeline),
    )
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
    try:
        with quiet_lightning():
            trainer.fit(module, loader, ckpt_path=last if begun else None, weights_only=True)
    finally:
        for end in lifeline:
            os.close(end)
    path = folder / "detector.safetensors"
    save_detector(path, module.network)
    return path


def begin_with(network: MaskRCNN, state: Mapping[str, Tensor]) -> None:
    """Take over weights; a network with more classes keeps its own for those that the others lack.

    Raises:
        RuntimeError: it is another network in more than the number of classes.
    """
    whole = network.state_dict()
    for name, value in state.items():
        if name in whole and value.ndim and value.shape[0] < whole[name].shape[0]:
            whole[name] = torch.cat([value, whole[name][len(value) :]])
        else:
            whole[name] = value
    network.load_state_dict(whole)


def _begin_to_render(lifeline: tuple[int, int], _number: int) -> None:
    """The process that renders ends with this one; it has a copy of the end that only this one may hold."""
    reader, writer = lifeline
    os.close(writer)
    end_with(reader)


def _collated(samples: list[tuple[Tensor, Target]]) -> tuple[list[Tensor], list[Target]]:
    return [image for image, _ in samples], [target for _, target in samples]
