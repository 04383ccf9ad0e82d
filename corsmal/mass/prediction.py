"""A container's mass from its mask, its dimensions and trained weights."""

from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from corsmal.dataset import TrainedOn
from corsmal.mass.files import read_mass
from corsmal.mass.inputs import MassInput, mass_input
from corsmal.mass.network import MassConfig
from corsmal.mass.records import MassPrediction
from corsmal.weights import choose_device, network_digest, read_training


class MassPredictor:
    """A trained network, for one mask at a time.

    Args:
        weights: safetensors written by ``save_mass``, or the authors' ``task4.pt``.
        device: such as ``cuda:0``; default: the CPU, which is quick enough.

    Raises:
        FileError: the file is absent, broken, or of something else.
        ArgumentError: there is no such device.

    Example:
        >>> predictor = MassPredictor(Path("mass.safetensors"))  # doctest: +SKIP
        >>> predictor.predict(mask, width_top_mm=98, width_bottom_mm=61, height_mm=119).mass_g  # doctest: +SKIP
    """

    def __init__(self, weights: Path, *, device: str | None = None) -> None:
        self._device = choose_device(device)
        self.model = read_mass(weights).to(self._device)
        self.name = f"mass network, weights {weights.name}"
        self.digest = network_digest("mass", weights)
        self.trained_on = TrainedOn.from_json(read_training(weights, "mass"))

    @property
    def config(self) -> MassConfig:
        """Of the network: among others how masks are restored for it, and whether it needs ``mm_per_px``."""
        return self.model.config

    def predict(
        self,
        mask: NDArray[np.bool_],
        *,
        width_top_mm: float | None,
        width_bottom_mm: float | None,
        height_mm: float | None,
        mm_per_px: float | None = None,
    ) -> MassPrediction:
        """The mass of the container that a mask shows.

        Args:
            mask: (H, W) bool, its visible pixels in the robot's view.
            width_top_mm: mm, None where the fit failed; likewise the others.
            width_bottom_mm: mm.
            height_mm: mm.
            mm_per_px: mm that a pixel of the mask spans at the container, see ``mm_per_pixel``; needed where
                ``config.with_scale``, else not used.

        Returns:
            The prediction; ``ok`` is false, with a reason, where the mask is empty, or a number that the network
            needs is missing or not positive. The restored mask and the network's image are there all the same. Where
            the network answers 0 g the least mass of its training set stands in, with a note.

        Raises:
            ArgumentError: the mask is not a bool image.
        """
        given = mass_input(
            mask,
            config=self.config,
            width_top_mm=width_top_mm,
            width_bottom_mm=width_bottom_mm,
            height_mm=height_mm,
            mm_per_px=mm_per_px,
        )
        if given.reason:
            return MassPrediction(None, given.reason, given.restored, given.image)
        return given.weighed(self._ask(given), self.config)

    @torch.inference_mode()
    def _ask(self, given: MassInput) -> float:
        image = torch.from_numpy(given.image)[None, None]  # (1, 1, 112, 112)
        numbers = torch.tensor([given.numbers], dtype=torch.float32)
        return float(self.model(image.to(self._device), numbers.to(self._device)))
