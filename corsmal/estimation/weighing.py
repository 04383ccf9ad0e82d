"""The container's mass in an estimate: which mask and which measures the network is given, and what stands in."""

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

from corsmal.errors import ArgumentError, FileError, NotFoundError
from corsmal.estimation.fit import MaskSource
from corsmal.estimation.records import Estimate
from corsmal.mass.physics import mm_per_pixel
from corsmal.mass.records import PredictsMass
from corsmal.notes import Note
from corsmal.parameters import FRONTAL_VIEW, CentreRule, SelectionParameters
from corsmal.quantities import DIMENSIONS
from corsmal.selection import FrameDetections, best_frame_of_view

RuledFrame = tuple[int, CentreRule]
"""A frame, and the rule by which its container is chosen."""


def frontal_frame(
    detections: Mapping[str, FrameDetections],
    selection: SelectionParameters,
    counted: Collection[int] | None = None,
) -> RuledFrame | None:
    """The robot's view's own best frame with the rule that leaves it; None where the view shows no container.

    Args:
        detections: unfiltered, by view and frame.
        selection: how they are filtered and scored.
        counted: the frames that count; default: all.
    """
    own = detections.get(FRONTAL_VIEW, {})
    for rule in selection.centre_rules:
        alone = replace(selection, centre_rules=(rule,), fallback_frame=None)
        frame = best_frame_of_view(own, parameters=alone, frames=counted)
        if frame is not None:
            return frame, rule
    fallback = selection.fallback_frame
    return None if fallback is None else (fallback, selection.centre_rules[-1])


def mass_inputs(found: Estimate, masks: MaskSource, *, taken: RuledFrame | None = None) -> dict[str, Any] | None:
    """What a ``MassPredictor`` is given for an estimate: its widths and height, a mask of the frontal view, its scale.

    Args:
        found: the estimate, with its geometry.
        masks: cameras and masks that it was made from, such as ``RecordingMasks``.
        taken: the mask's frame; default: the estimate's, with the rule of its best frame.

    Returns:
        Arguments of ``MassPredictor.predict``; None where there is no frame.

    Raises:
        NotFoundError: the frame shows no container in the frontal view.
    """
    if taken is None and found.mass_frame is not None and found.centre_rule is not None:
        taken = found.mass_frame, found.centre_rule
    if taken is None:
        return None
    centroid_m = None if found.fit is None else found.fit.hull.centroid_m
    try:
        scale = None if centroid_m is None else mm_per_pixel(masks.camera(FRONTAL_VIEW), centroid_m)
    except (ArgumentError, FileError, NotFoundError):
        scale = None
    return {
        "mask": masks.mask(FRONTAL_VIEW, *taken),
        **{name: getattr(found, name) for name in DIMENSIONS},
        "mm_per_px": scale,
    }


def with_mass(
    found: Estimate,
    masks: MaskSource,
    predictor: PredictsMass,
    *,
    frontal: RuledFrame | None,
    means: Mapping[str, float] | None = None,
) -> Estimate:
    """An estimate with the container's mass.

    The mask is that of the estimate's frame for the mass. Where nothing was fitted, or that frame shows no container in
    the robot's view, it is that of the view's own best frame; where nothing was fitted, the measures are the means that
    the estimate holds. Where the network cannot use them, or the view shows no container, the mean mass stands in.

    Args:
        found: the estimate, with its geometry.
        masks: see ``mass_inputs``.
        predictor: the network.
        frontal: the robot's view's own best frame, see ``frontal_frame``.
        means: of a training set, see ``estimate``.
    """
    if found.fit is None and found.height_mm is None:
        return found
    mean_g = (means or {}).get("container_mass_g", found.container_mass_g)
    try:
        inputs = mass_inputs(found, masks)
    except NotFoundError:
        inputs = None
    try:
        if inputs is None and frontal is not None:
            inputs, found = mass_inputs(found, masks, taken=frontal), replace(found, mass_frame=frontal[0])
    except NotFoundError as error:
        return _assumed(found, str(error), mean_g)
    if inputs is None:
        return _assumed(found, f"{FRONTAL_VIEW} shows no container in any inspected frame", mean_g)
    prediction = predictor.predict(**inputs)
    if not prediction.ok:
        mean_g = mean_g if found.fit is None else None
        return replace(_assumed(found, prediction.reason, mean_g), mass=prediction)
    notes = tuple(Note(f"container mass: {note}", flag="mass-assumed") for note in prediction.notes)
    if found.fit is None:
        sentence = "container mass: predicted from the mean dimensions of the training set, as nothing was fitted"
        notes += (Note(sentence, flag="dimensions-assumed"),)
    return replace(found, container_mass_g=prediction.mass_g, mass=prediction, notes=(*found.notes, *notes))


def _assumed(found: Estimate, problem: str, mean_g: float | None) -> Estimate:
    """The estimate with the mean mass of the training set, or without a mass where None is given."""
    note = f"container mass: {problem}"
    if mean_g is not None:
        note = Note(f"{note}; the training mean stands in", flag="mass-assumed")
    return replace(found, container_mass_g=mean_g, notes=(*found.notes, note))
