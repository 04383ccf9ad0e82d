"""What the network trains on: recordings' features with their truth, and padded batches of them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import pandas as pd
import torch
from numpy.typing import NDArray
from torch import Tensor

from corsmal.dataset.annotation import CONTAINERS
from corsmal.errors import ArgumentError
from corsmal.filling.records import KINDS, LEVEL_NAMES, TYPE_NAMES

Task = Literal["type", "level", "both"]
"""What a pass over the recordings trains."""

UNKNOWN = -1
"""Stands for a container's kind that is not known."""

CROP_START_MAX, CROP_END_MIN = 0.4, 0.6
"""Of the recording's length: the type pass begins at the earliest at 0, at the latest here; it ends here or later."""


@dataclass(frozen=True, eq=False)
class FillingSample:
    """One recording to train or validate on.

    Args:
        features: (C, T, features) float32, finite, T at least 1.
        sight: (views, T, features) float32 of its videos, likewise, a view that is missing zero everywhere; None: there
            is none. Only fused networks see it.
        filling_type: 0 to 3: none, pasta, rice, water.
        filling_level: 0 to 2: empty, half, full.

    Raises:
        ArgumentError: the features or a class are not of this form; the text names the recording.
    """

    recording_id: str
    container_id: int
    features: NDArray[np.float32]
    filling_type: int
    filling_level: int
    sight: NDArray[np.float32] | None = None

    def __post_init__(self) -> None:
        for name, array in (("features", self.features), ("sight", self.sight)):
            if array is None:
                continue
            if array.ndim != 3 or 0 in array.shape or array.dtype != np.float32:
                found = f"{array.shape} of {array.dtype}"
                raise ArgumentError(f"{name} of {self.recording_id} must be (C, T, features) float32, got {found}")
            if not np.isfinite(array).all():
                raise ArgumentError(f"{name} of {self.recording_id} must be finite, got NaN or infinity")
        for name, classes in (("filling_type", len(TYPE_NAMES)), ("filling_level", len(LEVEL_NAMES))):
            if getattr(self, name) not in range(classes):
                raise ArgumentError(
                    f"{name} of {self.recording_id} must be 0 to {classes - 1}, got {getattr(self, name)}"
                )

    @property
    def kind(self) -> int:
        """The container's kind, its place in ``KINDS``; ``UNKNOWN`` for one that is none of the published ones."""
        name = CONTAINERS[self.container_id][1] if self.container_id in CONTAINERS else None
        return UNKNOWN if name is None else KINDS.index(name)

    @property
    def rows(self) -> int:
        """T."""
        return self.features.shape[1]


class Batch(NamedTuple):
    """The recordings of one step, padded to the longest.

    Args:
        task: what the step trains.
        features: (B, C, T, features) float32, zero beyond a recording's end.
        mask: (B, T) bool, true on its own rows.
        types: (B,) filling types.
        levels: (B,) filling levels.
        kinds: (B,) kinds of the containers, see ``FillingSample.kind``.
    """

    task: Task
    features: Tensor
    mask: Tensor
    types: Tensor
    levels: Tensor
    kinds: Tensor


class Batches:
    """One epoch: for each task, every recording once.

    Args:
        samples: the recordings.
        size: recordings per batch.
        tasks: the passes of the epoch; ``type`` sees a random crop of each recording (paper 2), the others the whole.
        rng: draws the order and the crops; None keeps the recordings' order and crops nothing.
    """

    def __init__(
        self, samples: Sequence[FillingSample], *, size: int, tasks: Sequence[Task], rng: np.random.Generator | None
    ) -> None:
        self._samples, self._size, self._tasks, self._rng = samples, size, tasks, rng

    def __len__(self) -> int:
        return len(self._tasks) * -(-len(self._samples) // self._size)

    def __iter__(self) -> Iterator[Batch]:
        count = len(self._samples)
        for task in self._tasks:
            order = np.arange(count) if self._rng is None else self._rng.permutation(count)
            for first in range(0, count, self._size):
                samples = [self._samples[index] for index in order[first : first + self._size]]
                crop = None if task != "type" or self._rng is None else self._rng
                crops = [(0, sample.rows) if crop is None else random_crop(sample.rows, crop) for sample in samples]
                yield padded(task, samples, crops)


def random_crop(rows: int, rng: np.random.Generator) -> tuple[int, int]:
    """[start, end) with start ~ U[0, 0.4 T] rounded down and end ~ U[0.6 T, T] rounded up (paper 2)."""
    start = rng.uniform(0, CROP_START_MAX * rows)
    end = rng.uniform(CROP_END_MIN * rows, rows)
    return int(start), min(int(np.ceil(end)), rows)


def padded(task: Task, samples: Sequence[FillingSample], crops: Sequence[tuple[int, int]]) -> Batch:
    """The crops, [start, end) rows of each recording, as one batch."""
    channels, _, width = samples[0].features.shape
    length = max(end - start for start, end in crops)
    features = np.zeros((len(samples), channels, length, width), np.float32)
    mask = np.zeros((len(samples), length), dtype=bool)
    for index, (sample, (start, end)) in enumerate(zip(samples, crops, strict=True)):
        features[index, :, : end - start] = sample.features[:, start:end]
        mask[index, : end - start] = True
    types = torch.tensor([sample.filling_type for sample in samples])
    levels = torch.tensor([sample.filling_level for sample in samples])
    kinds = torch.tensor([sample.kind for sample in samples])
    return Batch(task, torch.from_numpy(features), torch.from_numpy(mask), types, levels, kinds)


def filling_samples(
    table: pd.DataFrame,
    features: Mapping[str, NDArray[np.float32]],
    *,
    sight: Mapping[str, NDArray[np.float32]] | None = None,
) -> list[FillingSample]:
    """The recordings whose container and filling are known, with their features.

    Args:
        table: such as ``Dataset.table``.
        features: (C, T, features) float32 by recording id; recordings that it lacks are left out.
        sight: (views, T, features) float32 of their videos by recording id; it may lack some.
    """
    known = table[["container_id", "filling_type", "filling_level"]].dropna().astype(int)
    return [
        FillingSample(
            str(name), int(container), features[str(name)], int(kind), int(level), sight=(sight or {}).get(str(name))
        )
        for name, (container, kind, level) in zip(known.index, known.to_numpy(), strict=True)
        if name in features
    ]
