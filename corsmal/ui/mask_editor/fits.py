"""The hull of the edited frame: from the detected masks, and from those by hand as they are now."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.detection.rle import decode_mask, run_lengths
from corsmal.errors import CorsmalError, NotFoundError
from corsmal.estimation import Fit, fit_masks
from corsmal.geometry import Camera
from corsmal.parameters import CentreRule, Pair, ShapeParameters
from corsmal.shape import silhouettes
from corsmal.ui.caching import cached
from corsmal.ui.mask_editor.edited import EditedFrame
from corsmal.ui.opened import OpenedRecording

Outlines = list[list[list[int]]]
ANYWHERE: CentreRule = "none"
"""A mask by hand counts wherever it is in the picture."""


@dataclass(frozen=True)
class HandMasks:
    """Cameras and masks of one frame: those by hand, accepted or not, else the detected ones.

    Args:
        opened: the recording with its detected masks.
        counts: masks by hand as run lengths, by view.
    """

    opened: OpenedRecording
    counts: tuple[tuple[str, bytes], ...]

    def camera(self, view: str) -> Camera:
        """See ``MaskSource``."""
        return self.opened.camera(view)

    def mask(self, view: str, frame: int, centre_rule: CentreRule) -> NDArray[np.bool_]:
        """See ``MaskSource``."""
        drawn = dict(self.counts).get(view)
        if drawn is None:
            return self.opened.mask(view, frame, centre_rule)
        width, height = self.opened.video(view).size
        mask = decode_mask(drawn, (height, width))
        if not mask.any():
            raise NotFoundError(f"the mask by hand of {view} in frame {frame} is empty")
        return mask


def fits_of(edited: Mapping[str, EditedFrame], pair: Pair, shape: ShapeParameters) -> tuple[Fit, Fit]:
    """The fit of a frame with its detected masks, and with those by hand where there are any.

    Args:
        edited: the frame in all views of the method that the recording has, by view.
        pair: the two views.
        shape: parameters of the fit.
    """
    counts = []
    for view, each in edited.items():
        try:
            mask = each.history.mask
        except CorsmalError:
            mask = None
        if mask is not None:
            counts.append((view, mask.counts))
    some = next(iter(edited.values()))
    detected = _fit(some.opened, pair, some.frame, shape, ())
    return detected, _fit(some.opened, pair, some.frame, shape, tuple(counts)) if counts else detected


@cached(64)
def _fit(
    opened: OpenedRecording, pair: Pair, frame: int, shape: ShapeParameters, counts: tuple[tuple[str, bytes], ...]
) -> Fit:
    source = HandMasks(opened, counts)
    return fit_masks(source, pair=pair, frame=frame, centre_rule=ANYWHERE, shape=shape)


def hull_outlines(opened: OpenedRecording, fit: Fit) -> dict[str, Outlines]:
    """The outline of a fit's hull in each view, in pixels; empty where nothing fitted."""
    cameras = opened.cameras
    if not fit.hull.ok:
        return {}
    masks = silhouettes(fit.hull, list(cameras.values()))
    return {view: outlines(mask) for view, mask in zip(cameras, masks, strict=True)}


def outlines(mask: NDArray[np.bool_]) -> Outlines:
    """The outer outlines of an (H, W) mask, through the middles of its pixels at the edge."""
    left, top, width, height = cv2.boundingRect(mask.view(np.uint8))
    part = np.ascontiguousarray(mask[top : top + height, left : left + width]).view(np.uint8)
    if not part.size:
        return []
    found, _ = cv2.findContours(part, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE, offset=(left, top))
    return [(contour[:, 0] + 0.5).tolist() for contour in found]


@lru_cache(maxsize=64)
def detected_outlines(counts: bytes, size: tuple[int, int]) -> Outlines:
    """``outlines`` of a mask of run lengths, which strokes do not change."""
    return outlines(decode_mask(counts, size))


def plain_runs(counts: bytes, size: tuple[int, int]) -> list[int]:
    """Run lengths, column by column, as the browser draws them."""
    return [int(run) for run in run_lengths(counts, size)]
