"""The record of one mask by hand."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.detection import Detections
from corsmal.detection.rle import Size, checked_size, decode_mask, encode_masks, mask_areas, mask_box, run_lengths
from corsmal.errors import ArgumentError
from corsmal.parameters import CONTAINER_CLASSES

Mask = NDArray[np.bool_]

SOURCE = "by hand"
CUP = 47
WORDS_MAX = 200


@dataclass(frozen=True)
class HandMask:
    """A container's mask that a person drew, corrected or accepted.

    Args:
        frame: of the view's own video, from 0.
        size: (H, W) of the picture in pixels.
        counts: the visible pixels as compressed COCO run lengths; none set: no container is visible in the frame.
        amodal: the whole outline, what a hand hides included, likewise; None: it was not drawn.
        label: COCO number of the container's class.
        tool: what it was last changed with.
        who: the person's name; empty: unknown.
        when: the time of the change, UTC, ISO 8601.
        based_on: the detection that it began as, for people; empty: none.
        is_accepted: False for a mask that was propagated or proposed and that nobody has accepted: no estimate uses it.

    Raises:
        ArgumentError: the run lengths do not fit the size, the frame is negative, or the class is no container's.
    """

    frame: int
    size: Size
    counts: bytes
    amodal: bytes | None = None
    label: int = CUP
    tool: str = ""
    who: str = ""
    when: str = ""
    based_on: str = ""
    is_accepted: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", checked_size(self.size))
        if self.frame < 0:
            raise ArgumentError(f"frame must be a number from 0, got {self.frame}")
        if self.label not in CONTAINER_CLASSES:
            raise ArgumentError(f"label must be a container's class {sorted(CONTAINER_CLASSES)}, got {self.label}")
        for counts in (self.counts, self.amodal):
            if counts is not None:
                run_lengths(counts, self.size)

    @classmethod
    def of(cls, mask: Mask, *, frame: int, amodal: Mask | None = None, **facts: Any) -> "HandMask":
        """The record of (H, W) bool masks; ``facts`` are the class's other arguments."""
        counts = encode_masks(mask[None])[0]
        whole = None if amodal is None else encode_masks(amodal[None])[0]
        return cls(frame, mask.shape[:2], counts, whole, **facts)

    @property
    def mask(self) -> Mask:
        """The visible pixels, (H, W) bool, decoded on each access."""
        return decode_mask(self.counts, self.size)

    @property
    def amodal_mask(self) -> Mask | None:
        """The whole outline, (H, W) bool, decoded on each access; None where it was not drawn."""
        return None if self.amodal is None else decode_mask(self.amodal, self.size)

    @cached_property
    def area(self) -> int:
        """The number of visible pixels."""
        return int(mask_areas([self.counts], self.size)[0])

    def detections(self) -> Detections:
        """The mask as the only detection of its frame, of score 1; none where no pixel is set."""
        box = mask_box(self.counts, self.size)
        if box is None:
            return Detections.from_counts((), (), (), (), size=self.size)
        x, y, width, height = box
        corners = [[x, y, x + width, y + height]]
        return Detections.from_counts(corners, [1.0], [self.label], [self.counts], size=self.size)


def mask_sentences(mask: Mask, amodal: Mask | None = None) -> tuple[str, ...]:
    """What a person should know of an (H, W) mask: it is empty, in parts, or reaches beyond its whole outline."""
    if not mask.any():
        return ("The mask is empty: it says that no container is visible in this frame.",)
    found = []
    left, top, width, height = cv2.boundingRect(mask.view(np.uint8))
    part = np.ascontiguousarray(mask[top : top + height, left : left + width]).view(np.uint8)
    pieces, _, statistics, _ = cv2.connectedComponentsWithStats(part, connectivity=8)
    if pieces > 2:
        areas = sorted((int(area) for area in statistics[1:, cv2.CC_STAT_AREA]), reverse=True)
        shown = ", ".join(f"{area:,}" for area in areas[:4]) + (", …" if len(areas) > 4 else "")
        found.append(
            f"The mask has {len(areas)} parts ({shown} px): it is kept; the hull's centre is that of the largest."
        )
    if amodal is not None and (outside := int(np.count_nonzero(mask & ~amodal))):
        found.append(f"{outside:,} visible pixels lie outside the whole outline.")
    return tuple(found)
