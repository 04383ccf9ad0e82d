"""What the network is given: the restored crop as a small square image, and the numbers beside it."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.mass.network import SIDE_PX, Interpolation, MassConfig, Resize
from corsmal.mass.records import MassPrediction, RestoredMask
from corsmal.mass.restoration import restore_mask
from corsmal.notes import Note

Floats = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class MassInput:
    """A mask and dimensions in the network's form.

    Args:
        restored: the restored mask.
        image: (112, 112) float32, 0..1; None where the mask is empty.
        numbers: top width, bottom width and height in mm, with the scale where the network wants it; empty where any
            of them cannot be used.
        reason: why the network cannot be asked; empty if it can.
    """

    restored: RestoredMask
    image: Floats | None
    numbers: tuple[float, ...]
    reason: str = ""

    def weighed(self, answer_g: float, config: MassConfig) -> MassPrediction:
        """What a network's answer in grams comes to: no container weighs 0 g, so the least known mass stands in."""
        if answer_g > 0:
            return MassPrediction(answer_g, "", self.restored, self.image)
        problem = "the network's output is 0 g"
        if config.least_mass_g is None:
            reason = f"{problem}, and its file does not say the least mass that it was trained on"
            return MassPrediction(None, reason, self.restored, self.image)
        note = Note(f"{problem}: the least mass of its training set stands in", flag="mass-assumed")
        return MassPrediction(config.least_mass_g, "", self.restored, self.image, (note,))


def mass_input(
    mask: NDArray[np.bool_],
    *,
    config: MassConfig,
    width_top_mm: float | None,
    width_bottom_mm: float | None,
    height_mm: float | None,
    mm_per_px: float | None = None,
) -> MassInput:
    """Restore a mask and bring it and the dimensions into the network's form; see ``MassPredictor.predict``.

    Returns:
        The input; with a ``reason`` where the mask is empty or a number is missing or not positive. A mask that could
        not be restored is taken as it is.

    Raises:
        ArgumentError: as ``restore_mask``.
    """
    restored = restore_mask(mask, padding_px=config.padding_px, axis=config.axis)
    if not restored.cropped.size:
        return MassInput(restored, None, (), restored.reason)
    image, scale = square_image(restored.cropped, resize=config.resize, interpolation=config.interpolation)
    values = {"width_top_mm": width_top_mm, "width_bottom_mm": width_bottom_mm, "height_mm": height_mm}
    if config.with_scale:
        values["mm_per_px"] = mm_per_px
    for name, value in values.items():
        if value is None:
            return MassInput(restored, image, (), f"{name} is missing")
        if not 0 < value < math.inf:
            return MassInput(restored, image, (), f"{name} must be positive, got {value:g}")
    numbers = [float(value) for value in values.values() if value is not None]
    if config.with_scale:
        numbers[-1] /= scale
    return MassInput(restored, image, tuple(numbers))


def square_image(
    cropped: NDArray[np.bool_], *, resize: Resize, interpolation: Interpolation = "area"
) -> tuple[Floats, float]:
    """A crop (h, w) as the network's image, and the scale, image pixels per crop pixel.

    The scale of a stretched crop is the geometric mean of both directions'.

    Returns:
        (112, 112) float32, 0..1, each pixel the share of mask pixels that it covers, or with ``linear`` between the
        four nearest; and the scale.
    """
    height, width = cropped.shape
    if resize == "stretch":
        size, scale = (SIDE_PX, SIDE_PX), SIDE_PX / math.sqrt(height * width)
    else:
        scale = SIDE_PX / max(height, width)
        size = (max(1, round(width * scale)), max(1, round(height * scale)))
    method = cv2.INTER_AREA if interpolation == "area" else cv2.INTER_LINEAR
    small = cv2.resize(cropped.astype(np.float32), size, interpolation=method)
    image = np.zeros((SIDE_PX, SIDE_PX), np.float32)
    left, top = (SIDE_PX - size[0]) // 2, (SIDE_PX - size[1]) // 2
    image[top : top + size[1], left : left + size[0]] = small
    return image, scale
