"""One recording to one estimate: the only place that knows the order of the stages."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from corsmal.dataset import Recording
from corsmal.errors import ArgumentError, FileError, NotFoundError
from corsmal.estimation.detected import counted_frames, file_detections
from corsmal.estimation.fit import FitSource, RecordingMasks, fit_frame
from corsmal.estimation.plausibility import calibration_notes, implausible
from corsmal.estimation.records import FITTED, Estimate
from corsmal.estimation.several import Combined, choose_frames, combine_fits
from corsmal.estimation.weighing import frontal_frame, with_mass
from corsmal.filling.records import FillingPrediction, PredictsFilling
from corsmal.mass.records import PredictsMass
from corsmal.notes import Note, prefixed
from corsmal.parameters import FRONTAL_VIEW, SelectionParameters, ShapeParameters
from corsmal.quantities import BY_NAME, MEASURED
from corsmal.selection import FrameDetections, best_frame_of_view

if TYPE_CHECKING:
    from corsmal.filling.features import Features
    from corsmal.filling.sight import Senses


def estimate(
    recording: Recording,
    *,
    detections: Mapping[str, FrameDetections] | None = None,
    shape: ShapeParameters | None = None,
    selection: SelectionParameters | None = None,
    means: Mapping[str, float] | None = None,
    filling: PredictsFilling | None = None,
    mass: PredictsMass | None = None,
    features: "Callable[[Recording], Features | Senses] | None" = None,
    fits: FitSource | None = None,
) -> Estimate:
    """Everything the system says about one recording.

    The pairs of views of ``shape`` are tried in order: best frame, or the best of several stretches, then fit. A fit
    that cannot be true, see ``plausibility``, counts as failed. If all fail the estimate holds ``means``, and says so;
    a width that could not be measured by itself is its mean, and a note says so. The mass is predicted from the robot's
    view, see ``with_mass``, the filling from the sound.

    Args:
        recording: the recording.
        detections: unfiltered detections by view and frame; default: the files beside the videos.
        shape: parameters of the fit; default: the paper's.
        selection: how detections are filtered and frames scored; default: the paper's.
        means: what stands in where nothing can be fitted, see ``TrainingMeans``; without them a failure holds no
            numbers.
        filling: tells type and level, such as ``FillingPredictor``; default: they are left out.
        mass: tells the container's mass, such as ``MassPredictor``; default: it is left out.
        features: gives what ``filling`` is given; default: log-mel of the sound, as it was trained on.
        fits: gives the fits of single frames, with the same parameters; default: they are made anew.

    Returns:
        The estimate.
    """
    notes: tuple[str, ...] = ()
    if detections is None:
        detections, notes = file_detections(recording)
    shape, selection = shape or ShapeParameters.paper(), selection or SelectionParameters()
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
        frontal = frontal_frame(detections, selection, counted_frames(recording, selection))
        masks = RecordingMasks(recording, detections, selection)
        found = with_mass(found, masks, mass, frontal=frontal, means=means)
    return found if filling is None else _with_filling(found, recording, filling, features)


def _geometry(
    recording: Recording,
    detections: Mapping[str, FrameDetections],
    *,
    shape: ShapeParameters,
    selection: SelectionParameters,
    fits: FitSource,
    means: Mapping[str, float],
    notes: tuple[str, ...],
) -> Estimate:
    counted = counted_frames(recording, selection)
    masks = RecordingMasks(recording, detections, selection)
    for position, pair in enumerate(shape.pairs):
        best, frames = choose_frames(detections, pair=pair, shape=shape, selection=selection, counted=counted)
        name = " + ".join(pair)
        if best.frame is None:
            notes += (f"{name}: {best.reason}",)
            continue
        if best.is_fallback:
            notes += (Note(f"{name}: {best.reason}", flag="frame-fallback"),)
        fitted = [fits(pair=pair, frame=frame, centre_rule=best.centre_rule) for frame in frames]
        found = combine_fits(fitted, recording)
        if found is None:
            reasons = {fit.dimensions.reason: f"{name}, frame {fit.frame}: {fit.dimensions.reason}" for fit in fitted}
            notes += tuple(reasons.values())
            continue
        reason = implausible(found.fit, found.values, masks, centre_rule=best.centre_rule)
        if reason:
            notes += (Note(f"{name}, frame {found.fit.frame}: {reason}", flag="implausible"),)
            continue
        values, missing = _completed(found, means)
        return Estimate(
            recording.id,
            FITTED[position],
            **values,
            best_frame=replace(best, frame=found.fit.frame, is_by_fit=len(frames) > 1),
            fit=found.fit,
            notes=(*notes, *missing),
            intervals=found.intervals,
            mass_frame=_mass_frame(found.fit.frame, detections, selection, counted),
            box_odds=found.box_odds,
        )
    values = {name: means.get(name) for name in MEASURED}
    return Estimate(
        recording.id, "fallback: training mean" if means else "failed", **values, best_frame=None, fit=None, notes=notes
    )


def _completed(found: Combined, means: Mapping[str, float]) -> tuple[dict[str, Any], list[Note]]:
    """The quantities of a fit, means in place of those that it does not measure, and sentences on these."""
    values: dict[str, Any] = dict(found.values)
    said = []
    for name in [name for name, value in values.items() if value is None]:
        values[name] = means.get(name)
        why = found.fit.dimensions.unmeasured.get(name, "not measured")
        instead = "it is missing" if values[name] is None else "the training mean stands in"
        sentence = f"{BY_NAME[name].label.lower()}: {why}; {instead}"
        said.append(Note(sentence, flag="width-missing"))
    return values, said


def _mass_frame(
    fitted: int | None,
    detections: Mapping[str, FrameDetections],
    selection: SelectionParameters,
    counted: Collection[int] | None,
) -> int | None:
    if selection.mass_frame == "frontal":
        return best_frame_of_view(detections.get(FRONTAL_VIEW, {}), parameters=selection, frames=counted)
    return fitted


def _with_filling(
    found: Estimate,
    recording: Recording,
    predictor: PredictsFilling,
    features: "Callable[[Recording], Features | Senses] | None",
) -> Estimate:
    from corsmal.filling.features import recording_features  # noqa: PLC0415 - loads PyTorch
    from corsmal.filling.fused_prediction import predicted_from  # noqa: PLC0415 - as above

    said: list[str] = []
    try:
        heard = (features or partial(recording_features, parameters=getattr(predictor, "front_end", None)))(recording)
        said = [prefixed("sound", note) for note in heard.notes]
        prediction = predicted_from(heard, predictor)
    except (ArgumentError, FileError, NotFoundError) as error:
        prediction = FillingPrediction.failed(str(error))
    said += [] if prediction.ok else [f"filling: {prediction.reason}"]
    notes = (*found.notes, *said)
    return replace(found, filling=prediction, notes=notes)
