"""One recording to one estimate: the only place that knows the order of the stages."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import pandas as pd

from corsmal.dataset import Recording
from corsmal.errors import ArgumentError, FileError, NotFoundError
from corsmal.estimation.detected import container_mask, file_detections
from corsmal.estimation.fit import QUANTITIES, Fit, fit_frame
from corsmal.filling.records import FillingPrediction
from corsmal.mass.physics import filling_mass_g, mm_per_pixel
from corsmal.mass.records import MassPrediction
from corsmal.parameters import PAIRS, CentreRule, SelectionParameters, ShapeParameters
from corsmal.selection import BestFrame, FrameDetections, select_best_frame

if TYPE_CHECKING:
    from corsmal.filling.features import Features
    from corsmal.filling.prediction import FillingPredictor
    from corsmal.mass.prediction import MassPredictor

Status = Literal["fitted", "fitted, second pair", "training means", "failed"]

MEANS = (*QUANTITIES, "container_mass_g")
"""The quantities of which the training set's means stand in where nothing could be fitted."""

MASS_VIEW = PAIRS[0][0]
"""The robot's view, from which the container's mass is told."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """What the system says about one recording.

    Args:
        recording_id: the recording.
        status: where the geometry's numbers come from; ``training means`` and ``failed``: both pairs failed.
        capacity_ml: mL, None when failed; likewise the widths and the height, mm.
        width_top_mm: diameter at the upper end.
        width_bottom_mm: diameter at the lower end.
        height_mm: height.
        best_frame: the selection that led to the fit, None if none did.
        fit: the hull behind the numbers, None if none is.
        notes: one sentence for every pair that failed, every view without detections, and every later stage that
            failed.
        container_mass_g: grams, None when failed or not asked for.
        filling: what the sound says, None when not asked for.
        mass: where ``container_mass_g`` comes from, None when not asked for or when there is no fit.
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
    container_mass_g: float | None = None
    filling: FillingPrediction | None = None
    mass: MassPrediction | None = None

    @property
    def frames_inspected(self) -> int:
        """How many frames the best one was chosen from."""
        return 0 if self.best_frame is None else len(self.best_frame.scores)

    @property
    def centre_rule(self) -> CentreRule | None:
        """The rung of the ladder that was used."""
        return None if self.best_frame is None else self.best_frame.centre_rule

    @property
    def filling_mass_g(self) -> float | None:
        """Level fraction × capacity × density of the estimated type, g; None where one of them is not known."""
        pair = None if self.filling is None else self.filling.pair
        if pair is None or (self.capacity_ml is None and pair[1]):
            return None
        return filling_mass_g(*pair, capacity_ml=self.capacity_ml or 0.0)

    @property
    def object_mass_g(self) -> float | None:
        """Container and filling, g."""
        if self.container_mass_g is None or self.filling_mass_g is None:
            return None
        return self.container_mass_g + self.filling_mass_g

    def row(self) -> dict[str, Any]:
        """The estimate as a row of an estimates table; what is not known is None."""
        filling = FillingPrediction.failed("not asked for") if self.filling is None else self.filling
        types, levels = filling.type_probabilities, filling.level_probabilities
        return {
            "recording_id": self.recording_id,
            "status": self.status,
            **{name: getattr(self, name) for name in MEANS},
            "filling_type": filling.filling_type,
            "filling_level": filling.filling_level,
            "filling_mass_g": self.filling_mass_g,
            "object_mass_g": self.object_mass_g,
            **{f"type_p{index}": None if types is None else float(types[index]) for index in range(4)},
            **{f"level_p{index}": None if levels is None else float(levels[index]) for index in range(3)},
            "best_frame": None if self.best_frame is None else self.best_frame.frame,
            "pair": "" if self.fit is None else " + ".join(self.fit.pair),
            "notes": "; ".join(self.notes),
        }


def training_means(table: pd.DataFrame) -> dict[str, float]:
    """Means of the geometry and the mass over an annotated set, the estimate where nothing can be fitted.

    Args:
        table: a dataset's table with columns ``capacity_ml``, ``width_top_mm``, ``width_bottom_mm``, ``height_mm``
            and, where the mass is known, ``container_mass_g``.

    Returns:
        Quantity to mean; empty where the annotation lacks any of the first four.
    """
    columns = table.reindex(columns=list(MEANS)).astype("Float64")
    geometry = columns.dropna(subset=list(QUANTITIES))
    if not len(geometry):
        return {}
    return {name: float(geometry[name].mean()) for name in MEANS if geometry[name].notna().any()}


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
) -> Estimate:
    """Everything the system says about one recording.

    The pairs of views are tried in order: best frame, then fit. If both fail the estimate holds ``means``, and says so.
    The mass is told from the robot's view in the best frame, the filling from the sound.

    Args:
        recording: the recording.
        detections: unfiltered detections by view and frame; default: the files beside the videos.
        shape: parameters of the fit; default: the paper's.
        selection: parameters of the filter; default: the paper's.
        means: the training set's means, see ``training_means``; without them a failure holds no numbers.
        filling: tells type and level; default: they are left out.
        mass: tells the container's mass; default: it is left out.
        features: gives what ``filling`` listens to; default: log-mel of the sound.

    Returns:
        The estimate.
    """
    notes: tuple[str, ...] = ()
    if detections is None:
        detections, notes = file_detections(recording)
    found = _geometry(recording, detections, shape=shape, selection=selection, means=means or {}, notes=notes)
    if mass is not None:
        found = _with_mass(found, mass_inputs(found, recording, detections, selection=selection), mass)
    return found if filling is None else _with_filling(found, recording, filling, features)


def _geometry(
    recording: Recording,
    detections: Mapping[str, FrameDetections],
    *,
    shape: ShapeParameters | None,
    selection: SelectionParameters | None,
    means: Mapping[str, float],
    notes: tuple[str, ...],
) -> Estimate:
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
    values = {name: means.get(name) for name in MEANS}
    return Estimate(
        recording.id, "training means" if means else "failed", **values, best_frame=None, fit=None, notes=notes
    )


def mass_inputs(
    found: Estimate,
    recording: Recording,
    detections: Mapping[str, FrameDetections],
    *,
    selection: SelectionParameters | None = None,
) -> dict[str, Any] | None:
    """What a ``MassPredictor`` is asked for an estimate: the mask in the robot's view, the measures and the scale.

    Args:
        found: the estimate, with its geometry.
        recording: whose estimate it is.
        detections: that it was made from.
        selection: parameters of the filter that it was made with; default: the paper's.

    Returns:
        Arguments of ``MassPredictor.predict``; None where nothing was fitted.
    """
    if found.fit is None or found.fit.frame is None or found.best_frame is None:
        return None
    frame = detections[MASS_VIEW][found.fit.frame]
    centroid_m = found.fit.hull.centroid_m
    try:
        scale = None if centroid_m is None else mm_per_pixel(recording.views[MASS_VIEW].camera(), centroid_m)
    except (ArgumentError, FileError):
        scale = None
    return {
        "mask": container_mask(
            frame, centre_rule=found.best_frame.centre_rule, parameters=selection or SelectionParameters()
        ),
        **{name: getattr(found.fit.dimensions, name) for name in QUANTITIES[1:]},
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

    try:
        heard = (features or recording_features)(recording)
        prediction = predictor.predict(heard.values, steps_s=heard.row_s)
    except (ArgumentError, FileError, NotFoundError) as error:
        prediction = FillingPrediction.failed(str(error))
    notes = found.notes if prediction.ok else (*found.notes, f"filling: {prediction.reason}")
    return replace(found, filling=prediction, notes=notes)
