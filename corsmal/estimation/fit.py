"""The hull of one pair of views in one frame, measured."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset import Recording
from corsmal.detection import Detections
from corsmal.errors import ArgumentError, FileError, NotFoundError
from corsmal.estimation.detected import container_mask
from corsmal.geometry import Camera
from corsmal.parameters import METHOD_VIEWS, CentreRule, SelectionParameters, ShapeParameters
from corsmal.selection import FrameDetections, Pair
from corsmal.shape import Dimensions, Hull, fit_hull, measure_hull

T = TypeVar("T")


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
    shape, selection = shape or ShapeParameters.paper(), selection or SelectionParameters()
    seen = {}
    for name in pair:
        try:
            seen[name] = _seen(recording, views, name, frame, centre_rule=centre_rule, selection=selection)
        except (FileError, NotFoundError) as error:
            return _failed_fit(pair, frame, str(error))
    if shape.all_views:
        for name in [name for name in METHOD_VIEWS if name not in pair]:
            with suppress(FileError, NotFoundError):
                seen[name] = _seen(recording, views, name, frame, centre_rule=centre_rule, selection=selection)
    cameras, masks = zip(*seen.values(), strict=True)
    try:
        hull = fit_hull(cameras, masks, shape)
        if not hull.ok and len(seen) > len(pair):
            hull = fit_hull(cameras[: len(pair)], masks[: len(pair)], shape)
    except ArgumentError as error:
        return _failed_fit(pair, frame, str(error))
    return Fit(pair, frame, hull, measure_hull(hull, shape))


def _seen(
    recording: Recording,
    views: Mapping[str, FrameDetections],
    name: str,
    frame: int,
    *,
    centre_rule: CentreRule,
    selection: SelectionParameters,
) -> tuple[Camera, NDArray[np.bool_]]:
    """The camera of a view and the container's mask in one of its frames.

    Raises:
        FileError: the calibration cannot be read.
        NotFoundError: there is no such view or frame, or no container in it.
    """
    camera = _view_item(recording.views, name, "video").camera()
    detections = _frame_item(_view_item(views, name, "detections"), frame, name)
    mask = container_mask(detections, centre_rule=centre_rule, parameters=selection)
    if not mask.any():
        raise NotFoundError(f"{name} has no container in frame {frame}")
    return camera, mask


def _failed_fit(pair: Pair, frame: int | None, reason: str) -> Fit:
    return Fit(pair, frame, Hull.failed(reason), Dimensions(reason=reason))


def _view_item(views: Mapping[str, T], name: str, what: str) -> T:
    if name not in views:
        raise NotFoundError(f"{name} has no {what}")
    return views[name]


def _frame_item(frames: FrameDetections, frame: int, name: str) -> Detections:
    if frame not in frames:
        raise NotFoundError(f"frame {frame} of {name} was not inspected")
    return frames[frame]
