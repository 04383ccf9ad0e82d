"""The parameters of the fit that a page changes and an address holds: names, labels, ranges."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple, cast

from corsmal.errors import ArgumentError
from corsmal.parameters import HeightRange, HeightReference, Pair, read_pair

BETWEEN = "~"
"""What separates several values of a parameter in an address."""

HEIGHT_LIMIT_MM = 2000.0
PADDING_MAX_PX = 80
"""Around a restored mask's box."""


class Number(NamedTuple):
    """A number of the fit: its name in the address, its label, and its range on the page and in the address."""

    short: str
    label: str
    low: float
    high: float
    step: float
    unit: str = ""

    @property
    def kind(self) -> type[float]:
        """``int`` for whole numbers."""
        return type(self.step)

    def parse(self, text: str) -> float:
        """The number in an address."""
        value = read_number(text, whole=self.kind is int)
        if not self.low <= value <= self.high:
            raise ArgumentError(f"allowed range {self.low:g}–{self.high:g} {self.unit}".strip())
        return value


class Options(NamedTuple):
    """A rule of the fit: its name in the address, its label, and labels for what can be chosen."""

    short: str
    label: str
    options: Mapping[str, str]

    def parse(self, text: str) -> Any:
        """The rule in an address; for ``z``: what heights are measured from, and the range in mm."""
        if self.short != "z":
            return text
        reference, *offsets = text.split(":")
        if len(offsets) != 2:
            raise ArgumentError(f"expected {', '.join(f'{name}:LOW:HIGH' for name in self.options)} in mm")
        low, high = (read_number(offset, whole=False) for offset in offsets)
        if max(abs(low), abs(high)) > HEIGHT_LIMIT_MM:
            raise ArgumentError(f"allowed range ±{HEIGHT_LIMIT_MM:g} mm")
        return HeightRange(cast(HeightReference, reference), low, high)


class Pairs(NamedTuple):
    """The pairs of views that are tried: their name in the address and their label."""

    short: str
    label: str

    def parse(self, text: str) -> tuple[Pair, ...]:
        """The pairs in an address."""
        return tuple(map(read_pair, text.split(BETWEEN)))


class Switch(NamedTuple):
    """What a fit does or does not: its name in the address and its label."""

    short: str
    label: str

    def parse(self, text: str) -> bool:
        """The switch in an address."""
        if text not in ("True", "False"):
            raise ArgumentError("expected True or False")
        return text == "True"


PARAMETERS: dict[str, Number | Options | Switch | Pairs] = {
    "circumferences": Number("L", "L, circumferences", 10, 500, 1),
    "points": Number("N", "N, points per circumference", 3, 90, 1),
    "radii": Number("radii", "Radii tried", 10, 600, 1),
    "radius_max_mm": Number("rmax", "r_max", 10.0, 250.0, 0.5, "mm"),
    "radius_min_mm": Number("rmin", "r_min", 0.5, 9.5, 0.5, "mm"),
    "max_difference_mm": Number("dmax", "d_max", 0.0, 10.0, 0.05, "mm"),
    "fit_rule": Options(
        "fit", "A circumference must fit", {"any": "at least one view (paper)", "all": "both views (LoDE)"}
    ),
    "width_rule": Options(
        "width",
        "Widths",
        {
            "ends": "at the ends of the profile (paper)",
            "widest": "twice the largest radius (LoDE)",
            "whole": "first and last circumference (tuned)",
            "steps": "where steps between radii shrink (released)",
        },
    ),
    "height_rule": Options(
        "height",
        "Height",
        {"ends": "between the ends of the profile (paper)", "extent": "extent of all circumferences (released)"},
    ),
    "angle_rule": Options(
        "angles", "Angles of the points", {"circle": "over the full circle", "0-359": "0° to 359°, both (released)"}
    ),
    "pixel_rule": Options(
        "pixels", "Projected points", {"rounded": "rounded to pixels", "truncated": "truncated (released)"}
    ),
    "triangulation": Options(
        "system",
        "Triangulation of the centroid",
        {"unit rows": "equations of unit length", "plain rows": "equations as they are (released)"},
    ),
    "pairs": Pairs("pairs", "Pairs of views, in the order in which they are tried"),
    "height_range": Options(
        "z",
        "Heights measured from",
        {"masks": "the axis' extent in the masks", "world": "the table, z = 0", "centroid": "the centroid"},
    ),
    "tilt_deg": Number("tilt", "expected tilt", 0.0, 15.0, 0.5, "°"),
    "wall_mm": Number("wall", "wall", 0.0, 5.0, 0.1, "mm"),
    "boxes": Switch("boxes", "Also fit a box, and keep what agrees better with the masks"),
    "all_views": Switch("third", "Use the third view"),
}
"""The parameters of the fit that a page changes and an address holds, by field of ``ShapeParameters``."""


TYPED = {"width_top_mm": "w_t", "width_bottom_mm": "w_b", "height_mm": "h", "mm_per_px": "s", "capacity_ml": "C"}
"""The numbers that the mass depends on, by name: as formulas and the address have them."""

TYPED_LOW, TYPED_HIGH = 0.01, 20_000.0


def read_number(text: str, *, whole: bool) -> float:
    """A number in an address.

    Raises:
        ArgumentError: it is not a finite number, or not the whole one that is wanted.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or (whole and value != int(value)):
        raise ArgumentError(f"expected a {'whole' if whole else 'finite'} number")
    return int(value) if whole else value
