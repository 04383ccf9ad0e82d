"""One recording to one estimate: the only place that knows the order of the stages."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from corsmal.dataset import Recording
from corsmal.errors import ArgumentError, FileError, NotFoundError
from corsmal.estimation.detected import file_detections
from corsmal.estimation.fit import FitSource, MaskSource, RecordingMasks, fit_frame
from corsmal.estimation.plausibility import calibration_notes, implausible
from corsmal.estimation.records import Estimate
from corsmal.estimation.several import choose_frames, combine_fits
from corsmal.filling.records import FillingPrediction
from corsmal.mass.physics import mm_per_pixel
from corsmal.notes import Note, prefixed
from corsmal.parameters import FRONTAL_VIEW, PAIRS, SelectionParameters, ShapeParameters
from corsmal.quantities import DIMENSIONS, MEASURED
from corsmal.selection import FrameDetections

if TYPE_CHECKING:
    from corsmal.filling.features import Features
    from corsmal.filling.prediction import FillingPredictor
    from corsmal.mass.prediction import MassPredictor


def estimate(
    recording: Recording,
    *,
    detections: Mapping[str, FrameDetections] | None = None,
    shape: ShapeParameters | None = None,
    selection: SelectionParameters | None = None,
    means: Mapping[str, float] | None = None,
    filling: "FillingPredictor | None" = None,
    mass: "MassPredictor | None" = None,
    features: "Callable[[Recording], Features] | None" = None,
    fits: FitSource | None = None,
) -> Estimate:
    """Everything the system says about one recording.

    The pairs of views are tried in order: best frame, or the best of several stretches, then fit. A fit that cannot be
    true, see ``plausibility``, counts as failed. If both fail the estimate holds ``means``, and says so. The mass is
    predicted from the robot's view in the fitted frame, the filling from the sound.

    Args:
        recording: the recording.
        detections: unfiltered detections by view and frame; default: the files beside the videos.
        shape: parameters of the fit; default: the paper's.
        selection: parameters of the filter; default: the paper's.
        means: what stands in where nothing can be fitted, see ``TrainingMeans``; without them a failure holds no
            numbers.
        filling: tells type and level; default: they are left out.
        mass: tells the container's mass; default: it is left out.
        features: gives what ``filling`` listens to; default: log-mel of the sound.
        fits: gives the fits of single frames, with the same parameters; default: they are made anew.

    Returns:
        The estimate.
    """
    notes: tuple[str, ...] = ()
    if detections is None:
        detections, notes = file_detections(recording)
    shape = shape or ShapeParameters.paper()
    fits = fits or partial(fit_frame, recording, detections, shape=shape, selection=selection)
    found = _geometry(
        recording,
        detections,
        shape=shape,
        selection=selection,
        fits=fits,
        means=means or {},
        notes=(*notes, *calibration_notes(recording)),
    )
    if mass is not None:
        masks = RecordingMasks(recording, detections, selection or SelectionParameters())
        found = _with_mass(found, mass_inputs(found, masks), mass)
    return found if filling is None else _with_filling(found, recording, filling, features)


def _geometry(
    recording: Recording,
    detections: Mapping[str, FrameDetections],
    *,
    shape: ShapeParameters,
    selection: SelectionParameters | None,
    fits: FitSource,
    means: Mapping[str, float],
    notes: tuple[str, ...],
) -> Estimate:
    for position, pair in enumerate(PAIRS):
        best, frames = choose_frames(detections, pair=pair, shape=shape, selection=selection)
        if best.frame is None:
            notes += (f"{' + '.join(pair)}: {best.reason}",)
            continue
        fitted = [fits(pair=pair, frame=frame, centre_rule=best.centre_rule) for frame in frames]
        found = combine_fits(fitted, recording)
        if found is not None:
            values: dict[str, Any] = dict(found.values)
            masks = RecordingMasks(recording, detections, selection or SelectionParameters())
            reason = implausible(found.fit, values, masks, centre_rule=best.centre_rule)
            if reason:
                sentence = f"{' + '.join(pair)}, frame {found.fit.frame}: {reason}"
                notes += (Note(sentence, flag="implausible"),)
                continue
            return Estimate(
                recording.id,
                "fitted" if position == 0 else "fitted, second pair",
                **values,
                best_frame=replace(best, frame=found.fit.frame, is_by_fit=len(frames) > 1),
                fit=found.fit,
                notes=notes,
                intervals=found.intervals,
            )
        reasons = {
            fit.dimensions.reason: f"{' + '.join(pair)}, frame {fit.frame}: {fit.dimensions.reason}" for fit in fitted
        }
        notes += tuple(reasons.values())
    values = {name: means.get(name) for name in MEASURED}
    return Estimate(
        recording.id, "fallback: training mean" if means else "failed", **values, best_frame=None, fit=None, notes=notes
    )


def mass_inputs(found: Estimate, masks: MaskSource) -> dict[str, Any] | None:
    """What a ``MassPredictor`` is given for an estimate: its widths and height, and the fitted frame's mask and scale.

    Args:
        found: the estimate, with its geometry.
        masks: cameras and masks that it was made from, such as ``RecordingMasks``.

    Returns:
        Arguments of ``MassPredictor.predict``; None where nothing was fitted.
    """
    if found.fit is None or found.fit.frame is None or found.best_frame is None:
        return None
    centroid_m = found.fit.hull.centroid_m
    try:
        scale = None if centroid_m is None else mm_per_pixel(masks.camera(FRONTAL_VIEW), centroid_m)
    except (ArgumentError, FileError, NotFoundError):
        scale = None
    return {
        "mask": masks.mask(FRONTAL_VIEW, found.fit.frame, found.best_frame.centre_rule),
        **{name: getattr(found, name) for name in DIMENSIONS},
        "mm_per_px": scale,
    }


def _with_mass(found: Estimate, inputs: Mapping[str, Any] | None, predictor: "MassPredictor") -> Estimate:
    """The estimate with the container's mass; where nothing was fitted, the mean that it may hold stays."""
    if inputs is None:
        return found
    prediction = predictor.predict(**inputs)
    notes = found.notes if prediction.ok else (*found.notes, f"container mass: {prediction.reason}")
    return replace(found, container_mass_g=prediction.mass_g, mass=prediction, notes=notes)


def _with_filling(
    found: Estimate,
    recording: Recording,
    predictor: "FillingPredictor",
    features: "Callable[[Recording], Features] | None",
) -> Estimate:
    from corsmal.filling.features import recording_features  # noqa: PLC0415 - loads PyTorch

    said: list[str] = []
    try:
        heard = (features or recording_features)(recording)
        said = [prefixed("sound", note) for note in heard.notes]
        prediction = predictor.predict(heard.values, steps_s=heard.row_s)
    except (ArgumentError, FileError, NotFoundError) as error:
        prediction = FillingPrediction.failed(str(error))
    said += [] if prediction.ok else [f"filling: {prediction.reason}"]
    notes = (*found.notes, *said)
    return replace(found, filling=prediction, notes=notes)
