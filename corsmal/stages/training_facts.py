"""What the weights of a network keep about its training besides its recordings: the shape preset and the means."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, replace
from typing import Any

from corsmal.dataset import Dataset, Recording, TrainedOn
from corsmal.errors import ArgumentError
from corsmal.estimation import TrainingMeans
from corsmal.parameters import SHAPE_PRESETS, ShapeParameters
from corsmal.store import digest


def training_record(
    dataset: Dataset,
    recordings: Iterable[Recording] | None = None,
    *,
    shape: ShapeParameters | None = None,
    features: Mapping[str, str] | None = None,
) -> TrainedOn:
    """What a network that is trained on a dataset keeps in its weights.

    Args:
        dataset: gives the means that stand in for failed fits; without them where its annotation has none.
        recordings: those that are trained on; default: all.
        shape: parameters of the fits that its dimensions come from; None: it is given no dimensions.
        features: digests of the arrays that it is given instead of sound, by recording id.
    """
    facts: dict[str, Any] = {} if shape is None else {"shape": shape_name(shape)}
    with suppress(ArgumentError):
        facts["means"] = asdict(TrainingMeans.of(dataset))
    return replace(TrainedOn.of(dataset if recordings is None else recordings, features=features), facts=facts)


def shape_name(shape: ShapeParameters) -> str:
    """How a network's training names the parameters that its dimensions come from: a preset, or a digest."""
    return next((name for name, preset in SHAPE_PRESETS.items() if preset == shape), digest(shape))


def trained_shape(trained_on: TrainedOn | None) -> str | None:
    """The ``shape_name`` that a network was trained with; None where it is not known or there were no dimensions."""
    return None if trained_on is None else trained_on.facts.get("shape")
