"""The profile that a container is known to have, and how far a hull lies from it."""

from dataclasses import dataclass

import numpy as np

from corsmal.errors import ArgumentError
from corsmal.geometry import Floats
from corsmal.shape.records import Dimensions, Hull


@dataclass(frozen=True, eq=False)
class KnownProfile:
    """The outer radii of a container from its base to its rim.

    Args:
        heights_mm: (n,) above the base, ascending from 0, n at least 2, mm.
        radii_mm: (n,) half the width there, mm.
        source: what knows it, in words: ``true profile`` or ``annotated size``.
        base_mm: height of the base in the world, mm; None where only the shape is known.
    """

    heights_mm: Floats
    radii_mm: Floats
    source: str
    base_mm: float | None = None

    def __post_init__(self) -> None:
        heights, radii = (np.asarray(values, dtype=np.float64) for values in (self.heights_mm, self.radii_mm))
        if heights.ndim != 1 or heights.shape != radii.shape or len(heights) < 2:
            raise ArgumentError("heights_mm and radii_mm must have the same shape (n,), n at least 2")
        if heights[0] != 0 or not (np.diff(heights) > 0).all() or not (radii >= 0).all():
            raise ArgumentError("heights_mm must ascend from 0, and radii_mm must not be negative")
        object.__setattr__(self, "heights_mm", heights)
        object.__setattr__(self, "radii_mm", radii)

    @classmethod
    def frustum(cls, bottom_mm: float, top_mm: float, height_mm: float) -> "KnownProfile":
        """The profile between two annotated widths, straight, mm."""
        return cls(np.array([0, height_mm]), np.array([bottom_mm, top_mm]) / 2, "annotated size")

    def base_of(self, hull: Hull, dimensions: Dimensions) -> float | None:
        """World height of the base, mm: where it is known, else the hull's lower end; None where there is neither."""
        if self.base_mm is not None or dimensions.bottom is None:
            return self.base_mm
        return float(hull.heights_mm[dimensions.bottom])

    def errors_mm(self, hull: Hull, *, base_mm: float) -> Floats:
        """(L,) signed distances of a hull's circumferences from the profile, mm, positive outside.

        Between base and rim the difference of the radii; below and above, the distance to the base or the rim.

        Args:
            hull: the fitted hull.
            base_mm: world height of the base.
        """
        heights_mm = hull.heights_mm - base_mm
        within_mm = np.clip(heights_mm, 0.0, self.heights_mm[-1])
        wider_mm = hull.radii_mm - np.interp(within_mm, self.heights_mm, self.radii_mm)
        beyond_mm = np.abs(heights_mm - within_mm)
        return np.where(beyond_mm > 0, np.hypot(beyond_mm, np.maximum(wider_mm, 0.0)), wider_mm)
