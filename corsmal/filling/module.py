"""One network with its passes, its losses and its optimiser, for Lightning (paper 2 and 4.2)."""

from collections.abc import Sequence
from typing import Any

import lightning
import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from corsmal.filling.network import build_model
from corsmal.filling.recipe import FillingTraining
from corsmal.filling.samples import Batch, Batches, FillingSample


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
        """The mean cross-entropies over the batch's recordings."""
        types, levels = self.network(batch.features, batch.mask)
        return {
            "level": functional.cross_entropy(levels, batch.levels),
            "type": functional.cross_entropy(types, batch.types),
        }

    def configure_optimizers(self) -> Any:
        """AdamW over everything; what gets no gradient in a pass is not changed by it."""
        settings = self._training
        optimiser = torch.optim.AdamW(self.network.parameters(), settings.rate, weight_decay=settings.weight_decay)
        if settings.schedule == "constant":
            return optimiser
        return {
            "optimizer": optimiser,
            "lr_scheduler": torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, settings.epochs),
        }


def stream(*numbers: int) -> int:
    """A seed of its own for every combination of numbers."""
    return int(np.random.SeedSequence(numbers).generate_state(1)[0])
