"""What a predicted mass depends on: the network's predictions as each of its numbers changes."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import replace

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import nn

from corsmal.errors import ArgumentError
from corsmal.geometry import Floats
from corsmal.mass.axis import AxisRule
from corsmal.mass.inputs import mass_input
from corsmal.mass.network import MassConfig, MassModel
from corsmal.mass.records import MassPrediction
from corsmal.quantities import DIMENSIONS

NUMBERS = (*DIMENSIONS, "mm_per_px")
"""What is predicted from beside the mask; the last one by some networks only."""


def predict_with_changes(
    model: MassModel | None,
    mask: NDArray[np.bool_],
    numbers: Mapping[str, float | None],
    *,
    changes: ArrayLike,
    axis: AxisRule,
    padding_px: int,
) -> tuple[MassPrediction, dict[str, Floats]]:
    """The mass of the container that a mask (H, W) shows, and how it depends on the numbers beside the mask.

    Args:
        model: the network, on the CPU; without it the mask is restored all the same.
        mask: bool, the container's visible pixels in the robot's view.
        numbers: ``NUMBERS`` by name, None where one is not known.
        changes: (n,) relative changes above -1, 0 among them: 0.1 for 10 % more.
        axis: the rule for the axis of symmetry.
        padding_px: around the mask's box.

    Returns:
        The prediction, and for each number that the network takes the masses (n,) as it changes; empty without a mass.
    """
    config = replace(MassConfig.paper() if model is None else model.config, axis=axis, padding_px=padding_px)
    given = mass_input(mask, config=config, **{name: numbers[name] for name in NUMBERS})
    if model is None or given.image is None or given.reason:
        return MassPrediction(None, given.reason or "there are no weights", given.restored, given.image), {}
    curves = mass_sensitivity(model, given.image, given.numbers, changes=changes)
    answer_g = float(curves[0, np.abs(np.asarray(changes)).argmin()])
    return given.weighed(answer_g, config), dict(zip(NUMBERS, curves, strict=False))


@torch.inference_mode()
def weigh(model: MassModel, image: NDArray[np.float32], numbers: ArrayLike) -> Floats:
    """Masses (n,) in grams of one silhouette (112, 112), 0..1, with several sets of numbers (n, 3 or 4).

    Raises:
        ArgumentError: there are not as many numbers in a row as the network takes.
    """
    rows = torch.as_tensor(np.asarray(numbers, dtype=np.float32))
    if rows.ndim != 2 or rows.shape[1] != model.config.numbers:
        raise ArgumentError(f"numbers must be (n, {model.config.numbers}), got {tuple(rows.shape)}")
    features = model.connected(model.blocks(torch.from_numpy(image)[None, None]))  # (1, 1, 112, 112) -> (1, u)
    rest = deepcopy(model)  # the image is processed once: it takes a hundred times as long as all that follows
    rest.blocks, rest.connected = nn.Sequential(), nn.Sequential()
    return np.asarray(rest(features.expand(len(rows), -1), rows).double().numpy(), dtype=np.float64)


def mass_sensitivity(
    model: MassModel, image: NDArray[np.float32], numbers: tuple[float, ...], *, changes: ArrayLike
) -> Floats:
    """Masses as one number changes, relatively and above -1, and the others stay: (numbers, changes) grams."""
    factors = 1 + np.asarray(changes, dtype=np.float64)
    base = np.array(numbers, dtype=np.float64)
    rows = np.repeat(base[None], len(base) * len(factors), axis=0).reshape(len(base), len(factors), len(base))
    which = np.arange(len(base))
    rows[which, :, which] *= factors
    return weigh(model, image, rows.reshape(-1, len(base))).reshape(len(base), -1)
