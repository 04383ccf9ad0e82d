"""The record of one view's detections, frame by frame."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from corsmal.detection.record import Detections
from corsmal.detection.rle import Size, checked_size
from corsmal.errors import ArgumentError, NotFoundError


class _NotInspectedError(NotFoundError, KeyError):
    """A mapping's look-up must fail with a KeyError for ``in`` and ``get`` to work."""

    __str__ = Exception.__str__


@dataclass(frozen=True, eq=False, repr=False)
class ViewDetections(Mapping[int, Detections]):
    """The detections of one view of one recording: a mapping from frame to ``Detections``.

    It holds every frame that was inspected, those without a detection included.

    Args:
        by_frame: frame number (from 0) to that frame's detections.
        size: (H, W) of the images in pixels.
        source: where the detections come from, for people, such as ``Mask R-CNN, COCO weights``.
        problems: sentences about what could not be used or done.

    Raises:
        ArgumentError: a frame number is negative or a frame's detections have another size.
    """

    by_frame: Mapping[int, Detections]
    size: Size = field(kw_only=True)
    source: str = field(kw_only=True)
    problems: tuple[str, ...] = field(kw_only=True, default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", checked_size(self.size))
        object.__setattr__(self, "problems", tuple(self.problems))
        object.__setattr__(self, "by_frame", {int(frame): self.by_frame[frame] for frame in sorted(self.by_frame)})
        for frame, detections in self.by_frame.items():
            if frame < 0:
                raise ArgumentError(f"by_frame must hold frame numbers from 0, got {frame}")
            if detections.size != self.size:
                raise ArgumentError(f"the masks of frame {frame} must have size {self.size}, got {detections.size}")

    @property
    def frames(self) -> tuple[int, ...]:
        """The inspected frames in ascending order."""
        return tuple(self.by_frame)

    def __getitem__(self, frame: int) -> Detections:
        try:
            return self.by_frame[frame]
        except KeyError:
            raise _NotInspectedError(
                f"frame {frame} was not inspected, {len(self)} frames were ({self.source})"
            ) from None

    def __iter__(self) -> Iterator[int]:
        return iter(self.by_frame)

    def __len__(self) -> int:
        return len(self.by_frame)

    def __repr__(self) -> str:
        return f"ViewDetections(frames={len(self)}, size={self.size}, source={self.source!r})"
