"""What fitting and measuring return. A fit that failed is a record with a reason, never NaN."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from corsmal.errors import ArgumentError
from corsmal.notebook import outline_svg, record_html


@dataclass(frozen=True, eq=False)
class Hull:
    """A solid of revolution, or a box, as circumferences from the lowest to the highest.

    Args:
        heights_mm: (L,) heights of the circumferences along the axis, ascending, mm: world z where it is vertical; at
            ``centroid_m`` the height is that point's z.
        radii_mm: (L,) radii, mm, of a box half its width; r_min where ``converged`` is false.
        converged: (L,) bool, whether some radius fitted.
        centroid_m: (3,) a point that the axis passes through, metres: of the paper's hull the triangulated centroid;
            None if there is none.
        reason: why there is no hull; empty if there is one. A failed hull has L = 0.
        direction: (3,) unit vector of the axis, upwards.
        depth_mm: a box's other horizontal size, mm, not larger than its width; None for a solid of revolution.
        yaw: a box's turn about its axis, radians: of its width from the x axis.
        overlap: how well the silhouettes of the hull agree with the masks, intersection over union, mean of the
            views; None where it was not computed.
        view_weights: (V,) how much each view that it was fitted to counts, 1 for the best, 0 for one that was left out;
            empty where all count alike.
        box_gain: by how much the overlap of a box exceeds that of a solid of revolution; None where no box was fitted.
        evidence: what ``error_pct`` is predicted from, by name, see ``corsmal.shape.quality``; it is not kept.
        error_pct: predicted error of what is measured of it, mean of the four quantities, in %; None where nothing
            predicts it.
    """

    heights_mm: NDArray[np.float64]
    radii_mm: NDArray[np.float64]
    converged: NDArray[np.bool_]
    centroid_m: NDArray[np.float64] | None
    reason: str = ""
    direction: NDArray[np.float64] = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    depth_mm: float | None = None
    yaw: float = 0.0
    overlap: float | None = None
    view_weights: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    box_gain: float | None = None
    evidence: Mapping[str, float] = field(default_factory=dict)
    error_pct: float | None = None

    def __post_init__(self) -> None:
        if not self.heights_mm.shape == self.radii_mm.shape == self.converged.shape:
            raise ArgumentError("heights_mm, radii_mm and converged must have the same shape (L,)")
        if self.ok and self.centroid_m is None:
            raise ArgumentError("a hull without a centroid must give a reason")

    @property
    def ok(self) -> bool:
        """Whether circumferences were fitted at all; whether any of them converged is for ``converged`` to say."""
        return not self.reason

    def _repr_html_(self) -> str:
        """What a notebook shows: its outline, and how much of it was fitted."""
        heights_mm, radii_mm = self.heights_mm[self.converged], self.radii_mm[self.converged]
        facts = {"fitted": f"{len(heights_mm)} of {len(self.heights_mm)} circumferences", "failed": self.reason}
        if len(heights_mm):
            facts["heights"] = f"{heights_mm[0]:.0f} to {heights_mm[-1]:.0f} mm"
            facts["radii"] = f"{radii_mm.min():.1f} to {radii_mm.max():.1f} mm"
        if self.depth_mm is not None:
            facts["depth"] = f"{self.depth_mm:.0f} mm"
        if self.overlap is not None:
            facts["overlap with the masks"] = f"{100 * self.overlap:.1f} %"
        if self.error_pct is not None:
            facts["predicted error"] = f"{self.error_pct:.0f} %"
        kind = "solid of revolution" if self.depth_mm is None else "box"
        return record_html(f"Hull, {kind}", facts, picture=outline_svg(heights_mm.tolist(), radii_mm.tolist()))

    @classmethod
    def failed(cls, reason: str, *, centroid_m: NDArray[np.float64] | None = None) -> "Hull":
        """A hull of no circumferences, with the reason."""
        return cls(np.empty(0), np.empty(0), np.empty(0, dtype=bool), centroid_m, reason)


@dataclass(frozen=True, eq=False)
class Dimensions:
    """What a hull says about its container. All four quantities are None when the fit failed, a width maybe by itself.

    Args:
        capacity_ml: volume of the frusta between converged circumferences, mL.
        width_top_mm: diameter at the upper end of the profile, mm.
        width_bottom_mm: diameter at the lower end of the profile, mm.
        height_mm: distance between the two ends, mm.
        reason: why the fit failed; empty if it did not.
        kept: (n',) indices of the circumferences that smoothing kept, ascending.
        bottom: index of the circumference at the lower end (i_b), None if the fit or its width failed.
        top: index of the circumference at the upper end (i_t), likewise.
        unmeasured: why a width is None although the fit did not fail, by quantity.
    """

    capacity_ml: float | None = None
    width_top_mm: float | None = None
    width_bottom_mm: float | None = None
    height_mm: float | None = None
    reason: str = ""
    kept: NDArray[np.intp] = field(default_factory=lambda: np.empty(0, dtype=np.intp))
    bottom: int | None = None
    top: int | None = None
    unmeasured: Mapping[str, str] = field(default_factory=dict)

    @property
    def ok(self) -> bool:
        """Whether the fit did not fail: the four quantities are there, apart from those that are ``unmeasured``."""
        return not self.reason
