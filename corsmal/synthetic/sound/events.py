"""What the demo's sound needs to know about a recording, and how long people pour."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from corsmal.dataset.annotation import LEVEL_FRACTIONS

SAMPLE_RATE_HZ = 44_100

Material = Literal["plastic", "glass", "cardboard"]
Filling = Literal["none", "pasta", "rice", "water"]
Level = Literal[0, 1, 2]
Action = Literal["pour", "shake", "handle"]

_BRIM_POUR_S = {"pasta": 8.6, "rice": 13.5, "water": 9.3}
# Longer pours go with larger containers, but weakly: people pour faster into what is larger.
_REFERENCE_CAPACITY_ML, _CAPACITY_EXPONENT = 400.0, 0.17
_PACE_SPREAD, _PACE_LIMITS = 0.34, (0.5, 2.0)


@dataclass(frozen=True, eq=False)
class SoundEvents:
    """One recording, as far as it can be heard.

    Args:
        material: what the container is made of; it colours every impact on it.
        capacity_ml: inner volume to the brim.
        opening_mm: inner width at the top; of a box, its longer side.
        filling: what is poured or shaken; ``none`` goes with level 0 only.
        level: 0 empty, 1 half (50 %), 2 full (90 %), in the end.
        action: ``pour``, ``shake`` (an empty box may be shaken too) or ``handle`` (nothing is filled in).
        start_s: when pouring, shaking or handling begins.
        source_path_m: where the container is, world coordinates in metres: (3,) for a container that stays, or (n, 3).
        contacts_s: when the container is tapped: put down, grasped.
        times_s: (n,) increasing, the times of ``source_path_m``; None where the container stays.
    """

    material: Material
    capacity_ml: float
    height_mm: float
    opening_mm: float
    filling: Filling
    level: Level
    duration_s: float
    action: Action
    start_s: float
    end_s: float
    source_path_m: ArrayLike
    contacts_s: tuple[float, ...] = ()
    times_s: ArrayLike | None = None

    def __post_init__(self) -> None:
        path = np.array(self.source_path_m, dtype=np.float64)
        times = np.zeros(1) if self.times_s is None else np.array(self.times_s, dtype=np.float64)
        path = path[None] if path.ndim == 1 else path
        object.__setattr__(self, "source_path_m", path)
        object.__setattr__(self, "times_s", times)

    def position_m(self, times_s: ArrayLike) -> NDArray[np.float64]:
        """Where the container is at the times ``times_s`` (m,) in seconds: (m, 3) metres, held before and after."""
        instants = np.atleast_1d(np.asarray(times_s, dtype=np.float64))
        known = np.asarray(self.times_s, dtype=np.float64)
        return np.column_stack([np.interp(instants, known, axis) for axis in np.asarray(self.source_path_m).T])


def pour_duration_s(
    filling: Filling, level: Level, capacity_ml: float, *, rng: np.random.Generator, pace: float = 1.0
) -> float:
    """How long a person pours, in seconds, ``pace`` times faster than in the real recordings; 0 for no filling.

    The medians follow the lengths of the real recordings less about 2.5 s of handling. People differ by a factor of
    about 1.4 either way, so the slow half and the quick full overlap and the length does not reveal the level.
    """
    personal = float(np.clip(np.exp(rng.normal(0.0, _PACE_SPREAD)), *_PACE_LIMITS))
    size = (capacity_ml / _REFERENCE_CAPACITY_ML) ** _CAPACITY_EXPONENT
    return LEVEL_FRACTIONS[level] * _BRIM_POUR_S.get(filling, 0.0) * size * personal / pace
