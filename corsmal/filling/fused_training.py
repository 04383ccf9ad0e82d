"""Training the fused network: both senses' networks, and the gate on recordings of containers unseen by them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd
import torch

from corsmal.dataset import TrainedOn
from corsmal.errors import ArgumentError
from corsmal.filling.config import FrontEnd, PooledConfig, RecurrentConfig
from corsmal.filling.files import read_filling
from corsmal.filling.folds import spread_folds
from corsmal.filling.fused import FusedConfig, FusedModel, read_fused, save_fused
from corsmal.filling.fusion import SENSES, Answer, Sense
from corsmal.filling.network import AnyModel
from corsmal.filling.recipe import FillingTraining, Keep
from corsmal.filling.samples import FillingSample
from corsmal.filling.training import claim, part_of, train_filling

INNER_FOLDS = 3
"""Folds of containers that the gate is learned from."""


def _sound() -> FillingTraining:
    networks = (RecurrentConfig(),) * 4
    return FillingTraining(networks, passes="joint", keep="last", epochs=40, batch=32, rate=2e-3, schedule="cosine")


def _sight() -> FillingTraining:
    networks = (PooledConfig(),) * 3
    return FillingTraining(
        networks, passes="joint", keep="last", epochs=30, batch=64, rate=1e-3, schedule="cosine", weight_decay=0.1
    )


@dataclass(frozen=True)
class FusedTraining:
    """How the fused network is trained.

    Args:
        sound: how the networks of sound are trained; they keep the last epoch.
        sight: likewise, those of sight.
        inner: networks of each sense in a fold that the gate is learned from.

    Raises:
        ArgumentError: the networks are too many, or an epoch would be chosen, for which there are no recordings left.
    """

    sound: FillingTraining = field(default_factory=_sound)
    sight: FillingTraining = field(default_factory=_sight)
    inner: int = 1

    def __post_init__(self) -> None:
        FusedConfig(self.sound.networks, self.sight.networks)
        if "best" in (self.sound.keep, self.sight.keep):
            raise ArgumentError("sound and sight must keep the last epoch, got one that keeps the best")
        if not 1 <= self.inner <= min(len(self.sound.networks), len(self.sight.networks)):
            raise ArgumentError(f"inner must be 1 or more networks, at most those of each sense, got {self.inner}")

    @property
    def front_end(self) -> FrontEnd:
        """How sound becomes the features that the networks are trained on."""
        return self.sound.front_end

    @property
    def keep(self) -> Keep:
        """Which epoch's weights are kept."""
        return "last"

    def of(self, sense: Sense) -> FillingTraining:
        """How the networks of a sense are trained."""
        return self.sound if sense == "sound" else self.sight

    def lasting(self, epochs: int) -> "FusedTraining":
        """With that many epochs for both senses."""
        return replace(self, sound=replace(self.sound, epochs=epochs), sight=replace(self.sight, epochs=epochs))

    def shortened(self) -> "FusedTraining":
        """With the networks of an inner fold only."""
        sound, sight = (replace(self.of(sense), networks=self.of(sense).networks[: self.inner]) for sense in SENSES)
        return replace(self, sound=sound, sight=sight)


