"""What detections and estimates are made with, as a run keeps it and other processes get it: numbers and file names."""

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from corsmal.dataset import TrainedOn
from corsmal.dataset.clock import Matching
from corsmal.dataset.layout import Masks
from corsmal.errors import ArgumentError
from corsmal.estimation import TrainingMeans
from corsmal.filling.records import FEATURE_FOLDERS
from corsmal.parameters import SelectionParameters, ShapeParameters, selection_of
from corsmal.stages.estimates import Predictors, predictors_key
from corsmal.weights import Kind, WeightsFile, find_weights, network_digest, read_training

if TYPE_CHECKING:
    from corsmal.dataset import Dataset
    from corsmal.detection import Detector

SEARCH_STEP = 10
"""The step of a search that is quick enough to precede an estimate."""

Method = str
"""``coco``: Mask R-CNN; ``demo``: the small network of the demo; else the name of an entry point, see
``detection.entry_points``."""


@dataclass(frozen=True)
class DetectorSettings:
    """A detector and the step of its search.

    Args:
        method: see ``Method``.
        weights: of the network; None: COCO's for ``coco``, or what another package's detector has.
        every: step of the search for the best frame, see ``detect_recording``.

    Raises:
        ArgumentError: ``demo`` without weights.
    """

    method: Method = "coco"
    weights: Path | None = None
    every: int = 1

    def __post_init__(self) -> None:
        if self.method == "demo" and self.weights is None:
            raise ArgumentError("weights must name a file for the method 'demo', got None")

    def open(self, *, device: str | None = None) -> "Detector":
        """Read the network.

        Args:
            device: such as ``cuda:0``; default: a GPU when there is one, else the CPU.

        Raises:
            CorsmalError: there is no such method, the weights are missing or broken, or there is no such device.
        """
        from corsmal.detection import MaskRCNNDetector, SmallDetector, open_own_detector  # noqa: PLC0415 - PyTorch

        if self.method not in ("coco", "demo"):
            return open_own_detector(self.method, self.weights, device=device)
        if self.method == "demo" and self.weights is not None:
            return SmallDetector(self.weights, device=device)
        return MaskRCNNDetector(self.weights, device=device)


@dataclass(frozen=True)
class EstimateSettings:
    """Everything that an estimate is made with.

    Args:
        means: of a training set, which stand in where nothing can be fitted; None: a failure holds no numbers.
        filling: the filling network; None: type and level are left out.
        mass: the mass network; None: the container's mass is left out.
        features: folder of arrays for ``filling``; None: log-mel of the sound.
        sight: folder of arrays of the videos, for a fused network; None: it hears only.
        detector: detects in recordings without detections before they are estimated; None: such a recording fails.
        matching: how the frames of the recordings' views are matched.
        selection: how detections are filtered and frames scored.
        masks: which masks are used, see ``dataset.layout.Masks``.
    """

    shape: ShapeParameters = field(default_factory=ShapeParameters.paper)
    means: TrainingMeans | None = None
    filling: WeightsFile | None = None
    mass: WeightsFile | None = None
    features: Path | None = None
    sight: Path | None = None
    detector: DetectorSettings | None = None
    matching: Matching = field(default_factory=Matching)
    selection: SelectionParameters = field(default_factory=SelectionParameters)
    masks: Masks = "detected"

    @property
    def digests(self) -> dict[str, str | None]:
        """See ``Predictors``.

        Raises:
            FileError: a file of weights cannot be read.
        """
        files = {"filling": self.filling, "mass": self.mass}
        return {name: None if file is None else network_digest(file.kind, file.path) for name, file in files.items()}

    @property
    def key(self) -> str:
        """See ``Predictors``; found without opening the networks.

        Raises:
            FileError: a file of weights cannot be read.
        """
        return predictors_key(self.shape, self.selection, self.means, self.digests)

    def open(self) -> Predictors:
        """Read the networks.

        Raises:
            FileError: weights are missing or broken.
        """
        from corsmal.filling import open_filling  # noqa: PLC0415 - loads PyTorch
        from corsmal.mass import MassPredictor  # noqa: PLC0415 - as above

        return Predictors(
            shape=self.shape,
            means=self.means,
            filling=None if self.filling is None else open_filling(self.filling.path),
            mass=None if self.mass is None else MassPredictor(self.mass.path),
            features=self.features,
            sight=self.sight,
            selection=self.selection,
        )


