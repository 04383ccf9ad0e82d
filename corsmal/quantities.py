"""What is estimated of a recording, each quantity once: its name, label, unit, digits, metric and columns."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Quantity:
    """One quantity of a recording, in the words of every table, file and page.

    Args:
        name: field of an estimate and of an annotation, and their tables' column; ends in the unit.
        label: for people, such as a heading.
        unit: ``mL``, ``mm`` or ``g``; empty for a class.
        digits: after the decimal point, where the quantity itself is shown.
        metric: column of Table 2, ending in ``_mape`` or ``_mpf1``.
        error_column: column of the error table behind the metric: the signed error in %, or the predicted class.
        submission_column: of the challenge's file.
        stage: that the quantity comes from, which is also the page that explains it.
    """

    name: str
    label: str
    unit: str
    digits: int
    metric: str
    error_column: str
    submission_column: str
    stage: Literal["filling", "shape", "mass"]

    @property
    def is_class(self) -> bool:
        """Whether it is a class, judged by MPF1, and not a number, judged by MAPE."""
        return not self.unit

    @property
    def words(self) -> str:
        """What it is in the middle of a sentence, such as ``filling type`` or ``container mass``."""
        label = self.label.lower()
        return f"{self.stage} {label}" if self.is_class else f"container {label}" if self.stage == "mass" else label

    def text(self, value: float | None) -> str:
        """A value with its unit, as people read it."""
        return "unknown" if value is None else f"{value:,.{self.digits}f} {self.unit}".rstrip()


def _number(name: str, label: str, stage: Literal["shape", "mass"], submission_column: str) -> Quantity:
    stem, _, unit = name.rpartition("_")
    metric = f"{'mass' if stage == 'mass' else stem}_mape"
    shown = {"ml": "mL", "mm": "mm", "g": "g"}[unit]
    return Quantity(name, label, shown, 0, metric, f"{stem}_error_percent", submission_column, stage)


QUANTITIES = (
    Quantity("filling_level", "Level", "", 0, "filling_level_mpf1", "filling_level", "Filling level", "filling"),
    Quantity("filling_type", "Type", "", 0, "filling_type_mpf1", "filling_type", "Filling type", "filling"),
    _number("capacity_ml", "Capacity", "shape", "Container capacity"),
    _number("width_top_mm", "Top width", "shape", "Width at the top"),
    _number("width_bottom_mm", "Bottom width", "shape", "Width at the bottom"),
    _number("height_mm", "Height", "shape", "Height"),
    _number("container_mass_g", "Mass", "mass", "Container mass"),
)
"""All that the paper's Table 2 judges, in its order."""

BY_NAME = {quantity.name: quantity for quantity in QUANTITIES}
BY_METRIC = {quantity.metric: quantity for quantity in QUANTITIES}

GEOMETRY = tuple(quantity.name for quantity in QUANTITIES if quantity.stage == "shape")
"""What the hull gives: capacity, then the dimensions."""

DIMENSIONS = GEOMETRY[1:]
"""Top width, bottom width and height: with the mask, what the mass is predicted from."""

MEASURED = (*GEOMETRY, "container_mass_g")
"""The numbers, of which the training set's means stand in where nothing could be fitted."""

CLASSES = tuple(quantity.name for quantity in QUANTITIES if quantity.is_class)
"""Filling level and type."""


def duration_text(seconds: float) -> str:
    """How long something takes, as people read it."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
