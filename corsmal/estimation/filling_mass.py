"""How far the filling's mass is known: from the probabilities of all fillings, and the capacity's interval."""

from collections.abc import Sequence
from statistics import NormalDist

import numpy as np

from corsmal.dataset.annotation import FILLINGS, LEVELS
from corsmal.errors import ArgumentError
from corsmal.estimation.several import Interval
from corsmal.filling.records import FEASIBLE_PAIRS
from corsmal.mass.physics import filling_mass_g

SHARE = 0.9
"""Of the distribution lies in the interval."""

CAPACITIES = 999
"""Equally likely capacities that stand for their distribution."""


def filling_mass_interval_g(
    type_probabilities: Sequence[float],
    level_probabilities: Sequence[float],
    capacity_ml: float,
    *,
    capacity_interval_ml: Interval | None = None,
) -> Interval:
    """Where the filling's mass lies with a probability of 90 %.

    Fillings are the pairs of type and level that exist, each as likely as the product of its two probabilities. The
    answer itself is the likeliest pair's mass, which may lie outside of the interval's middle: the mean of the
    distribution is a mass that none of the pairs has, and scored worse (challenge score s8) in cross-validation. How
    densely a filling lies is not part of it: the training set's masses differ from this formula by up to 24 %.

    Args:
        type_probabilities: (4,) of none, pasta, rice and water.
        level_probabilities: (3,) of empty, half and full.
        capacity_ml: mL, not negative.
        capacity_interval_ml: ends of its 90 % interval, taken as those of a normal distribution around its middle;
            None: the capacity counts as exact.

    Returns:
        Grams: the lower end, below which lies at most 5 % of the distribution, and the upper one.

    Raises:
        ArgumentError: there are not as many probabilities as classes, or no pair has any.
    """
    if (len(type_probabilities), len(level_probabilities)) != (len(FILLINGS), len(LEVELS)):
        counts = f"{len(type_probabilities)} and {len(level_probabilities)}"
        raise ArgumentError(f"type_probabilities and level_probabilities must be 4 and 3, got {counts}")
    shares = np.array([type_probabilities[kind] * level_probabilities[level] for kind, level in FEASIBLE_PAIRS])
    if not 0 < shares.sum() < np.inf:
        raise ArgumentError(f"at least one filling must be possible, got {list(type_probabilities)}")
    capacities = _capacities(capacity_ml, capacity_interval_ml)
    masses = np.array([filling_mass_g(*pair, capacity) for pair in FEASIBLE_PAIRS for capacity in capacities])
    order = masses.argsort(kind="stable")
    cumulated = np.cumsum(np.repeat(shares / shares.sum() / len(capacities), len(capacities))[order])
    ends = np.searchsorted(cumulated, [(1 - SHARE) / 2, (1 + SHARE) / 2]).clip(max=len(masses) - 1)
    low, high = masses[order][ends].tolist()
    return low, high


def _capacities(capacity_ml: float, interval_ml: Interval | None) -> list[float]:
    """Equally likely ones, mL."""
    if interval_ml is None or interval_ml[0] >= interval_ml[1]:
        return [capacity_ml]
    low, high = interval_ml
    normal = NormalDist((low + high) / 2, (high - low) / 2 / NormalDist().inv_cdf((1 + SHARE) / 2))
    return [max(0.0, normal.inv_cdf((number + 0.5) / CAPACITIES)) for number in range(CAPACITIES)]
