"""Estimates, kept in the store so that an interrupted run resumes."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from corsmal.dataset import Recording
from corsmal.dataset.places import file_of
from corsmal.errors import CorsmalError, FileError
from corsmal.estimation import Estimate, TrainingMeans, estimate
from corsmal.estimation.fit import FitSource
from corsmal.notes import SEPARATOR, Note, flags_of
from corsmal.parameters import SelectionParameters, ShapeParameters
from corsmal.selection import FrameDetections
from corsmal.stages.detections import DetectionSet, detections_origin, load_detections
from corsmal.stages.fits import calibration_fingerprints
from corsmal.stages.training_facts import shape_name, trained_shape
from corsmal.stages.version import METHOD_VERSION, READING_VERSION
from corsmal.store import Store, digest, file_fingerprint
from corsmal.weights import RELEASED

if TYPE_CHECKING:
    from corsmal.filling.features import Features
    from corsmal.filling.fused_prediction import FusedPredictor
    from corsmal.filling.prediction import FillingPredictor
    from corsmal.filling.sight import Senses
    from corsmal.mass.prediction import MassPredictor

KIND = "estimates"

SYNTHETIC = " (synthetic)"
"""Marks weights in the rows of real recordings that were trained on synthetic ones only."""

UNKNOWN_TRAINING = (
    "the network is in the authors' file, which does not say what it was trained on: it counts as held out on no "
    "recording (theirs were trained on the published training set)"
)


@dataclass(frozen=True, eq=False)
class Predictors:
    """What estimates are made with, besides detections.

    Args:
        shape: how the hull is fitted and measured.
        means: of a training set; None: a failure holds no numbers.
        filling: predicts type and level; None: they are left out.
        mass: predicts the container's mass; None: it is left out.
        features: folder of arrays for ``filling``; None: log-mel of the sound.
        sight: folder of arrays of the videos, for a fused network; None: it hears only.
        selection: how detections are filtered and frames scored.
    """

    shape: ShapeParameters = field(default_factory=ShapeParameters.paper)
    means: TrainingMeans | None = None
    filling: "FillingPredictor | FusedPredictor | None" = None
    mass: "MassPredictor | None" = None
    features: Path | None = None
    sight: Path | None = None
    selection: SelectionParameters = field(default_factory=SelectionParameters)

    @property
    def digests(self) -> dict[str, str | None]:
        """Of the networks, by ``filling`` and ``mass``; None where one is left out."""
        networks = {"filling": self.filling, "mass": self.mass}
        return {name: None if network is None else network.digest for name, network in networks.items()}

    @property
    def key(self) -> str:
        """A digest of everything that the numbers depend on, the version of the method included."""
        return predictors_key(self.shape, self.selection, self.means, self.digests)


class MadeWith(Protocol):
    """What an estimate is made with: ``Predictors``, or the settings that they are opened from."""

    @property
    def key(self) -> str:
        """See ``Predictors.key``."""

    @property
    def filling(self) -> object | None:
        """What predicts type and level."""

    @property
    def features(self) -> Path | None:
        """See ``Predictors``."""

    @property
    def sight(self) -> Path | None:
        """See ``Predictors``."""


def predictors_key(
    shape: ShapeParameters,
    selection: SelectionParameters,
    means: TrainingMeans | None,
    digests: Mapping[str, str | None],
) -> str:
    """See ``Predictors.key``; ``digests`` are those of the networks."""
    return digest("predictors", METHOD_VERSION, shape, selection, means, dict(digests))


def load_estimate(recording: Recording, predictors: Predictors, *, store: Store) -> dict[str, Any]:
    """The row of one recording, from the store if it was estimated before; a failed one with the reason."""
    try:
        origin = detections_origin(recording, store=store)
        if (kept := kept_row(recording, predictors, origin, store=store)) is not None:
            return kept
        row = _estimated(recording, load_detections(recording, store=store), predictors, store)
    except CorsmalError as error:
        return {"recording_id": recording.id, "status": "failed", "notes": str(error)}
    store.save_json(KIND, estimate_key(recording, predictors, origin), row)
    return row


def kept_row(recording: Recording, made_with: MadeWith, origin: str, *, store: Store) -> dict[str, Any] | None:
    """The row of a recording if it was estimated before; arguments as in ``estimate_key``. No network is opened."""
    return store.json(KIND, estimate_key(recording, made_with, origin))


def estimate_key(recording: Recording, made_with: MadeWith, origin: str) -> str:
    """A digest of everything that an estimate depends on.

    Args:
        recording: the recording.
        made_with: what it is estimated with.
        origin: of its detections, see ``DetectionSet.key``.
    """
    return digest("estimate", made_with.key, origin, _files(recording, made_with))


def _estimated(recording: Recording, detections: DetectionSet, predictors: Predictors, store: Store) -> dict[str, Any]:
    began_s = time.perf_counter()
    result = estimate_with(predictors, recording, detections.views, store=store)
    time_ms = round(1000 * (time.perf_counter() - began_s), 1)
    return estimate_row(result, recording, detections, predictors) | {"execution_time_ms": time_ms}


def estimate_with(
    predictors: Predictors,
    recording: Recording,
    detections: Mapping[str, FrameDetections],
    *,
    fits: FitSource | None = None,
    **heard: Any,
) -> Estimate:
    """The estimate of a recording; ``heard`` are further arguments of ``recording_features``."""
    features: Callable[[Recording], Features | Senses] | None = None
    if predictors.filling is not None:
        from corsmal.filling.features import recording_features  # noqa: PLC0415 - loads PyTorch
        from corsmal.filling.sight import recording_senses  # noqa: PLC0415 - as above

        given = {"folder": predictors.features, "parameters": predictors.filling.front_end, **heard}
        features = partial(recording_features, **given)
        if predictors.sight is not None:
            features = partial(recording_senses, sight=predictors.sight, **given)
    return estimate(
        recording,
        detections=detections,
        shape=predictors.shape,
        selection=predictors.selection,
        means=None if predictors.means is None else predictors.means.for_container(recording.annotation),
        filling=predictors.filling,
        mass=predictors.mass,
        features=features,
        fits=fits,
    )


def estimate_row(
    found: Estimate, recording: Recording, detections: DetectionSet, predictors: Predictors
) -> dict[str, Any]:
    """An estimate as a row of a run: with the networks behind its numbers, whether they are held out, and all notes."""
    row = found.row()
    columns, notes = _spoken(recording, predictors)
    said = [*detections.notes, *found.notes, *notes]
    return {**row, **columns, "flags": SEPARATOR.join(flags_of(said)), "notes": "; ".join(dict.fromkeys(said))}


def _spoken(recording: Recording, predictors: Predictors) -> tuple[dict[str, Any], list[str]]:
    """Which networks gave the row's numbers, whether they are held out, and what is to be said about that."""
    columns: dict[str, Any] = {}
    notes: list[str] = []
    for name, network in (("filling", predictors.filling), ("mass", predictors.mass)):
        trained_on = None if network is None else network.trained_on
        columns[f"{name}_weights"] = "" if network is None else network.digest
        columns[f"{name}_held_out"] = None
        if columns[f"{name}_weights"].startswith(RELEASED):
            notes.append(f"{name}: {UNKNOWN_TRAINING}")
        if trained_on is None:
            continue
        array = _array_digest(recording, predictors.features) if name == "filling" else None
        columns[f"{name}_held_out"] = not trained_on.has_seen(recording, features=array)
        if trained_on.is_synthetic and not recording.is_synthetic:
            columns[f"{name}_weights"] += SYNTHETIC
            sentence = f"{name}: the network was trained on synthetic recordings only"
            notes.append(Note(sentence, flag="network-synthetic"))
        shape = trained_shape(trained_on)
        if shape is not None and shape != shape_name(predictors.shape):
            notes.append(f"{name}: the network was trained on dimensions of the shape preset {shape}")
    return columns, notes


def _array_digest(recording: Recording, folder: Path | None) -> str | None:
    """Digest of the array that the filling network is given; None where it is given the sound, or there is none."""
    from corsmal.filling.features import recording_features  # noqa: PLC0415 - loads PyTorch

    try:
        return None if folder is None else digest(recording_features(recording, folder=folder).values)
    except CorsmalError:
        return None


def _files(recording: Recording, made_with: MadeWith) -> list[Any]:
    """What an estimate is made from, besides detections."""
    folder = made_with.features
    path = recording.audio_path if folder is None else file_of(folder, recording.id, ".npy")
    try:
        heard = None if path is None or made_with.filling is None else file_fingerprint(path)
    except FileError:
        heard = None
    seen: list[str] = []
    if made_with.sight is not None and (array := file_of(made_with.sight, recording.id, ".npy")).is_file():
        seen = [file_fingerprint(array)]
    reading = [] if recording.is_synthetic else [READING_VERSION]
    return [recording.id, calibration_fingerprints(recording), heard, *seen, *reading]
