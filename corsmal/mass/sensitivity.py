"""What a predicted mass hangs on: the network's answers as each of its numbers changes."""

from copy import deepcopy

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import nn

from corsmal.errors import ArgumentError
from corsmal.mass.network import MassModel

Floats = NDArray[np.float64]


@torch.inference_mode()
def weigh(model: MassModel, image: NDArray[np.float32], numbers: ArrayLike) -> Floats:
    """Masses of one silhouette with several sets of numbers.

    Args:
        model: the network, on the CPU.
        image: (112, 112) float32, 0..1.
        numbers: (n, 3 or 4), see ``MassModel``.

    Returns:
        (n,) grams.

    Raises:
        ArgumentError: there are not as many numbers in a row as the network takes.
    """
    rows = torch.as_tensor(np.asarray(numbers, dtype=np.float32))
    if rows.ndim != 2 or rows.shape[1] != model.config.numbers:
        raise ArgumentError(f"numbers must be (n, {model.config.numbers}), got {tuple(rows.shape)}")
    features = model.connected(model.blocks(torch.from_numpy(image)[None, None]))  # (1, 1, 112, 112) -> (1, u)
    rest = deepcopy(model)  # the image is looked at once: it takes a hundred times as long as all that follows
    rest.blocks, rest.connected = nn.Sequential(), nn.Sequential()
    return np.asarray(rest(features.expand(len(rows), -1), rows).double().numpy(), dtype=np.float64)


def mass_sensitivity(
    model: MassModel, image: NDArray[np.float32], numbers: tuple[float, ...], *, changes: ArrayLike
) -> Floats:
    """Masses as one number changes and the others stay.

    Args:
        model: the network, on the CPU.
        image: (112, 112) float32, 0..1.
        numbers: of the prediction, see ``MassModel``.
        changes: (n,) relative changes above -1: 0.1 for 10 % more.

    Returns:
        (numbers, n) grams: a row for each number.
    """
    factors = 1 + np.asarray(changes, dtype=np.float64)
    base = np.array(numbers, dtype=np.float64)
    rows = np.repeat(base[None], len(base) * len(factors), axis=0).reshape(len(base), len(factors), len(base))
    which = np.arange(len(base))
    rows[which, :, which] *= factors
    return weigh(model, image, rows.reshape(-1, len(base))).reshape(len(base), -1)