def train_fused(
    folder: Path,
    samples: Sequence[FillingSample],
    *,
    training: FusedTraining | None = None,
    seed: int = 0,
    trained_on: TrainedOn | None = None,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Train the networks of both senses and the gate, or resume where a run in the same folder was stopped.

    Gate and temperatures are learned from what networks say that were trained without the recording's container; then
    the networks are trained on all recordings. Those without sight train the networks of sound only.

    Args:
        folder: gets the weights, and folders ``inner0``, … and ``all`` with the trainings of each sense.
        samples: the recordings to train on.
        training: the settings; default: those of ``FusedTraining``. Channels and features become those of ``samples``.
        seed: 0 or more; of all that is drawn.
        trained_on: the recordings of ``samples``, which the weights keep.
        progress: called with the fraction that is done, 0..1.

    Returns:
        The file with the weights, for ``FusedPredictor``; when it is there already, nothing is trained.

    Raises:
        ArgumentError: no recording has sight, a fold lacks classes, or as for ``train_filling``.
        FileError: the folder cannot be written, or holds another run, or a broken file.
    """
    training = training or FusedTraining()
    both = [sample for sample in samples if sample.sight is not None]
    if not both:
        raise ArgumentError("samples must hold recordings with features of sound and of sight, got none")
    claim(folder, training, seed, (samples, seen(samples)))
    path = folder / "filling.safetensors"
    if path.exists():
        read_fused(path)
        return path
    folds = inner_folds(both)
    jobs = len(folds) * training.inner + len(training.sound.networks)
    fit = partial(_fit, seed=seed)
    answers: list[tuple[Answer, Answer]] = []
    for done, held in enumerate(folds):
        ids = {sample.recording_id for sample in held}
        others = [sample for sample in samples if sample.recording_id not in ids]
        part = _span(progress, done * training.inner / jobs, (done + 1) * training.inner / jobs)
        model = fit(folder / f"inner{done}", others, training=training.shortened(), progress=part)
        answers += [_answers(model, sample) for sample in held]
    part = _span(progress, len(folds) * training.inner / jobs, 1.0)
    model = fit(folder / "all", samples, training=training, progress=part)
    _learn_gate(model, answers, [sample for held in folds for sample in held])
    save_fused(path, model, training=None if trained_on is None else trained_on.to_json())
    return path


def train_either(
    folder: Path, samples: Sequence[FillingSample], *, training: FillingTraining | FusedTraining, **options: Any
) -> Path:
    """``train_fused`` or ``train_filling``, as the settings say; further arguments are those that both have."""
    if isinstance(training, FusedTraining):
        return train_fused(folder, samples, training=training, **options)
    return train_filling(folder, samples, preset=training, **options)


def inner_folds(samples: Sequence[FillingSample]) -> list[list[FillingSample]]:
    """The folds that the gate is learned from: whole containers, dealt in the order of their ids.

    Cups, glasses and boxes have thirds of the ids each, so that no fold holds all of a kind. With fewer than two
    containers, recordings are spread over the folds by their filling.
    """
    containers = sorted({sample.container_id for sample in samples})
    if len(containers) < 2:
        truth = [(sample.filling_type, sample.filling_level) for sample in samples]
        table = pd.DataFrame(truth, columns=["filling_type", "filling_level"])
        numbers = list(spread_folds(table, folds=INNER_FOLDS))
    else:
        numbers = [containers.index(sample.container_id) % INNER_FOLDS for sample in samples]
    own = zip(numbers, samples, strict=True)
    folds: list[list[FillingSample]] = [[] for _ in range(INNER_FOLDS)]
    for number, sample in own:
        folds[number].append(sample)
    return [fold for fold in folds if fold]


def _fit(
    folder: Path,
    samples: Sequence[FillingSample],
    *,
    training: FusedTraining,
    seed: int,
    progress: Callable[[float], None] | None,
) -> FusedModel:
    """The networks of both senses, the gate still untrained."""
    given: dict[Sense, list[FillingSample]] = {
        "sound": [replace(sample, sight=None) for sample in samples],
        "sight": seen(samples),
    }
    models: dict[Sense, list[AnyModel]] = {}
    for done, sense in enumerate(SENSES):
        path = train_filling(
            folder / sense,
            given[sense],
            preset=training.of(sense),
            seed=seed,
            progress=part_of(progress, done, len(SENSES)),
        )
        models[sense] = read_filling(path)
    sizes = FusedConfig(*(tuple(model.config for model in models[sense]) for sense in SENSES))
    fused = FusedModel(sizes)
    for sense in SENSES:
        for own, trained in zip(getattr(fused, sense), models[sense], strict=True):
            own.load_state_dict(trained.state_dict())
    return fused.eval()


def seen(samples: Sequence[FillingSample]) -> list[FillingSample]:
    """The recordings with sight, with it in place of their sound."""
    return [replace(sample, features=sample.sight, sight=None) for sample in samples if sample.sight is not None]


@torch.no_grad()
def _answers(model: FusedModel, sample: FillingSample) -> tuple[Answer, Answer]:
    [sight] = seen([sample])
    return (
        model.answer("sound", torch.from_numpy(sample.features)[None]),
        model.answer("sight", torch.from_numpy(sight.features)[None]),
    )


def _learn_gate(model: FusedModel, answers: Sequence[tuple[Answer, Answer]], samples: Sequence[FillingSample]) -> None:
    sound, sight = (
        (torch.cat([pair[sense][0] for pair in answers]), torch.cat([pair[sense][1] for pair in answers]))
        for sense in (0, 1)
    )
    types = torch.tensor([sample.filling_type for sample in samples])
    model.gate.learn(sound, sight, types=types, levels=torch.tensor([sample.filling_level for sample in samples]))


def _span(progress: Callable[[float], None] | None, start: float, end: float) -> Callable[[float], None] | None:
    """The ``progress`` of a job that is the part from ``start`` to ``end`` of the whole."""
    return None if progress is None else lambda share: progress(start + share * (end - start))
