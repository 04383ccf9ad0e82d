"""How the hull is fitted and measured, with named presets."""

import math
from dataclasses import dataclass, field
from typing import Literal, get_args

from corsmal.errors import ArgumentError, check_choice
from corsmal.fields import UNLESS_DEFAULT
from corsmal.parameters.views import PAIRS, RELEASED_PAIRS, Pair, check_pairs

ShapeMethod = Literal["circumferences", "outlines"]
FitRule = Literal["any", "all"]
AngleRule = Literal["circle", "0-359"]
PixelRule = Literal["rounded", "truncated"]
Triangulation = Literal["unit rows", "plain rows"]
WidthRule = Literal["ends", "widest", "whole", "steps"]
HeightRule = Literal["ends", "extent"]
HeightReference = Literal["masks", "world", "centroid"]

RULES: dict[str, tuple[str, ...]] = {
    "fit_rule": get_args(FitRule),
    "width_rule": get_args(WidthRule),
    "method": get_args(ShapeMethod),
    "angle_rule": get_args(AngleRule),
    "pixel_rule": get_args(PixelRule),
    "triangulation": get_args(Triangulation),
    "height_rule": get_args(HeightRule),
}
"""The fields of ``ShapeParameters`` that choose one of several rules, and these."""

TILT_MAX_DEG, WALL_MAX_MM = 30.0, 10.0


@dataclass(frozen=True)
class HeightRange:
    """Where circumferences are placed along the vertical axis.

    Args:
        reference: what the two offsets are measured from. ``masks``: the lower and the upper end of the stretch where
            the axis projects into either mask; ``world``: the table's plane, z = 0; ``centroid``: the 3D centroid.
        low_mm: offset of the lowest circumference.
        high_mm: offset of the highest circumference.
    """

    reference: HeightReference = "masks"
    low_mm: float = -20.0
    high_mm: float = 20.0

    def __post_init__(self) -> None:
        check_choice("reference", self.reference, get_args(HeightReference))
        if not (math.isfinite(self.low_mm) and math.isfinite(self.high_mm) and self.low_mm < self.high_mm):
            raise ArgumentError(f"low_mm must be below high_mm, both finite, got {self.low_mm} and {self.high_mm}")


