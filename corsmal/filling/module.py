"""One network with its passes, its losses and its optimiser, for Lightning (paper 2 and 4.2)."""

from collections.abc import Sequence
from typing import Any

import lightning
import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from corsmal.filling.network import build_model
from corsmal.filling.pooled import PooledModel, condensed
from corsmal.filling.recipe import FillingTraining
from corsmal.filling.samples import Batch, Batches, FillingSample

STEPS, STEP = (0.5, 0.75), 0.1
"""After these shares of the epochs the rate is lowered in steps, each to this share of what it was."""


class FillingModule(lightning.LightningModule):
    """The network number ``index`` of a training with its passes, its losses and its optimiser.

    All that is drawn follows from ``seed``, the index and the epoch.
    """

    def __init__(
        self,
        training: FillingTraining,
        index: int,
        samples: Sequence[FillingSample],
        validation: Sequence[FillingSample],
        *,
        seed: int,
    ) -> None:
        super().__init__()
        self.network = build_model(training.networks[index])
        self.network.learn_statistics([sample.features for sample in samples])
        self._training, self._index, self._seed = training, index, seed
        if isinstance(self.network, PooledModel):
            samples, validation = condensed(samples), condensed(validation)
        self._samples, self._validation = samples, validation

    def train_dataloader(self) -> Batches:
        """The passes of the epoch; called in every epoch."""
        rng = np.random.default_rng([self._seed, self._index, self.current_epoch])
        return Batches(self._samples, size=self._training.batch, tasks=self._training.tasks, rng=rng)

    def val_dataloader(self) -> Batches:
        """Whole recordings in their order."""
        return Batches(self._validation, size=self._training.batch, tasks=("both",), rng=None)

    def on_train_epoch_start(self) -> None:
        """Dropout depends on the epoch only, so that a resumed run draws what it would have drawn."""
        torch.manual_seed(stream(self._seed, self._index, self.current_epoch))

    def training_step(self, batch: Batch) -> Tensor:
        """The loss of the batch's task; the other task's head is fixed."""
        self.network.level_head.requires_grad_(batch.task != "type")
        self.network.type_head.requires_grad_(batch.task != "level")
        losses = {task: loss for task, loss in self._losses(batch).items() if batch.task in (task, "both")}
        for task, loss in losses.items():
            self.log(f"{task}_loss", loss, on_step=False, on_epoch=True, batch_size=len(batch.types))
        return torch.stack(list(losses.values())).sum()

    def validation_step(self, batch: Batch) -> None:
        """Both losses, their means over the recordings logged."""
        for task, loss in self._losses(batch).items():
            self.log(f"validation_{task}_loss", loss, batch_size=len(batch.types))

    def _losses(self, batch: Batch) -> dict[str, Tensor]:
        """The mean cross-entropies over the batch's recordings; for sight see ``PooledModel.losses``."""
        if isinstance(self.network, PooledModel):
            return self.network.losses(batch)
        types, levels = self.network(batch.features, batch.mask)
        return {
            "level": functional.cross_entropy(levels, batch.levels),
            "type": functional.cross_entropy(types, batch.types),
        }

    def configure_optimizers(self) -> Any:
        """Over everything; what gets no gradient in a pass is not changed by it."""
        settings, parameters = self._training, self.network.parameters()
        rate, decay = settings.rate, settings.weight_decay
        optimiser = (
            torch.optim.AdamW(parameters, rate, weight_decay=decay)
            if settings.optimiser == "adamw"
            else torch.optim.SGD(parameters, rate, momentum=settings.momentum, weight_decay=decay)
        )
        if settings.schedule == "constant":
            return optimiser
        steps = [int(share * settings.epochs) for share in STEPS]
        schedule: torch.optim.lr_scheduler.LRScheduler = (
            torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, settings.epochs)
            if settings.schedule == "cosine"
            else torch.optim.lr_scheduler.MultiStepLR(optimiser, steps, gamma=STEP)
        )
        return {"optimizer": optimiser, "lr_scheduler": schedule}


def stream(*numbers: int) -> int:
    """A seed of its own for every combination of numbers."""
    return int(np.random.SeedSequence(numbers).generate_state(1)[0])
