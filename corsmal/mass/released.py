"""The mass network of the authors' program: its file, and its answer to an image and dimensions."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from numpy.typing import ArrayLike

from corsmal.errors import ArgumentError
from corsmal.mass.network import BLOCKS, SIDE_PX, MassConfig, MassModel
from corsmal.quantities import DIMENSIONS
from corsmal.state_dicts import read_state_dict

LEAST_MASS_G = 2.0
"""What the authors' program makes of an output of 0 g: the mass of the lightest container of the training set."""

NORM = ("weight", "bias", "running_mean", "running_var", "num_batches_tracked")
LAYERS = {
    **{f"blocks.{4 * index}": f"conv{index + 1}" for index in range(BLOCKS)},
    "connected.1": "linear1",
    "connected.4": "linear2",
    "last": "linear3",
}
"""The file's name of a layer with a weight and a bias, by ours."""

NORMS = {**{f"blocks.{4 * index + 2}": f"bn{index + 1}" for index in range(BLOCKS)}, "connected.3": "bn5"}
"""The same of the batch norms."""


def read_released(path: Path) -> MassModel:
    """The network of the authors' file, such as ``task4.pt``, ready to predict.

    Raises:
        FileError: the file is absent, broken, of another network, or holds numbers that are not finite.
    """
    model = MassModel(replace(MassConfig.released(), least_mass_g=LEAST_MASS_G))
    state = model.state_dict()
    names = {f"{own}.{part}": f"{theirs}.{part}" for own, theirs in LAYERS.items() for part in ("weight", "bias")}
    names |= {f"{own}.{part}": f"{theirs}.{part}" for own, theirs in NORMS.items() for part in NORM}
    content = read_state_dict(path, "mass", {theirs: tuple(state[own].shape) for own, theirs in names.items()})
    model.load_state_dict(state | {own: content[theirs] for own, theirs in names.items()})
    return model.eval()


def mass_g(path: str | Path, image: ArrayLike, dimensions: ArrayLike) -> float:
    """The mass that the authors' network gives to a container; where it answers 0 g, the 2 g that their program says.

    Args:
        path: its file, such as ``task4.pt``.
        image: (112, 112) numbers in 0..1, the restored mask as ``mass.inputs.square_image`` makes it.
        dimensions: (3,) top width, bottom width and height in mm.

    Returns:
        Grams, positive.

    Raises:
        ArgumentError: the image or the dimensions have another form.
        FileError: the file is absent, broken or of another network.

    Example:
        >>> mass_g("task4.pt", image, (98, 61, 119))  # doctest: +SKIP
    """
    picture, numbers = np.asarray(image, dtype=np.float32), np.asarray(dimensions, dtype=np.float32)
    if picture.shape != (SIDE_PX, SIDE_PX) or not ((picture >= 0) & (picture <= 1)).all():
        raise ArgumentError(f"image must be ({SIDE_PX}, {SIDE_PX}) numbers in 0..1, got shape {picture.shape}")
    if numbers.shape != (len(DIMENSIONS),) or not (np.isfinite(numbers) & (numbers > 0)).all():
        raise ArgumentError(f"dimensions must be {len(DIMENSIONS)} positive numbers of mm, got {numbers.tolist()}")
    model = read_released(Path(path))
    with torch.inference_mode():
        found = float(model(torch.from_numpy(picture)[None, None], torch.from_numpy(numbers)[None]))
    return found or LEAST_MASS_G
