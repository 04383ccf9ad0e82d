"""The hull of one pair of views in one frame, measured."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset import Recording
from corsmal.errors import ArgumentError, FileError, NotFoundError
from corsmal.estimation.detected import container_mask
from corsmal.geometry import Camera
from corsmal.parameters import METHOD_VIEWS, CentreRule, SelectionParameters, ShapeParameters
from corsmal.selection import FrameDetections, Pair
from corsmal.shape import Dimensions, Hull, fit_agreeing, measure_hull


class MaskSource(Protocol):
    """Where a fit finds the cameras and the masks of a recording."""

    def camera(self, view: str) -> Camera:
        """A view's camera.

        Raises:
            NotFoundError: the recording has no such view.
            FileError: its calibration cannot be read.
        """

    def mask(self, view: str, frame: int, centre_rule: CentreRule) -> NDArray[np.bool_]:
        """The container's (H, W) mask in one frame of a view.

        Raises:
            NotFoundError: the frame was not inspected, or shows no container.
        """


class FitSource(Protocol):
    """Where an estimate finds the fits of single frames, such as the store."""

    def __call__(self, *, pair: Pair, frame: int, centre_rule: CentreRule) -> "Fit":
        """The hull of one pair of views in one frame."""


@dataclass(frozen=True, eq=False)
class RecordingMasks:
    """A recording's files and detections, read and decoded at each call.

    Args:
        recording: gives the cameras.
        detections: unfiltered, by view and frame.
        selection: parameters of the filter; default: the paper's.
    """

    recording: Recording
    detections: Mapping[str, FrameDetections]
    selection: SelectionParameters = field(default_factory=SelectionParameters)

    def camera(self, view: str) -> Camera:
        """See ``MaskSource``."""
        if view not in self.recording.views:
            raise NotFoundError(f"{view} has no video")
        return self.recording.views[view].camera()

    def mask(self, view: str, frame: int, centre_rule: CentreRule) -> NDArray[np.bool_]:
        """See ``MaskSource``."""
        if view not in self.detections:
            raise NotFoundError(f"{view} has no detections")
        if frame not in self.detections[view]:
            raise NotFoundError(f"frame {frame} of {view} was not inspected")
        found = self.detections[view][frame]
        mask = container_mask(found, centre_rule=centre_rule, parameters=self.selection)
        if not mask.any():
            raise NotFoundError(f"{view} has no container in frame {frame}")
        return mask


@dataclass(frozen=True, eq=False)
class Fit:
    """The hull of one pair of views in one frame; the third view may have joined.

    Args:
        pair: the two views.
        frame: frame index, None if there was none to fit.
        hull: the fitted hull, or a failed one with its reason.
        dimensions: its measures, or failed ones with the reason.
    """

    pair: Pair
    frame: int | None
    hull: Hull
    dimensions: Dimensions

    @property
    def ok(self) -> bool:
        """Whether the four quantities are there."""
        return self.dimensions.ok

    @property
    def view_weights(self) -> dict[str, float]:
        """How much each view counts, by name, see ``Hull``; empty where all count alike."""
        views = (*self.pair, *(name for name in METHOD_VIEWS if name not in self.pair))
        return dict(zip(views, self.hull.view_weights.tolist(), strict=False))


def fit_frame(
    recording: Recording,
    views: Mapping[str, FrameDetections],
    *,
    pair: Pair,
    frame: int,
    centre_rule: CentreRule,
    shape: ShapeParameters | None = None,
    selection: SelectionParameters | None = None,
) -> Fit:
    """Fit and measure the hull of one pair of views in one frame.

    Args:
        recording: gives the cameras.
        views: unfiltered detections by view and frame.
        pair: the two views.
        frame: frame index.
        centre_rule: the rung of the ladder with which the container is chosen.
        shape: parameters of the fit; default: the paper's. With ``all_views`` the third view joins where it shows the
            container and agrees with the pair.
        selection: parameters of the filter; default: the paper's.

    Returns:
        The fit; a missing camera, view or container is a failed one with the reason.
    """
    source = RecordingMasks(recording, views, selection or SelectionParameters())
    return fit_masks(source, pair=pair, frame=frame, centre_rule=centre_rule, shape=shape or ShapeParameters.paper())


def fit_masks(source: MaskSource, *, pair: Pair, frame: int, centre_rule: CentreRule, shape: ShapeParameters) -> Fit:
    """As ``fit_frame``, for cameras and masks that the caller may hold already."""
    seen = {}
    try:
        for name in pair:
            seen[name] = source.camera(name), source.mask(name, frame, centre_rule)
    except (FileError, NotFoundError) as error:
        return _failed_fit(pair, frame, str(error))
    for name in METHOD_VIEWS if shape.all_views else ():
        if name not in pair:
            with suppress(FileError, NotFoundError):
                seen[name] = source.camera(name), source.mask(name, frame, centre_rule)
    cameras, masks = zip(*seen.values(), strict=True)
    try:
        hull = fit_agreeing(cameras, masks, shape)
    except ArgumentError as error:
        return _failed_fit(pair, frame, str(error))
    return Fit(pair, frame, hull, measure_hull(hull, shape))


def _failed_fit(pair: Pair, frame: int | None, reason: str) -> Fit:
    return Fit(pair, frame, Hull.failed(reason), Dimensions(reason=reason))