def find_detector(method: Method, *, weights: Path | None = None, every: int = SEARCH_STEP) -> DetectorSettings:
    """A detector with the weights that are named, or else the method's own, see ``find_weights``."""
    path = find_weights("detector", weights).path if method == "demo" else weights and weights.resolve()
    return DetectorSettings(method, path, every)


def default_settings(
    dataset: "Dataset",
    *,
    shape: ShapeParameters,
    selection: SelectionParameters | None = None,
    means: TrainingMeans | None = None,
    filling: Path | str | None = None,
    mass: Path | str | None = None,
    features: Path | None = None,
    sight: Path | None = None,
    detector: DetectorSettings | None = None,
    matching: Matching | None = None,
    masks: Masks = "detected",
) -> EstimateSettings:
    """Settings for a dataset, with the networks that are named, set in the environment or bundled.

    The bundled networks were trained on synthetic recordings: on a dataset that is not synthetic they are left out
    unless they are named (``demo``), see ``left_out_note``. So is one that is not named and whose file is missing.
    Where no folder of features is named, those that the environment names are used, see ``FeatureFolders``.
    ``means`` are by default those that the weights of the mass or the filling network hold, ``selection`` that of the
    shape's preset; the other arguments are those of ``EstimateSettings``.

    Raises:
        FileError: weights that are named cannot be read.
    """
    weights = {"filling": find_weights("filling", filling), "mass": find_weights("mass", mass)}
    found = {name: file if may_speak(file, dataset) else None for name, file in weights.items()}
    if features is None and sight is None and os.environ.get(FEATURE_FOLDERS):
        from corsmal.filling.sight import FeatureFolders  # noqa: PLC0415 - loads PyTorch

        folders = FeatureFolders.in_environment()
        features, sight = folders.sound, folders.sight
    return EstimateSettings(
        shape=shape,
        means=means or _means_of_weights([file for file in (found["mass"], found["filling"]) if file is not None]),
        **found,
        features=None if features is None else features.resolve(),
        sight=None if sight is None else sight.resolve(),
        detector=detector,
        matching=matching or Matching(),
        selection=selection or selection_of(shape),
        masks=masks,
    )


def may_speak(file: WeightsFile, dataset: "Dataset") -> bool:
    """Whether a network is used on a dataset: it is named, or is there and was trained on such recordings."""
    if file.origin == "named":
        return True
    return file.path.is_file() and not (file.is_bundled and not is_synthetic(dataset))


def is_synthetic(dataset: "Dataset") -> bool:
    """Whether all recordings of a dataset that have files are rendered ones."""
    return all(recording.is_synthetic for recording in dataset if recording.views or recording.audio_path)


def left_out_note(dataset: "Dataset", settings: EstimateSettings) -> str:
    """What is to be said where bundled networks are left out; empty where they are not."""
    absent: list[Kind] = [
        kind
        for kind in ("filling", "mass")
        if getattr(settings, kind) is None and find_weights(kind).is_bundled and not is_synthetic(dataset)
    ]
    if not absent:
        return ""
    names = " and ".join(absent)
    options = " ".join(f"--{name} demo" for name in absent)
    return (
        f"No {names} estimates: the bundled networks were trained on synthetic recordings only. Train your own "
        f"(`python -m corsmal train {absent[0]}`), or use the bundled ones all the same: `{options}`."
    )


def _means_of_weights(files: list[WeightsFile]) -> TrainingMeans | None:
    """The means of the training set that weights hold."""
    for file in files:
        trained_on = TrainedOn.from_json(read_training(file.path, file.kind))
        if trained_on is not None and "means" in trained_on.facts:
            return TrainingMeans.from_json(trained_on.facts["means"])
    return None
