"""Training the mass network (paper 3.3 and 4.2)."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

import lightning
import numpy as np
import torch
from lightning.pytorch.callbacks import EarlyStopping, ModelCheckpoint
from lightning.pytorch.loggers import CSVLogger
from torch import Tensor
from torch.nn import functional

from corsmal.checkpoints import quiet_lightning, read_checkpoint
from corsmal.dataset import TrainedOn
from corsmal.errors import ArgumentError, FileError
from corsmal.mass.files import save_mass
from corsmal.mass.network import MassConfig, MassModel
from corsmal.mass.records import MassRow
from corsmal.mass.samples import Batch, Batches, MassSamples, held_out

LOSS = "validation_loss"


@dataclass(frozen=True)
class MassTraining:
    """How the network is trained.

    The paper gives the loss, the epochs, the patience and the split; batch and rate are chosen.

    Args:
        network: its sizes.
        epochs: maximum number.
        patience: epochs without a lower validation loss after which training stops.
        validation: share of each container's recordings that is held out to choose the epoch by.
        batch: rows per step.
        rate: learning rate of Adam.
        seed: of the split, the first weights and the order of the rows.

    Raises:
        ArgumentError: a number is out of its range.
    """

    network: MassConfig = field(default_factory=MassConfig.paper)
    epochs: int = 5000
    patience: int = 10
    validation: float = 0.2
    batch: int = 32
    rate: float = 1e-3
    seed: int = 0

    def __post_init__(self) -> None:
        if min(self.epochs, self.patience) < 1 or self.batch < 2 or self.seed < 0:
            raise ArgumentError(f"epochs and patience must be at least 1, batch at least 2, seed 0 or more, got {self}")
        if not 0 < self.validation < 1 or not 0 < self.rate < math.inf:
            raise ArgumentError(f"validation must lie between 0 and 1 and rate be positive, got {self}")


@dataclass(frozen=True)
class TrainedMass:
    """What a training leaves.

    Args:
        path: the weights, for ``MassPredictor``.
        rows: how many rows were trained on.
        validation_rows: how many the epoch was chosen by.
        dropped: how many rows were left out, by the reason.
        epochs: how many epochs were trained.
        validation_loss: of the epoch whose weights were kept: the mean squared error in g², or of ln(1 + g).
    """

    path: Path
    rows: int
    validation_rows: int
    dropped: dict[str, int]
    epochs: int
    validation_loss: float


def train_mass(
    rows: Iterable[MassRow],
    folder: Path,
    training: MassTraining | None = None,
    *,
    trained_on: TrainedOn | None = None,
) -> TrainedMass:
    """Train the network; an interrupted run in the same folder resumes.

    Args:
        rows: what to train on, iterated once. Rows without a usable mask or dimensions are
            left out and counted.
        folder: gets ``checkpoints``, ``log/version_N/metrics.csv`` (one for every start) and ``mass.safetensors``.
        training: settings; default: the paper's.
        trained_on: the recordings of ``rows``, which the weights keep; without it they count as trained on everything.

    Returns:
        Where the weights of the epoch with the lowest validation loss are, and how it went.

    Raises:
        ArgumentError: fewer than two rows to train on, or none to validate with, can be used.
        FileError: the folder cannot be written, or its checkpoint is broken or of another network.
    """
    training = training or MassTraining()
    samples = MassSamples.of(rows, training.network)
    held = held_out(samples.recordings, share=training.validation, seed=training.seed)
    if not held.any() or (~held).sum() < 2:
        raise ArgumentError(
            f"rows must leave two to train on and one to validate with, got {len(samples)} that can be used; "
            f"left out: {samples.dropped or 'none'}"
        )
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(folder, f"cannot be written ({error.strerror}); choose another folder") from error
    if training.network.least_mass_g is None:
        network = replace(training.network, least_mass_g=float(samples.masses_g.min()))
        training = replace(training, network=network)
    with torch.random.fork_rng(), quiet_lightning():
        torch.manual_seed(training.seed)
        module = MassModule(training, samples.chosen(~held), samples.chosen(held))
        loss, epochs = _fit(module, folder, training)
    path = folder / "mass.safetensors"
    save_mass(path, module.network, training=None if trained_on is None else trained_on.to_json())
    return TrainedMass(path, int((~held).sum()), int(held.sum()), samples.dropped, epochs, loss)


class MassModule(lightning.LightningModule):
    """The network with its loss, its batches and its optimiser.

    Args:
        training: the settings.
        samples: the rows to train on.
        validation: the rows to validate with.
    """

    def __init__(self, training: MassTraining, samples: MassSamples, validation: MassSamples) -> None:
        super().__init__()
        self._training, self._samples, self._validation = training, samples, validation
        self.network = MassModel(training.network)
        self.network.learn_statistics(torch.from_numpy(samples.numbers), torch.from_numpy(samples.masses_g))

    def train_dataloader(self) -> Batches:
        """The rows in the epoch's own order, so that a resumed run gets the batches of an uninterrupted one."""
        rng = np.random.default_rng([self._training.seed, self.current_epoch])
        return Batches(self._samples, self._training.batch, rng)

    def val_dataloader(self) -> Batches:
        """The validation rows."""
        return Batches(self._validation, 4 * self._training.batch, None)

    def training_step(self, batch: Batch) -> Tensor:
        """The mean squared error of the network's answers."""
        return self._logged("loss", batch)

    def validation_step(self, batch: Batch) -> None:
        """The same on the rows that are held out."""
        self._logged(LOSS, batch)

    def configure_optimizers(self) -> torch.optim.Optimizer:
        """Adam."""
        return torch.optim.Adam(self.network.parameters(), self._training.rate)

    def _logged(self, name: str, batch: Batch) -> Tensor:
        images, numbers, masses_g = batch
        # 1.7 times as quick as the default order (a CPU with AVX2 only)
        answers = self.network.answer(images.to(memory_format=torch.channels_last), numbers)
        loss = functional.mse_loss(answers, self.network.as_target(masses_g))
        self.log(name, loss, on_step=False, on_epoch=True, batch_size=len(masses_g))
        return loss


def _fit(module: MassModule, folder: Path, training: MassTraining) -> tuple[float, int]:
    """Train a module and give it the best epoch's weights; their validation loss and the number of epochs."""
    last = folder / "checkpoints" / "last.ckpt"
    earlier = read_checkpoint(last)
    if earlier is not None and not _fits(module, earlier["state_dict"]):
        raise FileError(last, "is of another network; delete it to begin again, or choose another folder")
    keeper = ModelCheckpoint(folder / "checkpoints", monitor=LOSS, save_last=True)
    trainer = lightning.Trainer(
        accelerator="auto",
        devices=1,
        max_epochs=training.epochs,
        reload_dataloaders_every_n_epochs=1,
        num_sanity_val_steps=0,
        logger=CSVLogger(folder, name="log"),
        log_every_n_steps=1,
        callbacks=[EarlyStopping(LOSS, patience=training.patience), keeper],
        enable_model_summary=False,
        enable_progress_bar=False,
    )
    trainer.fit(module, ckpt_path=last if earlier else None, weights_only=True)
    best = read_checkpoint(Path(keeper.best_model_path))
    if best is None:
        raise FileError(folder, "holds no checkpoint after the training; delete it and begin again")
    module.load_state_dict(best["state_dict"])
    return float(keeper.best_model_score or math.nan), trainer.current_epoch


def _fits(module: MassModule, state: dict[str, Tensor]) -> bool:
    own = {name: value.shape for name, value in module.state_dict().items()}
    return own == {name: value.shape for name, value in state.items()}
