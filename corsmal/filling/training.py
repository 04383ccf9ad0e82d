"""Training filling type and level: one network or several, from recordings to a file of weights."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from corsmal.dataset import TrainedOn
from corsmal.digests import digest
from corsmal.errors import ArgumentError, FileError
from corsmal.files import writing
from corsmal.filling.files import read_filling, save_filling
from corsmal.filling.folds import PAPER_FOLDS, spread_folds
from corsmal.filling.loop import fit_network, kept_epoch
from corsmal.filling.recipe import FillingTraining
from corsmal.filling.records import NAMES
from corsmal.filling.samples import FillingSample
from corsmal.parameters import NetworkPreset

RETRAINED = 2
"""Factor on the epochs of a second training, whose rate, lowered to zero by a cosine, is half as large on average."""


def train_filling(
    folder: Path,
    samples: Sequence[FillingSample],
    *,
    preset: NetworkPreset | FillingTraining = "paper",
    seed: int = 0,
    validation: Sequence[FillingSample] | None = None,
    trained_on: TrainedOn | None = None,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Train the network, or resume where a run in the same folder was stopped.

    Args:
        folder: gets the weights, and a folder for each network with its checkpoint, ``metrics.csv`` and TensorBoard's
            log, and within it ``search`` where the network is trained twice.
        samples: the recordings to train on.
        preset: ``paper``, ``released``, ``tuned``, or settings of your own; their channels and features become those of
            ``samples``.
        seed: 0 or more; of the first weights, the order of the recordings, the crops and dropout.
        validation: recordings that rule (1) chooses the epoch by. Default: a seventh of ``samples``, spread over the
            configurations, on which the network is then not trained; with ``retrain`` it is trained once more, on all
            ``samples``, for as long as rule (1) chose, see ``retraining``. Not used where the last epoch is kept.
        trained_on: the recordings of ``samples``, which the weights keep; without it they count as trained on
            everything.
        progress: called after every epoch with the fraction that is done, 0..1.

    Returns:
        The file with the weights, for ``FillingPredictor``; when it is there already, nothing is trained.

    Raises:
        ArgumentError: there are no recordings, they differ in channels or features, or all have one type or one level.
        FileError: the folder cannot be written, or holds another run, or a broken file.
    """
    training = preset if isinstance(preset, FillingTraining) else FillingTraining.of(preset)
    validation = () if training.keep == "last" or validation is None else validation
    channels, _, features = _check(samples, validation)
    training = training.fitted_to(channels=channels, features=features)
    claim(folder, training, seed, (samples, validation))
    path, count = folder / "filling.safetensors", len(training.networks)
    if path.exists():
        read_filling(path)
        return path
    models = []
    for index in range(count):
        place, part = folder / f"network{index}", part_of(progress, index, count)
        fit = partial(fit_network, index=index, seed=seed)
        if training.keep == "last" or validation:
            models.append(fit(place, samples, training=training, validation=validation, progress=part))
            continue
        kept, held = hold_out(samples, seed=seed)
        if not training.retrain:
            models.append(fit(place, kept, training=training, validation=held, progress=part))
            continue
        search = place / "search"
        fit(search, kept, training=training, validation=held, progress=part_of(part, 0, 2))
        again = retraining(training, kept_epoch(search)[0])
        models.append(fit(place, samples, training=again, validation=(), progress=part_of(part, 1, 2)))
    save_filling(path, models, training=None if trained_on is None else trained_on.to_json())
    return path


def retraining(training: FillingTraining, epochs: int) -> FillingTraining:
    """How a network is trained once more, on all recordings, when rule (1) chose ``epochs`` on a part of them.

    The rate is lowered to zero by half a cosine over twice the epochs: its sum stays what it was when the search found
    its best, and the weights come to rest.
    """
    return replace(training, keep="last", schedule="cosine", epochs=RETRAINED * epochs)


def part_of(progress: Callable[[float], None] | None, done: int, total: int) -> Callable[[float], None] | None:
    """The ``progress`` of one of ``total`` jobs that run one after another, when ``done`` of them are done."""
    return None if progress is None else lambda part: progress((done + part) / total)


def hold_out(
    samples: Sequence[FillingSample], *, folds: int = PAPER_FOLDS, seed: int = 0
) -> tuple[list[FillingSample], list[FillingSample]]:
    """Samples to train on, and one in ``folds`` to choose the epoch by: a fold of ``spread_folds``."""
    truth = [(sample.filling_type, sample.filling_level) for sample in samples]
    fold = spread_folds(pd.DataFrame(truth, columns=["filling_type", "filling_level"]), folds=folds, seed=seed)
    held = (fold == 0).to_numpy()
    kept = [sample for sample, out in zip(samples, held, strict=True) if not out]
    return kept, [sample for sample, out in zip(samples, held, strict=True) if out]


def missing_classes(samples: Sequence[FillingSample]) -> list[str]:
    """The types and levels of which there is no sample: a network that is trained on these will not name them."""
    absent = []
    for name, classes in NAMES.items():
        own = {getattr(sample, name) for sample in samples}
        absent += [label for number, label in enumerate(classes) if number not in own]
    return absent


def _check(samples: Sequence[FillingSample], validation: Sequence[FillingSample]) -> tuple[int, int, int]:
    """The samples' shape, T aside."""
    if not samples:
        raise ArgumentError("samples must hold recordings to train on, got none")
    first = samples[0].features.shape
    for sample in (*samples, *validation):
        found = sample.features.shape
        if (found[0], found[2]) != (first[0], first[2]):
            where = f"{first} of {samples[0].recording_id} and {found} of {sample.recording_id}"
            raise ArgumentError(f"features of all samples must have the same channels and width, got {where}")
    for name, classes in NAMES.items():
        own = {getattr(sample, name) for sample in samples}
        if len(own) < 2:
            raise ArgumentError(f"samples must hold two classes of {name} or more, got {classes[own.pop()]} only")
    return first


def claim(folder: Path, training: Any, seed: int, parts: Sequence[Sequence[FillingSample]]) -> None:
    """Write down what the folder's run is of, or check that it is this one; ``training`` are its settings."""
    content = [
        [(sample.recording_id, sample.filling_type, sample.filling_level, sample.features) for sample in part]
        for part in parts
    ]
    settings = {
        "seed": seed,
        "recordings": len(parts[0]),
        **asdict(training),
        "digest": digest(training, seed, content),
    }
    path = folder / "settings.json"
    try:
        found = json.loads(path.read_text(encoding="utf-8"))["digest"]
    except (FileNotFoundError, NotADirectoryError):
        with writing(path, advice="choose another folder") as part:
            part.write_text(json.dumps(settings, indent=1), encoding="utf-8")
        return
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise FileError(path, "cannot be read; delete the folder to begin again") from error
    if found != settings["digest"]:
        raise FileError(path, "is of a run with other recordings or settings; choose another folder or delete this one")
