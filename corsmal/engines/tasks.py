"""What is done with each recording of a batch, as it travels to other processes: settings and names of files.

The networks themselves stay where they are: each process opens them once.
"""

import platform
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache, partial
from pathlib import Path
from typing import Literal

from corsmal.dataset import Recording
from corsmal.detection import Detector
from corsmal.engines.engine import Row
from corsmal.errors import CorsmalError
from corsmal.parameters import ShapeParameters
from corsmal.stages.detections import detect_recording
from corsmal.stages.estimates import Predictors, load_estimate
from corsmal.store import Store

Method = Literal["coco", "small"]


@dataclass(frozen=True)
class DetectTask:
    """Detecting in a recording.

    Args:
        cache: folder of the store.
        method: ``coco``: Mask R-CNN; ``small``: the demo's.
        weights: of the network; None: COCO's, for ``coco`` alone.
        every: step of the search for the best frame, see ``detect_recording``.
        digest: of the detector that is meant; a process whose weights give another one refuses. Empty: any.
        frames: called with the recording's id and the numbers of frames done and wanted; for this process alone.
    """

    cache: Path
    method: Method = "coco"
    weights: Path | None = None
    every: int = 1
    digest: str = ""
    frames: Callable[[str, int, int], None] | None = field(default=None, compare=False)

    def open(self) -> Detector:
        """Open the network for this process; it stays open for all recordings.

        Raises:
            CorsmalError: as ``detector``.
        """
        return _detector(self)

    def detector(self, device: str | None = None) -> Detector:
        """Open the network.

        Raises:
            CorsmalError: the weights are absent, broken, or others than those that are meant.
        """
        from corsmal.detection import MaskRCNNDetector, SmallDetector  # noqa: PLC0415 - loads PyTorch

        if self.method == "small" and self.weights is not None:
            detector: Detector = SmallDetector(self.weights, device=device)
        else:
            detector = MaskRCNNDetector(self.weights, device=device)
        _check(self.digest, detector.digest, "the detector's weights")
        return detector

    def __call__(self, recording: Recording) -> Row:
        """Detect, and keep the detections."""
        report = None if self.frames is None else partial(self.frames, recording.id)
        store = Store(self.cache)
        detect_recording(recording, self.open(), store=store, every=self.every, progress=report)
        return {"recording_id": recording.id, "status": "detected", "notes": ""}


@dataclass(frozen=True)
class EstimateTask:
    """Estimating a recording.

    Args:
        cache: folder of the store.
        shape: parameters of the fit.
        means: the training set's means, name and value each.
        filling: weights of the filling network; None: it is left out.
        mass: weights of the mass network; None: it is left out.
        features: folder of arrays for the filling network; None: log-mel of the sound.
        key: of the predictors that are meant, see ``Predictors.key``; a process that has others refuses. Empty: any.
    """

    cache: Path
    shape: ShapeParameters = field(default_factory=ShapeParameters.paper)
    means: tuple[tuple[str, float], ...] = ()
    filling: Path | None = None
    mass: Path | None = None
    features: Path | None = None
    key: str = ""

    def predictors(self) -> Predictors:
        """Open the networks.

        Raises:
            CorsmalError: weights are absent, broken, or others than those that are meant.
        """
        from corsmal.filling import FillingPredictor  # noqa: PLC0415 - loads PyTorch
        from corsmal.mass import MassPredictor  # noqa: PLC0415 - as above

        predictors = Predictors(
            shape=self.shape,
            means=dict(self.means),
            filling=None if self.filling is None else FillingPredictor(self.filling),
            mass=None if self.mass is None else MassPredictor(self.mass),
            features=self.features,
        )
        _check(self.key, predictors.key, "the networks or the version of corsmal")
        return predictors

    def __call__(self, recording: Recording) -> Row:
        """The recording's row, from the store if it was estimated before."""
        return load_estimate(recording, _predictors(self), store=Store(self.cache))


def _check(expected: str, found: str, what: str) -> None:
    if expected and found != expected:
        raise CorsmalError(f"{what} on {platform.node()} differ from those where the run was started")


@lru_cache(maxsize=1)
def _detector(task: DetectTask) -> Detector:
    return task.detector()


@lru_cache(maxsize=1)
def _predictors(task: EstimateTask) -> Predictors:
    return task.predictors()
