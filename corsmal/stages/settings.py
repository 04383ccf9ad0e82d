"""What detections and estimates are made with, as a run keeps it and other processes get it: numbers and file names."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from corsmal.errors import ArgumentError
from corsmal.estimation import training_means
from corsmal.parameters import ShapeParameters
from corsmal.stages.estimates import Predictors
from corsmal.weights import WeightsFile, find_weights

if TYPE_CHECKING:
    from corsmal.dataset import Dataset
    from corsmal.detection import Detector

SEARCH_STEP = 10
"""The step of a search that is quick enough to precede an estimate."""

Method = Literal["coco", "demo"]


@dataclass(frozen=True)
class DetectorSettings:
    """A detector and the step of its search.

    Args:
        method: ``coco``: Mask R-CNN; ``demo``: the small network of the demo.
        weights: of the network; None: COCO's, for ``coco`` only.
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
            CorsmalError: the weights are missing or broken, or there is no such device.
        """
        from corsmal.detection import MaskRCNNDetector, SmallDetector  # noqa: PLC0415 - loads PyTorch

        if self.method == "demo" and self.weights is not None:
            return SmallDetector(self.weights, device=device)
        return MaskRCNNDetector(self.weights, device=device)


@dataclass(frozen=True)
class EstimateSettings:
    """Everything that an estimate is made with.

    Args:
        shape: parameters of the fit.
        means: the training set's means, see ``training_means``.
        filling: the filling network; None: type and level are left out.
        mass: the mass network; None: the container's mass is left out.
        features: folder of arrays for ``filling``; None: log-mel of the sound.
        detector: detects in recordings without detections before they are estimated; None: such a recording fails.
    """

    shape: ShapeParameters = field(default_factory=ShapeParameters.paper)
    means: Mapping[str, float] = field(default_factory=dict, hash=False)
    filling: WeightsFile | None = None
    mass: WeightsFile | None = None
    features: Path | None = None
    detector: DetectorSettings | None = None

    def open(self) -> Predictors:
        """Read the networks.

        Raises:
            FileError: weights are missing or broken.
        """
        from corsmal.filling import FillingPredictor  # noqa: PLC0415 - loads PyTorch
        from corsmal.mass import MassPredictor  # noqa: PLC0415 - as above

        return Predictors(
            shape=self.shape,
            means=dict(self.means),
            filling=None if self.filling is None else FillingPredictor(self.filling.path),
            mass=None if self.mass is None else MassPredictor(self.mass.path),
            features=self.features,
        )


def find_detector(method: Method, *, weights: Path | None = None, every: int = SEARCH_STEP) -> DetectorSettings:
    """A detector with the weights that are named, or else the method's own, see ``find_weights``."""
    path = find_weights("detector", weights).path if method == "demo" else weights and weights.resolve()
    return DetectorSettings(method, path, every)


def default_settings(
    dataset: "Dataset",
    *,
    shape: ShapeParameters,
    filling: Path | None = None,
    mass: Path | None = None,
    features: Path | None = None,
    detector: DetectorSettings | None = None,
) -> EstimateSettings:
    """Settings for a dataset, with its means and the networks that are named, set in the environment or bundled.

    Args:
        dataset: whose annotation gives the means.
        shape: parameters of the fit.
        filling: weights; default: see ``find_weights``. A network that is not named and whose file is missing is left
            out.
        mass: likewise.
        features: folder of arrays for the filling network.
        detector: detects in recordings without detections.
    """
    weights = {"filling": find_weights("filling", filling), "mass": find_weights("mass", mass)}
    found = {name: file if file.origin == "named" or file.path.is_file() else None for name, file in weights.items()}
    return EstimateSettings(
        shape=shape,
        means=training_means(dataset.table),
        **found,
        features=None if features is None else features.resolve(),
        detector=detector,
    )