@dataclass(frozen=True)
class ShapeParameters:
    """How the hull is fitted and measured (paper 3.2 and Table 1).

    Args:
        circumferences: L, the number of equally spaced heights.
        points: N, points per circumference at equally spaced angles.
        radii: how many radii are tried, equally spaced from the largest to the smallest. The paper gives no step;
            145 values are the authors' program's.
        radius_max_mm: r_max.
        radius_min_mm: r_min; also the radius of a circumference that fits no view.
        max_difference_mm: d_max, the largest step between neighbouring radii that smoothing keeps.
        fit_rule: a radius is accepted when its circumference fits ``any`` view (the paper) or ``all`` (LoDE).
        width_rule: ``ends`` reads the widths at the ends of the profile (equations 7 and 8); ``widest`` takes twice
            the largest radius (LoDE); ``whole`` takes the first and the last circumference, for hulls that end where
            the container does; ``steps`` is the authors' program's, see ``corsmal.shape.steps``: each width may fail
            by itself.
        height_range: where the circumferences are placed. The paper does not say; default: the axis' own extent in
            the masks plus 20 mm at both ends.
        method: ``circumferences`` shrinks circles until they fit the masks (the paper, LoDE); ``outlines`` reads the
            radii from the masks' outlines and looks for the base and the rim. Points, radii, ``max_difference_mm``,
            ``fit_rule`` and ``height_range`` belong to the first, the following to the second, but ``wall_mm``.
        tilt_deg: how far the axis is expected to lean; 0: it is vertical.
        boxes: whether a box is fitted too, and taken where it explains the masks better.
        all_views: whether the third view joins a pair where it shows the container.
        frames: how many frames of a recording are fitted; an estimate is their median, weighted by how well each
            explains its masks.
        wall_mm: thickness of a round container's wall, which the capacity leaves out together with what is below a
            stem's narrowest place; 0: the capacity is the volume of the hull.
        pairs: the pairs of views in the order in which they are tried.
        angle_rule: the N points lie at equally spaced angles over the full ``circle``, or from 0° to 359°, both
            included (``0-359``, the authors' program): the last two are then close together.
        pixel_rule: which pixel a projected point falls on. ``rounded``: the nearest; outside of the image it is off
            the mask. ``truncated`` (the authors' program): coordinates are cut off towards zero, a pixel beyond the
            right or lower border is moved onto it, and one beyond the left or upper border is counted from the
            opposite one.
        triangulation: the rows of the linear system for the centroid have ``unit`` length, or are ``plain``, as the
            authors' program and OpenCV have them: these weight the views by their cameras' focal lengths and distances.
        height_rule: the height reaches between the ``ends`` of the profile: those of equations 7 and 8, with
            ``widest`` and ``whole`` the first and the last circumference; or it is the ``extent`` of the converged
            circumferences (the authors' program).
    """

    circumferences: int = 145
    points: int = 19
    radii: int = 145
    radius_max_mm: float = 75.0
    radius_min_mm: float = 2.5
    max_difference_mm: float = 1.0
    fit_rule: FitRule = "any"
    width_rule: WidthRule = "ends"
    height_range: HeightRange = field(default_factory=HeightRange)
    method: ShapeMethod = "circumferences"
    tilt_deg: float = 0.0
    boxes: bool = False
    all_views: bool = False
    frames: int = 1
    wall_mm: float = 0.0
    pairs: tuple[Pair, ...] = field(default=PAIRS, metadata=UNLESS_DEFAULT)
    angle_rule: AngleRule = field(default="circle", metadata=UNLESS_DEFAULT)
    pixel_rule: PixelRule = field(default="rounded", metadata=UNLESS_DEFAULT)
    triangulation: Triangulation = field(default="unit rows", metadata=UNLESS_DEFAULT)
    height_rule: HeightRule = field(default="ends", metadata=UNLESS_DEFAULT)

    def __post_init__(self) -> None:
        for name, least in (("circumferences", 2), ("points", 3), ("radii", 2), ("frames", 1)):
            if getattr(self, name) < least:
                raise ArgumentError(f"{name} must be at least {least}, got {getattr(self, name)}")
        if not 0 < self.radius_min_mm < self.radius_max_mm < math.inf:
            raise ArgumentError(
                "radii must satisfy 0 < radius_min_mm < radius_max_mm, "
                f"got {self.radius_min_mm} and {self.radius_max_mm}"
            )
        if not self.max_difference_mm >= 0:
            raise ArgumentError(f"max_difference_mm must not be negative, got {self.max_difference_mm}")
        for name, choices in RULES.items():
            check_choice(name, getattr(self, name), choices)
        check_pairs(self.pairs)
        if not 0 <= self.tilt_deg <= TILT_MAX_DEG:
            raise ArgumentError(f"tilt_deg must lie in 0..{TILT_MAX_DEG:g}, got {self.tilt_deg}")
        if not 0 <= self.wall_mm <= WALL_MAX_MM:
            raise ArgumentError(f"wall_mm must lie in 0..{WALL_MAX_MM:g}, got {self.wall_mm}")

    @property
    def ignored(self) -> frozenset[str]:
        """The fields that change nothing with this method; a profile is smoothed only where its ends are looked for."""
        if self.method == "outlines":
            radii = {"points", "radii", "radius_max_mm", "radius_min_mm", "angle_rule", "pixel_rule"}
            return frozenset({*radii, "max_difference_mm", "fit_rule", "height_range", "height_rule"})
        smoothed = self.width_rule in ("ends", "steps")
        return frozenset({"tilt_deg", "boxes"} | (set() if smoothed else {"max_difference_mm", "height_rule"}))

    @property
    def varied(self) -> tuple[str, ...]:
        """The numbers that are worth varying, the two that matter most first: not those that are ignored or off."""
        if self.method == "outlines":
            names: tuple[str, ...] = ("tilt_deg", "wall_mm", "frames", "circumferences")
        else:
            names = ("circumferences", "max_difference_mm", "points", "radii", "wall_mm", "frames")
        off = {name for name, value in (("wall_mm", 0.0), ("frames", 1)) if getattr(self, name) == value}
        return tuple(name for name in names if name not in self.ignored and (name not in off or name == names[1]))

    @classmethod
    def paper(cls) -> "ShapeParameters":
        """The paper's method with the values of Table 1."""
        return cls()

    @classmethod
    def lode(cls) -> "ShapeParameters":
        """LoDE (Xompero et al., ICASSP 2020): both views must agree, fixed range of heights, one width."""
        return cls(
            circumferences=500,
            fit_rule="all",
            width_rule="widest",
            height_range=HeightRange("world", -100.0, 400.0),
        )

    @classmethod
    def released(cls) -> "ShapeParameters":
        """The program that the paper's authors released, where it does otherwise than the paper's text says."""
        return cls(
            circumferences=500,
            height_range=HeightRange("world", -100.0, 400.0),
            width_rule="steps",
            pairs=RELEASED_PAIRS,
            angle_rule="0-359",
            pixel_rule="truncated",
            triangulation="plain rows",
            height_rule="extent",
        )

    @classmethod
    def tuned(cls) -> "ShapeParameters":
        """Outlines instead of circles, a leaning axis, boxes, all views, several frames, and the wall left out."""
        return cls(
            method="outlines",
            width_rule="whole",
            tilt_deg=3.0,
            boxes=True,
            all_views=True,
            frames=16,
            wall_mm=1.0,
        )
