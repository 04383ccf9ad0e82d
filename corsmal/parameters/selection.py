"""How detections are filtered and frames are scored, with named presets."""

import math
from dataclasses import dataclass, field
from typing import Literal, get_args

from corsmal.errors import ArgumentError, check_choice
from corsmal.fields import UNLESS_DEFAULT
from corsmal.parameters.views import CONTAINER_CLASSES

CentreRule = Literal["both thirds", "horizontal third", "none", "middle half"]
CENTRE_RULES: tuple[CentreRule, ...] = get_args(CentreRule)
"""Where the centre of a box must lie: in the middle third of both sides or of the width, anywhere, or between one and
three quarters of the width."""

LADDER: tuple[CentreRule, ...] = ("both thirds", "horizontal third", "none")
"""From the paper's rule to none at all; the next is tried where one leaves no frame."""

ScoreRule = Literal["overlaps", "union widths"]
MassFrame = Literal["fitted", "frontal"]


@dataclass(frozen=True)
class SelectionParameters:
    """How detections are filtered, which of them is the container, and how frames are scored (paper 3.1).

    Args:
        score_min: detections with a lower score are dropped.
        detections_max: how many are kept per frame at most, those with the highest scores.
        classes: COCO category numbers that count as a container.
        centre_rules: where the centre of a box must lie; the next rule is tried where one leaves no frame.
        place_weights: what the scores of the kept detections are multiplied by, in the order of their masks' rightmost
            pixels from left to right; a product is at most 1. Empty: scores stay as they are.
        interval_s: only one frame an interval of this length counts, and the last one; None: every inspected frame.
        object_score_min: a frame counts only where one of the ``detections_max`` objects with the highest scores, of
            any class and with at least this score, has its box centre in the middle third of both sides, in every
            view. None: a container in every view is enough.
        score_rule: ``overlaps``: penalties are the pixels that lie in two boxes of containers, each pair twice in both
            views' scores (equations 3 to 5). ``union widths``: the boxes are those of the objects of
            ``object_score_min``, a pair's penalty is the width of their union times the height of their overlap, and
            it counts once. Of equal scores the first wins with the former, the last with the latter.
        fallback_frame: the frame that is taken where none counts; None: then there is no best frame.
        mass_frame: whose mask the container's mass is predicted from: that of the ``fitted`` frame, or of the best
            frame of the ``frontal`` view by itself.
    """

    score_min: float = 0.5
    detections_max: int = 3
    classes: frozenset[int] = frozenset(CONTAINER_CLASSES)
    centre_rules: tuple[CentreRule, ...] = field(default=LADDER, metadata=UNLESS_DEFAULT)
    place_weights: tuple[float, ...] = field(default=(), metadata=UNLESS_DEFAULT)
    interval_s: float | None = field(default=None, metadata=UNLESS_DEFAULT)
    object_score_min: float | None = field(default=None, metadata=UNLESS_DEFAULT)
    score_rule: ScoreRule = field(default="overlaps", metadata=UNLESS_DEFAULT)
    fallback_frame: int | None = field(default=None, metadata=UNLESS_DEFAULT)
    mass_frame: MassFrame = field(default="fitted", metadata=UNLESS_DEFAULT)

    def __post_init__(self) -> None:
        for name, value in (("score_min", self.score_min), ("object_score_min", self.object_score_min)):
            if value is not None and not 0 <= value <= 1:
                raise ArgumentError(f"{name} must lie in 0..1, got {value}")
        if self.detections_max < 1:
            raise ArgumentError(f"detections_max must be at least 1, got {self.detections_max}")
        if not self.centre_rules:
            raise ArgumentError("centre_rules must hold at least one rule, got none")
        for rule in self.centre_rules:
            check_choice("centre_rules", rule, CENTRE_RULES)
        check_choice("score_rule", self.score_rule, get_args(ScoreRule))
        check_choice("mass_frame", self.mass_frame, get_args(MassFrame))
        if self.place_weights and len(self.place_weights) < self.detections_max:
            raise ArgumentError(
                f"place_weights must hold a weight for each of {self.detections_max} detections, "
                f"got {len(self.place_weights)}"
            )
        if not all(0 < weight < math.inf for weight in self.place_weights):
            raise ArgumentError(f"place_weights must be positive, got {self.place_weights}")
        if self.interval_s is not None and not 0 < self.interval_s < math.inf:
            raise ArgumentError(f"interval_s must be positive, got {self.interval_s}")
        if self.score_rule == "union widths" and self.object_score_min is None:
            raise ArgumentError("object_score_min must be given for the score rule 'union widths', got None")
        if self.fallback_frame is not None and self.fallback_frame < 0:
            raise ArgumentError(f"fallback_frame must not be negative, got {self.fallback_frame}")

    @property
    def is_of_containers(self) -> bool:
        """Whether a frame's score depends on the containers in it alone, as in the paper."""
        return self.score_rule == "overlaps" and self.object_score_min is None and not self.place_weights

    def counted_frames(self, *, fps: float, frames: int) -> tuple[int, ...] | None:
        """The frames of a recording that count, ascending; None: all.

        Args:
            fps: frames per second; 0 where nobody knows: then all count.
            frames: how many the recording has.
        """
        if self.interval_s is None or not fps > 0 or frames < 1:
            return None
        step = max(1, round(fps * self.interval_s))
        return tuple(sorted({*range(0, frames, step), frames - 1}))

    @classmethod
    def paper(cls) -> "SelectionParameters":
        """The paper's rules."""
        return cls()

    @classmethod
    def released(cls) -> "SelectionParameters":
        """The rules of the program that the paper's authors released."""
        return cls(
            centre_rules=("middle half",),
            place_weights=(0.5, 1.0, 1.5),
            interval_s=1.0,
            object_score_min=0.3,
            score_rule="union widths",
            fallback_frame=0,
            mass_frame="frontal",
        )
