"""Fitting one network: checkpoints, logs, and which epoch's weights are kept (paper 2)."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import lightning
import torch
from lightning.pytorch.callbacks import Callback
from lightning.pytorch.loggers import CSVLogger, TensorBoardLogger

from corsmal.checkpoints import quiet_lightning, read_checkpoint
from corsmal.errors import FileError
from corsmal.files import writing
from corsmal.filling.files import read_filling, save_filling
from corsmal.filling.module import FillingModule, stream
from corsmal.filling.network import AnyModel
from corsmal.filling.recipe import FillingTraining
from corsmal.filling.samples import FillingSample

LOSS_FLOOR = 0.15
"""Of either loss in rule (1)."""

DIVERGED = "training diverged; delete the folder and lower the learning rate"


def keeps(lowest: float, level_loss: float, type_loss: float) -> bool:
    """Rule (1): whether an epoch's weights replace those that were kept.

    ``lowest`` is L, the sum of the two losses of the epoch that was kept last, infinity before the first; the other two
    are the cross-entropies of the epoch on the validation recordings.
    """
    if not math.isfinite(level_loss + type_loss):
        return False
    return lowest > max(LOSS_FLOOR, level_loss) + max(LOSS_FLOOR, type_loss)


def fit_network(
    folder: Path,
    samples: Sequence[FillingSample],
    *,
    training: FillingTraining,
    index: int,
    seed: int,
    validation: Sequence[FillingSample],
    progress: Callable[[float], None] | None = None,
) -> AnyModel:
    """Fit network number ``index`` of a training, or resume where a run in the same folder was stopped.

    On a CPU, a run that is stopped and resumed gives the same weights as one that is not: every epoch draws from a
    generator of its own, which follows from seed and index.

    Args:
        folder: gets ``checkpoints/last.ckpt``, ``log/version_N/metrics.csv`` for the Nth start, TensorBoard's log and
            ``network.safetensors``.
        samples: the recordings to train on.
        training: the settings.
        index: which of its networks.
        seed: of everything that is drawn.
        validation: the recordings that rule (1) uses; may be empty where the last epoch is kept.
        progress: called after every epoch with the fraction that is done.

    Raises:
        FileError: the folder cannot be written, or its checkpoint is broken, or training diverged.
    """
    done = folder / "network.safetensors"
    if done.exists():
        return read_filling(done)[0]
    last = folder / "checkpoints" / "last.ckpt"
    is_begun = read_checkpoint(last) is not None
    with torch.random.fork_rng(devices=range(torch.cuda.device_count())), quiet_lightning():
        torch.manual_seed(stream(seed, index))
        module = FillingModule(training, index, samples, validation, seed=seed)
        keeper = KeepBest(folder / "kept.safetensors", module.network)
        callbacks = [*([keeper] if training.keep == "best" else []), _EveryEpoch(last, progress)]
        trainer = _trainer(folder, callbacks, epochs=training.epochs, validated=bool(validation))
        trainer.fit(module, ckpt_path=last if is_begun else None, weights_only=True)
    network = keeper.kept() if training.keep == "best" else module.network.cpu().eval()
    if not all(torch.isfinite(value).all() for value in network.state_dict().values()):
        raise FileError(folder, DIVERGED)
    save_filling(done, [network])
    return network


def kept_epoch(folder: Path) -> tuple[int, float]:
    """After how many epochs ``fit_network`` kept the weights that rule (1) chose, and L, the sum of their two losses.

    Raises:
        FileError: the checkpoint in the network's folder is absent or broken.
    """
    last = folder / "checkpoints" / "last.ckpt"
    try:
        kept = (read_checkpoint(last) or {})["callbacks"]["KeepBest"]
        return int(kept["epochs"]), float(kept["lowest"])
    except (LookupError, TypeError, ValueError) as error:
        raise FileError(last, "is not a checkpoint of this training; delete it to begin again") from error


def _trainer(folder: Path, callbacks: list[Callback], *, epochs: int, validated: bool) -> lightning.Trainer:
    return lightning.Trainer(
        accelerator="auto",
        devices=1,
        max_epochs=epochs,
        reload_dataloaders_every_n_epochs=1,
        num_sanity_val_steps=0,
        limit_val_batches=1.0 if validated else 0,
        logger=[CSVLogger(folder, name="log"), TensorBoardLogger(folder, name="", version="tensorboard")],
        log_every_n_steps=1,
        callbacks=callbacks,
        enable_checkpointing=False,
        enable_model_summary=False,
        enable_progress_bar=False,
    )


class KeepBest(Callback):
    """Writes the weights of an epoch of ``network`` to ``path`` when rule (1) says so."""

    def __init__(self, path: Path, network: AnyModel) -> None:
        self.path, self._network = path, network
        self.lowest = math.inf
        self.epochs = 0

    def on_validation_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:  # noqa: ARG002 - Lightning's signature
        """Apply rule (1); when no later epoch could fulfil it, stop."""
        level, kind = (float(trainer.callback_metrics[f"validation_{task}_loss"]) for task in ("level", "type"))
        if keeps(self.lowest, level, kind):
            self.lowest, self.epochs = level + kind, trainer.current_epoch + 1
            save_filling(self.path, [self._network])
        trainer.should_stop = self.lowest <= 2 * LOSS_FLOOR

    def kept(self) -> AnyModel:
        """The network with the weights that were kept last.

        Raises:
            FileError: no epoch's losses were finite.
        """
        if not math.isfinite(self.lowest):
            raise FileError(self.path.parent, DIVERGED)
        return read_filling(self.path)[0]

    def state_dict(self) -> dict[str, Any]:
        """What a resumed run needs to know."""
        return {"lowest": self.lowest, "epochs": self.epochs}

    def load_state_dict(self, state_dict: dict[str, Any]) -> None:
        """Of the run that is resumed."""
        self.lowest, self.epochs = float(state_dict["lowest"]), int(state_dict["epochs"])


class _EveryEpoch(Callback):
    """After every epoch, all that is needed to resume in one file that is whole at any time, and the progress."""

    def __init__(self, path: Path, report: Callable[[float], None] | None) -> None:
        self._path, self._report = path, report

    def on_train_epoch_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:  # noqa: ARG002 - Lightning's signature
        with writing(self._path, advice="choose another folder") as part:
            trainer.save_checkpoint(part)
        if self._report is not None:
            self._report((trainer.current_epoch + 1) / (trainer.max_epochs or 1))
