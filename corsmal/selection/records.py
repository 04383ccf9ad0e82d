"""What the views of a pair show in a frame, and which of its frames is the best."""

from dataclasses import dataclass

from corsmal.parameters import CentreRule, Pair


@dataclass(frozen=True)
class FrameScore:
    """What the views of a pair show in one frame.

    Args:
        frame: frame index.
        mask_pixels: N of each view's container, pixels; None where the view has no container.
        penalties: TP of each view, pixels (equation 3).
        is_shared: whether each view's score is less by the penalties of all views (equation 4), or by its own only.
        obstacles: why the frame does not count although there is a container, by view; empty where it does.
    """

    frame: int
    mask_pixels: tuple[int | None, ...]
    penalties: tuple[float, ...]
    is_shared: bool = True
    obstacles: tuple[str, ...] = ()

    @property
    def view_scores(self) -> tuple[float | None, ...]:
        """S of each view, pixels (equation 4); None where the view has no container."""
        shared = sum(self.penalties)
        taken = (shared if self.is_shared else own for own in self.penalties)
        return tuple(
            None if pixels is None else pixels - penalty
            for pixels, penalty in zip(self.mask_pixels, taken, strict=True)
        )

    @property
    def total_penalty(self) -> float:
        """What the pair's score is less than the views' mask pixels."""
        return (len(self.penalties) if self.is_shared else 1) * sum(self.penalties)

    @property
    def total(self) -> float | None:
        """The pair's score, pixels (equation 5); None unless all views have a container and the frame counts."""
        pixels = [each for each in self.mask_pixels if each is not None]
        if any(self.obstacles) or len(pixels) < len(self.mask_pixels):
            return None
        return sum(pixels) - self.total_penalty


@dataclass(frozen=True)
class BestFrame:
    """The best frame of one pair of views, and the scores of all frames that count under the rule that was used.

    Args:
        pair: the two views.
        frame: index of the best frame, None if there is none.
        centre_rule: the rung of the ladder that the scores were computed with.
        scores: one per frame that was inspected in both views, by frame index.
        reason: why no frame has a score; empty if one has.
        is_by_fit: whether an estimate took this frame because it explains it best, instead of for its score.
    """

    pair: Pair
    frame: int | None
    centre_rule: CentreRule
    scores: tuple[FrameScore, ...]
    reason: str = ""
    is_by_fit: bool = False

    @property
    def ok(self) -> bool:
        """Whether there is a best frame."""
        return self.frame is not None

    @property
    def is_fallback(self) -> bool:
        """Whether the frame is taken because none has a score."""
        return self.ok and bool(self.reason)

    @property
    def score(self) -> FrameScore | None:
        """The best frame's score."""
        return next((score for score in self.scores if score.frame == self.frame), None)
