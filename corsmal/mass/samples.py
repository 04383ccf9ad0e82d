"""Rows in the network's form, and which of them validate."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from corsmal.mass.inputs import mass_input
from corsmal.mass.network import SIDE_PX, MassConfig
from corsmal.mass.records import MassRow

Batch = tuple[Tensor, Tensor, Tensor]
"""Images (B, 1, 112, 112) in 0..1, numbers (B, 3 or 4), masses (B,) in grams."""

WHITE = 255


@dataclass(frozen=True, eq=False)
class MassSamples:
    """The rows that the network can be given.

    Args:
        recordings: container and recording of each.
        images: (n, 112, 112) uint8, 255 for a pixel that the mask fills.
        numbers: (n, 3 or 4), see ``MassModel``.
        masses_g: (n,).
        dropped: how many rows could not be used, by the reason.
    """

    recordings: tuple[tuple[str, str], ...]
    images: NDArray[np.uint8]
    numbers: NDArray[np.float32]
    masses_g: NDArray[np.float32]
    dropped: dict[str, int]

    @classmethod
    def of(cls, rows: Iterable[MassRow], config: MassConfig) -> "MassSamples":
        """Restore and resize the masks of rows, one after the other."""
        kept: list[tuple[tuple[str, str], NDArray[np.uint8], tuple[float, ...], float]] = []
        dropped: Counter[str] = Counter()
        for row in rows:
            given = mass_input(
                row.mask,
                config=config,
                width_top_mm=row.width_top_mm,
                width_bottom_mm=row.width_bottom_mm,
                height_mm=row.height_mm,
                mm_per_px=row.mm_per_px,
            )
            if given.reason or given.image is None:
                dropped[given.reason] += 1
                continue
            image = np.rint(given.image * WHITE).astype(np.uint8)
            kept.append(((row.container, row.recording_id), image, given.numbers, row.mass_g))
        return cls(
            tuple(item[0] for item in kept),
            np.array([item[1] for item in kept], np.uint8).reshape(-1, SIDE_PX, SIDE_PX),
            np.array([item[2] for item in kept], np.float32).reshape(-1, config.numbers),
            np.array([item[3] for item in kept], np.float32),
            dict(dropped),
        )

    def __len__(self) -> int:
        return len(self.recordings)

    def chosen(self, which: NDArray[np.bool_]) -> "MassSamples":
        """Some of the rows, by (n,) bool."""
        recordings = tuple(pair for pair, is_chosen in zip(self.recordings, which, strict=True) if is_chosen)
        return MassSamples(recordings, self.images[which], self.numbers[which], self.masses_g[which], {})


@dataclass(frozen=True, eq=False)
class Batches:
    """Samples in batches, shuffled where there is a ``rng``.

    Then a last one of a single row is left out, as batch norm cannot learn from it.
    """

    samples: MassSamples
    size: int
    rng: np.random.Generator | None

    def __len__(self) -> int:
        whole, rest = divmod(len(self.samples), self.size)
        return whole + (rest > (self.rng is not None))

    def __iter__(self) -> Iterator[Batch]:
        order = np.arange(len(self.samples)) if self.rng is None else self.rng.permutation(len(self.samples))
        for index in range(len(self)):
            rows = order[index * self.size : (index + 1) * self.size]
            yield (
                torch.from_numpy(self.samples.images[rows])[:, None] / WHITE,
                torch.from_numpy(self.samples.numbers[rows]),
                torch.from_numpy(self.samples.masses_g[rows]),
            )


def held_out(recordings: Sequence[tuple[str, str]], *, share: float, seed: int) -> NDArray[np.bool_]:
    """Which rows validate: a share of each container's recordings, whole recordings at a time, (n,) bool.

    Args:
        recordings: container and recording of each row.
        share: to the nearest whole number of recordings, but never all of them.
        seed: of which.
    """
    chosen: set[tuple[str, str]] = set()
    rng = np.random.default_rng(seed)
    for container in sorted({container for container, _ in recordings}):
        own = sorted({pair for pair in recordings if pair[0] == container})
        count = min(round(share * len(own)), len(own) - 1)
        chosen |= {own[index] for index in rng.permutation(len(own))[:count]}
    return np.array([pair in chosen for pair in recordings], dtype=bool)
