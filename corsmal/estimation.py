"""One recording to one estimate: the only place that knows the order of the stages."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np
import pandas as pd

from corsmal.dataset import Recording, View
from corsmal.detection import Detections, ViewDetections, filter_detections, read_coco_results
from corsmal.errors import ArgumentError, FileError, NotFoundError
from corsmal.parameters import PAIRS, CentreRule, SelectionParameters, ShapeParameters
from corsmal.selection import BestFrame, FrameDetections, Pair, select_best_frame
from corsmal.shape import Dimensions, Hull, fit_hull, measure_hull

Status = Literal["fitted", "fitted, second pair", "training means", "failed"]

T = TypeVar("T")

QUANTITIES = ("capacity_ml", "width_top_mm", "width_bottom_mm", "height_mm")


@dataclass(frozen=True, eq=False)
class Fit:
    """The hull of one pair of views in one frame.

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


@dataclass(frozen=True, eq=False)
class Estimate:
    """What the system says about one recording.

    Args:
        recording_id: the recording.
        status: where the numbers come from; ``training means`` and ``failed`` say that both pairs failed.
        capacity_ml: mL, None when failed; likewise the widths and the height, mm.
        width_top_mm: diameter at the upper end.
        width_bottom_mm: diameter at the lower end.
        height_mm: height.
        best_frame: the selection that led to the fit, None if none did.
        fit: the hull behind the numbers, None if none is.
        notes: one sentence for every pair that failed and every view without detections.
    """

    recording_id: str
    status: Status
    capacity_ml: float | None
    width_top_mm: float | None
    width_bottom_mm: float | None
    height_mm: float | None
    best_frame: BestFrame | None
    fit: Fit | None
    notes: tuple[str, ...]

    @property
    def frames_inspected(self) -> int:
        """How many frames the best one was chosen from."""
        return 0 if self.best_frame is None else len(self.best_frame.scores)

    @property
    def centre_rule(self) -> CentreRule | None:
        """The rung of the ladder that was used."""
        return None if self.best_frame is None else self.best_frame.centre_rule


def training_means(table: pd.DataFrame) -> dict[str, float]:
    """Means of the four quantities over an annotated set, the estimate where nothing can be fitted.

    Args:
        table: a dataset's table with columns ``capacity_ml``, ``width_top_mm``, ``width_bottom_mm``, ``height_mm``.

    Returns:
        Quantity to mean; empty where the annotation lacks any of them.
    """
    columns = table.reindex(columns=list(QUANTITIES)).astype("Float64").dropna(how="any")
    return {name: float(columns[name].mean()) for name in QUANTITIES} if len(columns) else {}


def read_view_detections(view: View) -> ViewDetections | None:
    """Detections made elsewhere: the file that lies beside a view's video, None where there is none.

    Raises:
        FileError: the file or the video cannot be used.
    """
    if view.detections_path is None:
        return None
    with view.video() as video:
        size, frame_count = video.size[::-1], video.frame_count
    return read_coco_results(view.detections_path, size=size, frame_count=frame_count)


def file_detections(recording: Recording) -> tuple[dict[str, ViewDetections], tuple[str, ...]]:
    """Detections made elsewhere, for all views of a recording.

    Returns:
        Detections by view, and one sentence for each view whose file could not be used.
    """
    found, notes = {}, []
    for name, view in recording.views.items():
        try:
            detections = read_view_detections(view)
        except FileError as error:
            notes.append(str(error))
            continue
        if detections is not None:
            found[name] = detections
    return found, tuple(notes)


def container_mask(detections: Detections, *, centre_rule: CentreRule, parameters: SelectionParameters) -> np.ndarray:
    """The (H, W) bool mask of the container among one frame's detections; all false where there is none."""
    container = filter_detections(detections, centre_rule=centre_rule, parameters=parameters).container
    return np.zeros(detections.size, dtype=bool) if container is None else detections.mask(container)


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
        shape: parameters of the fit; default: the paper's.
        selection: parameters of the filter; default: the paper's.

    Returns:
        The fit; a missing camera, view or container is a failed one with the reason.
    """
    shape, selection = shape or ShapeParameters.paper(), selection or SelectionParameters()
    try:
        cameras = [_view_item(recording.views, name, "video").camera() for name in pair]
        detections = [_frame_item(_view_item(views, name, "detections"), frame, name) for name in pair]
    except (FileError, NotFoundError) as error:
        return _failed_fit(pair, frame, str(error))
    masks = [container_mask(item, centre_rule=centre_rule, parameters=selection) for item in detections]
    for name, mask in zip(pair, masks, strict=True):
        if not mask.any():
            return _failed_fit(pair, frame, f"{name} has no container in frame {frame}")
    try:
        hull = fit_hull(cameras, masks, shape)
    except ArgumentError as error:
        return _failed_fit(pair, frame, str(error))
    return Fit(pair, frame, hull, measure_hull(hull, shape))


def estimate(
    recording: Recording,
    *,
    detections: Mapping[str, FrameDetections] | None = None,
    shape: ShapeParameters | None = None,
    selection: SelectionParameters | None = None,
    means: Mapping[str, float] | None = None,
) -> Estimate:
    """Everything the system says about one recording.

    The pairs of views are tried in order: best frame, then fit. If both fail the estimate holds ``means``, and says so.

    Args:
        recording: the recording.
        detections: unfiltered detections by view and frame; default: the files beside the videos.
        shape: parameters of the fit; default: the paper's.
        selection: parameters of the filter; default: the paper's.
        means: the training set's means, see ``training_means``; without them a failure holds no numbers.

    Returns:
        The estimate.
    """
    notes: tuple[str, ...] = ()
    if detections is None:
        detections, notes = file_detections(recording)
    for position, pair in enumerate(PAIRS):
        best = select_best_frame(detections, pair=pair, parameters=selection)
        if best.frame is None:
            notes += (f"{' + '.join(pair)}: {best.reason}",)
            continue
        fit = fit_frame(
            recording,
            detections,
            pair=pair,
            frame=best.frame,
            centre_rule=best.centre_rule,
            shape=shape,
            selection=selection,
        )
        if fit.ok:
            values = {name: getattr(fit.dimensions, name) for name in QUANTITIES}
            status: Status = "fitted" if position == 0 else "fitted, second pair"
            return Estimate(recording.id, status, **values, best_frame=best, fit=fit, notes=notes)
        notes += (f"{' + '.join(pair)}, frame {best.frame}: {fit.dimensions.reason}",)
    values = {name: (means or {}).get(name) for name in QUANTITIES}
    return Estimate(
        recording.id, "training means" if means else "failed", **values, best_frame=None, fit=None, notes=notes
    )


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
