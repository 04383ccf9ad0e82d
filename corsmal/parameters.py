"""Every number of the method, with named presets.

The numbers are those of the paper's Table 1 and section 3.1; where the paper is silent, the docstring says what was
chosen and why.
"""

import math
from dataclasses import dataclass, field
from typing import Literal, get_args

from corsmal.errors import ArgumentError, check_choice

CONTAINER_CLASSES = {44: "bottle", 46: "wine glass", 47: "cup", 84: "book", 86: "vase"}
"""COCO category numbers of the objects that are taken for a container (paper 3.1)."""

PAIRS = (("view3", "view1"), ("view3", "view2"))
"""The pairs of views in the order in which they are tried: the paper's (1, 2) and (1, 3), in the dataset's names."""

METHOD_VIEWS = tuple(dict.fromkeys(view for pair in PAIRS for view in pair))
"""The views that the method uses, in the order of its pairs."""

FRONTAL_VIEW = PAIRS[0][0]
"""The robot's own view, from which the container's mass is predicted."""

CentreRule = Literal["both thirds", "horizontal third", "none"]
CENTRE_RULES: tuple[CentreRule, ...] = get_args(CentreRule)
"""The ladder: where the centre of a box must lie, from the paper's rule to none at all."""

ShapeMethod = Literal["circumferences", "outlines"]
FitRule = Literal["any", "all"]
WidthRule = Literal["ends", "widest", "whole"]
HeightReference = Literal["masks", "world", "centroid"]


TILT_MAX_DEG, WALL_MAX_MM = 30.0, 10.0


@dataclass(frozen=True)
class SelectionParameters:
    """How detections are filtered before frames are scored (paper 3.1).

    Args:
        score_min: detections with a lower score are dropped.
        detections_max: how many are kept per frame at most, those with the highest scores.
        classes: COCO category numbers that count as a container.
    """

    score_min: float = 0.5
    detections_max: int = 3
    classes: frozenset[int] = frozenset(CONTAINER_CLASSES)

    def __post_init__(self) -> None:
        if not 0 <= self.score_min <= 1:
            raise ArgumentError(f"score_min must lie in 0..1, got {self.score_min}")
        if self.detections_max < 1:
            raise ArgumentError(f"detections_max must be at least 1, got {self.detections_max}")


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
        width_rule: ``ends`` reads widths and height at the ends of the profile (equations 7 and 8); ``widest`` takes
            twice the largest radius and the extent of the converged circumferences (LoDE); ``whole`` takes the first
            and the last circumference, for hulls that end where the container does.
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
        for name, choices in (("fit_rule", FitRule), ("width_rule", WidthRule), ("method", ShapeMethod)):
            check_choice(name, getattr(self, name), get_args(choices))
        if not 0 <= self.tilt_deg <= TILT_MAX_DEG:
            raise ArgumentError(f"tilt_deg must lie in 0..{TILT_MAX_DEG:g}, got {self.tilt_deg}")
        if not 0 <= self.wall_mm <= WALL_MAX_MM:
            raise ArgumentError(f"wall_mm must lie in 0..{WALL_MAX_MM:g}, got {self.wall_mm}")

    @property
    def ignored(self) -> frozenset[str]:
        """The fields that change nothing with this method; a profile is smoothed only where its ends are looked for."""
        if self.method == "outlines":
            radii = {"points", "radii", "radius_max_mm", "radius_min_mm"}
            return frozenset({*radii, "max_difference_mm", "fit_rule", "height_range"})
        return frozenset({"tilt_deg", "boxes"} | ({"max_difference_mm"} if self.width_rule != "ends" else set()))

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


SHAPE_PRESETS = {
    "paper": ShapeParameters.paper(),
    "lode": ShapeParameters.lode(),
    "tuned": ShapeParameters.tuned(),
}
