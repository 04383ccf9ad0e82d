"""Estimates, kept in the store so that a run that was stopped goes on where it was."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from corsmal.dataset import Recording
from corsmal.errors import CorsmalError, FileError
from corsmal.estimation import estimate
from corsmal.parameters import SelectionParameters, ShapeParameters
from corsmal.stages.detections import DetectionSet, detections_origin, load_detections
from corsmal.stages.fits import calibration_fingerprints
from corsmal.stages.version import METHOD_VERSION
from corsmal.store import Store, digest, file_fingerprint

if TYPE_CHECKING:
    from corsmal.filling.prediction import FillingPredictor
    from corsmal.mass.prediction import MassPredictor

KIND = "estimates"


@dataclass(frozen=True, eq=False)
class Predictors:
    """What estimates are made with, besides detections.

    Args:
        shape: parameters of the fit.
        means: the training set's means, see ``corsmal.estimation.training_means``.
        filling: tells type and level; None: they are left out.
        mass: tells the container's mass; None: it is left out.
        features: folder of arrays for ``filling``; None: log-mel of the sound.
    """

    shape: ShapeParameters = field(default_factory=ShapeParameters.paper)
    means: Mapping[str, float] = field(default_factory=dict)
    filling: "FillingPredictor | None" = None
    mass: "MassPredictor | None" = None
    features: Path | None = None

    @property
    def digests(self) -> dict[str, str | None]:
        """Of the networks, by ``filling`` and ``mass``; None where one is left out."""
        networks = {"filling": self.filling, "mass": self.mass}
        return {name: None if network is None else network.digest for name, network in networks.items()}

    @property
    def key(self) -> str:
        """A digest of everything that the numbers depend on, the version of the method included."""
        return digest("predictors", METHOD_VERSION, self.shape, SelectionParameters(), dict(self.means), self.digests)


def load_estimate(recording: Recording, predictors: Predictors, *, store: Store) -> dict[str, Any]:
    """The row of one recording, from the store if it was estimated before; a failed one with the reason."""
    try:
        origin = detections_origin(recording, store=store)
        key = digest("estimate", predictors.key, origin, _files(recording, predictors))
        kept = store.json(KIND, key)
        if kept is not None:
            return kept
        row = _estimated(recording, load_detections(recording, store=store), predictors, store)
    except CorsmalError as error:
        return {"recording_id": recording.id, "status": "failed", "notes": str(error)}
    store.save_json(KIND, key, row)
    return row


def _estimated(recording: Recording, detections: DetectionSet, predictors: Predictors, store: Store) -> dict[str, Any]:
    from corsmal.filling.features import recording_features  # noqa: PLC0415 - loads PyTorch

    result = estimate(
        recording,
        detections=detections.views,
        shape=predictors.shape,
        means=predictors.means,
        filling=predictors.filling,
        mass=predictors.mass,
        features=partial(recording_features, folder=predictors.features, store=store),
    )
    row = result.row()
    return {**row, "notes": "; ".join(filter(None, [*detections.notes, row["notes"]]))}


def _files(recording: Recording, predictors: Predictors) -> list[Any]:
    """What an estimate is made from, besides detections."""
    path = recording.audio_path if predictors.features is None else predictors.features / f"{recording.id}.npy"
    try:
        heard = None if path is None or predictors.filling is None else file_fingerprint(path)
    except FileError:
        heard = None
    return [recording.id, calibration_fingerprints(recording), heard]
