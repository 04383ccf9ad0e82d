"""What restoring, training and predicting pass on."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from corsmal.errors import ArgumentError
from corsmal.mass.axis import Axis, Mask


@dataclass(frozen=True, eq=False)
class RestoredMask:
    """A container's mask after restoration.

    Args:
        mask: (H, W) bool, the mask with what was added, in the image that it came from.
        crop: (x0, y0, x1, y1) pixels of the padded box that was restored, x1 and y1 excluded, within the image.
        axis: the axis of symmetry in the image; None where none was found.
        added: (H, W) bool, the pixels that joined the mask.
        reason: why nothing could be restored; empty if it could.
        notes: one sentence for everything that may have spoilt the axis.
    """

    mask: Mask
    crop: tuple[int, int, int, int]
    axis: Axis | None
    added: Mask
    reason: str = ""
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.mask.shape != self.added.shape or self.mask.dtype != np.bool_ or self.added.dtype != np.bool_:
            raise ArgumentError("mask and added must be bool images of the same shape")
        if self.ok and self.axis is None:
            raise ArgumentError("a restored mask without an axis must give a reason")

    @property
    def ok(self) -> bool:
        """Whether there is an axis about which the mask was restored."""
        return not self.reason

    @property
    def cropped(self) -> Mask:
        """The restored mask within the padded box, a view; without pixels where the mask was empty."""
        x0, y0, x1, y1 = self.crop
        return self.mask[y0:y1, x0:x1]

    @classmethod
    def failed(cls, mask: Mask, crop: tuple[int, int, int, int], reason: str) -> "RestoredMask":
        """The mask as it was, with the reason."""
        return cls(mask, crop, None, np.zeros_like(mask), reason)


@dataclass(frozen=True, eq=False)
class MassPrediction:
    """What the network says about one container.

    Args:
        mass_g: grams, not negative; None where there is no prediction.
        reason: why there is none; empty if there is one.
        restored: the restored mask.
        network_input: (112, 112) float32, 0..1, the image that the network sees; None where the mask is empty.
        notes: sentences on what stands in for the network's answer.
    """

    mass_g: float | None
    reason: str
    restored: RestoredMask
    network_input: NDArray[np.float32] | None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if (self.mass_g is None) == self.ok:
            raise ArgumentError("a prediction must have either a mass or a reason")

    @property
    def ok(self) -> bool:
        """Whether there is a mass."""
        return not self.reason


class PredictsMass(Protocol):
    """What tells a container's mass from its mask and dimensions, such as ``MassPredictor``."""

    def predict(
        self,
        mask: Mask,
        *,
        width_top_mm: float | None,
        width_bottom_mm: float | None,
        height_mm: float | None,
        mm_per_px: float | None = None,
    ) -> MassPrediction:
        """The mass of the container that a mask shows.

        Args:
            mask: (H, W) bool, its visible pixels in the robot's view.
            width_top_mm: mm, None where it is not known; likewise the others.
            width_bottom_mm: mm.
            height_mm: mm.
            mm_per_px: mm that a pixel of the mask spans at the container.
        """


@dataclass(frozen=True, eq=False)
class MassRow:
    """One recording, or one frame of it, to train on or to judge by.

    Args:
        recording_id: rows of one recording stay together when a set is split.
        container: which container; the split is made within each.
        mask: (H, W) bool, its visible pixels.
        width_top_mm: measured, mm, None where the fit failed; likewise the others.
        mm_per_px: mm that a pixel of the mask spans at the container.
        mass_g: the truth, grams.

    Raises:
        ArgumentError: the mass is not a positive number.
    """

    recording_id: str
    container: str
    mask: Mask
    width_top_mm: float | None
    width_bottom_mm: float | None
    height_mm: float | None
    mm_per_px: float | None
    mass_g: float

    def __post_init__(self) -> None:
        if not 0 < self.mass_g < np.inf:
            raise ArgumentError(f"mass_g must be a positive number of grams, got {self.mass_g!r}")
