"""What is known about a recording: its container, and what was filled into it."""

from dataclasses import dataclass, fields
from typing import Literal

FILLINGS = ("none", "pasta", "rice", "water")
"""Names of the filling types 0 to 3."""

LEVELS = ("empty", "half", "full")
"""Names of the filling levels 0 to 2: nothing, 50 % and 90 % of the capacity."""

DENSITIES_G_PER_ML = (0.0, 0.34, 0.82, 1.0)
"""Mass per volume of the filling types."""

LEVEL_FRACTIONS = (0.0, 0.5, 0.9)
"""Shares of the capacity at the filling levels."""

Kind = Literal["cup", "glass", "box"]

CONTAINERS: dict[int, tuple[str, Kind]] = {
    1: ("red cup", "cup"),
    2: ("small white cup", "cup"),
    3: ("small transparent cup", "cup"),
    4: ("green glass", "glass"),
    5: ("wine glass", "glass"),
    6: ("champagne flute", "glass"),
    7: ("cereal box", "box"),
    8: ("biscuit box", "box"),
    9: ("tea box", "box"),
}
"""Name and kind of the training set's containers, by container id."""


@dataclass(frozen=True)
class Annotation:
    """What is known about one recording; None where it is not known.

    Args:
        container_id: the container's number, 1 to 9 in the training set.
        scenario: 0 to 2: container on the table; held, person sitting; held, person walking.
        depth_mm: depth of a box; None for round containers.
        filling_type: 0 to 3: none, pasta, rice, water.
        filling_level: 0 to 2: empty, half, full.
    """

    container_id: int | None = None
    container: str | None = None
    kind: Kind | None = None
    scenario: int | None = None
    background: int | None = None
    illumination: int | None = None
    width_top_mm: float | None = None
    width_bottom_mm: float | None = None
    height_mm: float | None = None
    depth_mm: float | None = None
    capacity_ml: float | None = None
    container_mass_g: float | None = None
    filling_type: int | None = None
    filling_level: int | None = None
    filling_density_g_per_ml: float | None = None
    filling_mass_g: float | None = None

    @property
    def filling(self) -> str | None:
        """Name of the filling type."""
        return None if self.filling_type is None else FILLINGS[self.filling_type]

    @property
    def level(self) -> str | None:
        """Name of the filling level."""
        return None if self.filling_level is None else LEVELS[self.filling_level]

    def facts(self) -> dict[str, str]:
        """What is known, for people, with units; what is not known is empty."""
        sizes = {
            "capacity": (self.capacity_ml, "mL"),
            "top width": (self.width_top_mm, "mm"),
            "bottom width": (self.width_bottom_mm, "mm"),
            "height": (self.height_mm, "mm"),
            "depth": (self.depth_mm, "mm"),
            "container mass": (self.container_mass_g, "g"),
            "filling mass": (self.filling_mass_g, "g"),
        }
        return {
            "container": self.container or "",
            "filling": ", ".join(text for text in (self.filling, self.level) if text),
            **{name: "" if value is None else f"{value:g} {unit}" for name, (value, unit) in sizes.items()},
        }


FIELDS = tuple(entry.name for entry in fields(Annotation))
"""The annotation's fields, in order."""
