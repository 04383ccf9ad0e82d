"""Profiles of the demo's vessels: the outer and the inner wall of solids of revolution.

A profile is a polyline of heights and radii; between neighbours the solid is a frustum of a cone. Each family of
shapes leaves one number free, and that number is solved for so that the cavity holds what is asked.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from corsmal.errors import ArgumentError
from corsmal.geometry import Floats

SOLVER_STEPS = 60
WALL_POINTS = 9
STEM_RADIUS_MM = 4.0
FOOT_HEIGHT_MM = 3.0


@dataclass(frozen=True, eq=False)
class Profile:
    """Radii over height of a solid of revolution.

    Args:
        heights_mm: (n,) ascending, n at least 2.
        radii_mm: (n,) not negative.
    """

    heights_mm: Floats
    radii_mm: Floats

    def __post_init__(self) -> None:
        for name in ("heights_mm", "radii_mm"):
            values = np.array(getattr(self, name), dtype=np.float64)
            values.flags.writeable = False
            object.__setattr__(self, name, values)
        if self.heights_mm.ndim != 1 or self.heights_mm.shape != self.radii_mm.shape or len(self.heights_mm) < 2:
            raise ArgumentError("heights_mm and radii_mm must have the same shape (n,), n at least 2")
        if (np.diff(self.heights_mm) <= 0).any() or (self.radii_mm < 0).any():
            raise ArgumentError("heights_mm must ascend and radii_mm must not be negative")

    @property
    def volume_ml(self) -> float:
        """The enclosed volume, by frusta of cones."""
        below, above = self.radii_mm[:-1], self.radii_mm[1:]
        return float(np.pi / 3 * (np.diff(self.heights_mm) * (below**2 + below * above + above**2)).sum() / 1000)

    def radius_at(self, height_mm: float) -> float:
        """The radius at a height, in mm; beyond the ends the nearest end's."""
        return float(np.interp(height_mm, self.heights_mm, self.radii_mm))

    def below(self, height_mm: float) -> "Profile":
        """The part under a height, which must lie above the lowest point."""
        kept = self.heights_mm < height_mm
        heights = np.append(self.heights_mm[kept], height_mm)
        return Profile(heights, np.append(self.radii_mm[kept], self.radius_at(height_mm)))

    def height_holding(self, volume_ml: float) -> float:
        """The height up to which the solid encloses a volume; the whole height where it holds less."""
        low, high = float(self.heights_mm[0]), float(self.heights_mm[-1])
        if volume_ml >= self.volume_ml:
            return high
        for _ in range(30):
            middle = (low + high) / 2
            low, high = (middle, high) if self.below(middle).volume_ml < volume_ml else (low, middle)
        return high


Walls = tuple[Profile, Profile]
"""The outer profile and that of the cavity."""


def solved(shape: Callable[[float], Walls], *, capacity_ml: float, limits: tuple[float, float]) -> Walls:
    """The member of a family of vessels whose cavity holds a capacity up to the brim.

    The family's free number lies within ``limits``, between which the capacity must rise or fall throughout.

    Raises:
        ArgumentError: the capacities of the family do not include this one.
    """
    low, high = limits
    ends = [shape(value)[1].volume_ml for value in (low, high)]
    if not min(ends) <= capacity_ml <= max(ends):
        raise ArgumentError(f"capacity_ml must lie in {min(ends):.0f}..{max(ends):.0f} here, got {capacity_ml}")
    rises = ends[1] > ends[0]
    for _ in range(SOLVER_STEPS):
        middle = (low + high) / 2
        too_small = shape(middle)[1].volume_ml < capacity_ml
        low, high = (middle, high) if too_small == rises else (low, middle)
    return shape((low + high) / 2)


def cup(power: float, *, top_mm: float, bottom_mm: float, height_mm: float, wall_mm: float, floor_mm: float) -> Walls:
    """A cup: radii from the bottom to the top go with a power of the height, 1 for a straight wall."""
    share = np.linspace(0, 1, WALL_POINTS)
    heights = share * height_mm
    radii = (bottom_mm + (top_mm - bottom_mm) * share**power) / 2
    outer = Profile(heights, radii)
    inner_heights = np.append(floor_mm, heights[heights > floor_mm + 0.5])
    return outer, Profile(inner_heights, np.interp(inner_heights, heights, radii) - wall_mm)


def stemmed(bowl: Profile, *, foot_mm: float, wall_mm: float) -> Walls:
    """A glass on a stem, from the outer profile of its bowl, whose heights are counted from the table."""
    start = bowl.heights_mm[0]
    foot_heights = np.array([0.0, FOOT_HEIGHT_MM * 0.6, FOOT_HEIGHT_MM, FOOT_HEIGHT_MM + 6, start * 0.5])
    foot_radii = np.array([foot_mm / 2, foot_mm / 2, foot_mm / 4, STEM_RADIUS_MM * 1.3, STEM_RADIUS_MM * 0.9])
    outer = Profile(np.append(foot_heights, bowl.heights_mm), np.append(foot_radii, bowl.radii_mm))
    inside = bowl.radii_mm > wall_mm + STEM_RADIUS_MM
    return outer, Profile(bowl.heights_mm[inside], bowl.radii_mm[inside] - wall_mm)


def tulip(widest_mm: float, *, start_mm: float, height_mm: float, top_mm: float) -> Profile:
    """A wine glass' bowl: round below, widest at 45 % of its height, drawn in towards the rim."""
    angle = np.linspace(0, np.pi / 2, 9)
    rising = STEM_RADIUS_MM + (widest_mm / 2 - STEM_RADIUS_MM) * np.sin(angle)
    closing = top_mm / 2 + (widest_mm - top_mm) / 2 * np.cos(angle[1:]) ** 1.3
    share = np.concatenate([0.45 * (1 - np.cos(angle)), 0.45 + 0.55 * angle[1:] / (np.pi / 2)])
    return Profile(start_mm + share * (height_mm - start_mm), np.concatenate([rising, closing]))


def trumpet(power: float, *, start_mm: float, height_mm: float, top_mm: float) -> Profile:
    """A bowl that opens towards the rim: 1 is a cone, a smaller power is fuller."""
    share = np.linspace(0, 1, 10) ** 2
    radii = STEM_RADIUS_MM + (top_mm / 2 - STEM_RADIUS_MM) * share**power
    return Profile(start_mm + share * (height_mm - start_mm), radii)


def double_bowl(neck_mm: float, *, start_mm: float, height_mm: float, top_mm: float) -> Profile:
    """A margarita glass' bowl: a small bowl that opens, at a width of ``neck_mm``, into a wide one."""
    angle = np.linspace(0, np.pi / 2, 6)
    lower = STEM_RADIUS_MM + (neck_mm / 2 - STEM_RADIUS_MM) * np.sin(angle)
    upper = neck_mm / 2 + (top_mm - neck_mm) / 2 * np.sin(angle[1:]) ** 0.8
    share = np.concatenate([0.45 * (1 - np.cos(angle)), 0.47 + 0.53 * (1 - np.cos(angle[1:]))])
    return Profile(start_mm + share * (height_mm - start_mm), np.concatenate([lower, upper]))
