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
from corsmal.filling.config import ConvolvedConfig, FillingConfig, FrontEnd, PooledConfig, RecurrentConfig
from corsmal.filling.files import read_filling
from corsmal.filling.folds import spread_folds
from corsmal.filling.fused import FusedConfig, FusedModel, read_fused, save_fused
from corsmal.filling.fusion import SENSES, Answer, GateForm, Sense
from corsmal.filling.network import AnyModel
from corsmal.filling.recipe import FillingTraining, Keep
from corsmal.filling.samples import FillingSample
from corsmal.filling.training import claim, part_of, train_filling

INNER_FOLDS = 3
"""Folds of containers that the gate is learned from."""


def _sound() -> tuple[FillingTraining, ...]:
    """Networks of three forms, which err differently.

    Within the training containers of the winners' folds, weighted F1 of type and level together: 74.9 by one encoder of
    the preset ``tuned`` and one recurrent network (with two layers in the level's head), 76.3 with a convolutional one
    beside them (mean of seven trainings of it, 76.1 to 76.6; seven of the nine inner folds).
    """
    joint = FillingTraining(passes="joint", keep="last", schedule="cosine")
    encoders = tuple(FillingConfig.tuned(channels=1, standardise=index % 2 == 1) for index in range(2))
    return (
        replace(joint, networks=encoders, epochs=30, rate=1e-3),
        replace(joint, networks=(RecurrentConfig(),) * 2, epochs=40, batch=32, rate=2e-3),
        replace(joint, networks=(ConvolvedConfig(),), epochs=40, batch=32, rate=2e-3),
    )


def _sight() -> FillingTraining:
    networks = (PooledConfig(),) * 3
    return FillingTraining(
        networks, passes="joint", keep="last", epochs=30, batch=64, rate=1e-3, schedule="cosine", weight_decay=0.1
    )


@dataclass(frozen=True)
class FusedTraining:
    """How the fused network is trained.

    Args:
        sound: how the networks of sound are trained, groups that have settings of their own; they keep the last epoch.
        sight: likewise, those of sight.
        gate: between the senses, see ``FusionGate``.
        inner: networks of each group, and of sight, in a fold that the gate is learned from.

    Raises:
        ArgumentError: the networks are too many, or an epoch would be chosen, for which there are no recordings left.
    """

    sound: tuple[FillingTraining, ...] = field(default_factory=_sound)
    sight: FillingTraining = field(default_factory=_sight)
    gate: GateForm = "visible"
    inner: int = 1

    def __post_init__(self) -> None:
        networks = tuple(config for group in self.sound for config in group.networks)
        FusedConfig(networks, self.sight.networks, self.gate)
        groups = self.groups.values()
        if any(group.keep == "best" for group in groups):
            raise ArgumentError("sound and sight must keep the last epoch, got one that keeps the best")
        if not 1 <= self.inner <= min(len(group.networks) for group in groups):
            raise ArgumentError(f"inner must be 1 or more networks, at most those of each group, got {self.inner}")

    @property
    def groups(self) -> dict[str, FillingTraining]:
        """What is trained in a folder of its own, by its name, which begins with that of the sense."""
        return {f"sound{number}": group for number, group in enumerate(self.sound)} | {"sight": self.sight}

    @property
    def front_end(self) -> FrontEnd:
        """How sound becomes the features that the networks are trained on."""
        return self.sound[0].front_end

    @property
    def keep(self) -> Keep:
        """Which epoch's weights are kept."""
        return "last"

    def lasting(self, epochs: int) -> "FusedTraining":
        """With that many epochs for both senses."""
        return self._each(lambda group: replace(group, epochs=epochs))

    def shortened(self) -> "FusedTraining":
        """With the networks of an inner fold only."""
        return self._each(lambda group: replace(group, networks=group.networks[: self.inner]))

    def _each(self, change: Callable[[FillingTraining], FillingTraining]) -> "FusedTraining":
        return replace(self, sound=tuple(map(change, self.sound)), sight=change(self.sight))


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
    jobs = len(folds) * training.inner + sum(len(group.networks) for group in training.sound)
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
    heard = [replace(sample, sight=None) for sample in samples]
    models: dict[Sense, list[AnyModel]] = {"sound": [], "sight": []}
    for done, (name, group) in enumerate(training.groups.items()):
        sense: Sense = "sight" if name == "sight" else "sound"
        path = train_filling(
            folder / name,
            heard if sense == "sound" else seen(samples),
            preset=group,
            seed=seed,
            progress=part_of(progress, done, len(training.groups)),
        )
        models[sense] += read_filling(path)
    sound, sight = (tuple(model.config for model in models[sense]) for sense in SENSES)
    fused = FusedModel(FusedConfig(sound, sight, training.gate))
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
    sound, sight = (_joined([pair[sense] for pair in answers]) for sense in (0, 1))
    types = torch.tensor([sample.filling_type for sample in samples])
    model.gate.learn(sound, sight, types=types, levels=torch.tensor([sample.filling_level for sample in samples]))


def _joined(answers: Sequence[Answer]) -> Answer:
    heads = zip(*(tuple(part for part in answer if part is not None) for answer in answers), strict=True)
    return Answer(*map(torch.cat, heads))


def _span(progress: Callable[[float], None] | None, start: float, end: float) -> Callable[[float], None] | None:
    """The ``progress`` of a job that is the part from ``start`` to ``end`` of the whole."""
    return None if progress is None else lambda share: progress(start + share * (end - start))
