"""What is done with each recording, as it travels to other processes: settings and names of files.

The networks themselves stay where they are: each process opens them once.
"""

import platform
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from corsmal.dataset import Recording, Video, View
from corsmal.detection import Detector, detect_view
from corsmal.digests import file_fingerprint
from corsmal.engines.engine import Row
from corsmal.errors import CorsmalError
from corsmal.estimation import counted_frames
from corsmal.stages.detections import needs_detection
from corsmal.stages.estimates import Predictors, load_estimate
from corsmal.stages.inspection import Piece
from corsmal.stages.search import detect_recording
from corsmal.stages.settings import DetectorSettings, EstimateSettings
from corsmal.store import Store


@dataclass(frozen=True)
class DetectTask:
    """Detecting in a recording.

    Args:
        cache: folder of the store.
        detector: what is detected with.
        digest: of the detector that is meant; a process whose weights give another one refuses. Empty: any.
        frames: called with the recording's id and the numbers of frames done and wanted; for this process only.
    """

    cache: Path
    detector: DetectorSettings = field(default_factory=DetectorSettings)
    digest: str = ""
    frames: Callable[[str, int, int], None] | None = field(default=None, compare=False)

    def __call__(self, recording: Recording) -> Row:
        """Detect, and keep the detections."""
        report = None if self.frames is None else partial(self.frames, recording.id)
        detector = open_detector(self.detector, self.digest)
        detect_recording(recording, detector, store=Store(self.cache), every=self.detector.every, progress=report)
        return {"recording_id": recording.id, "status": "detected", "notes": ""}


@dataclass(frozen=True)
class EstimateTask:
    """Estimating a recording, after detecting in it where the settings say so and no other detector has.

    Args:
        cache: folder of the store.
        settings: what is estimated with.
        key: of the predictors that are meant, see ``Predictors.key``; a process that has others refuses. Empty: any.
        digest: of the detector that is meant, likewise.
        cancelled: checked while detecting; true stops that. For this process only.
        frames: called with the numbers of frames that are inspected and wanted. For this process only.
    """

    cache: Path
    settings: EstimateSettings
    key: str = ""
    digest: str = ""
    cancelled: Callable[[], bool] | None = field(default=None, compare=False)
    frames: Callable[[int, int], object] | None = field(default=None, compare=False)

    def __call__(self, recording: Recording) -> Row:
        """The recording's row, from the store if it was estimated before."""
        store, detector, problem = Store(self.cache), self.settings.detector, ""
        if detector is not None and needs_detection(recording, self.digest, store=store):
            network = open_detector(detector, self.digest)
            here: dict[str, Any] = {"cancelled": self.cancelled, "progress": self.frames}
            try:
                frames = counted_frames(recording, self.settings.selection)
                detect_recording(recording, network, store=store, every=detector.every, frames=frames, **here)
            except CorsmalError as error:
                problem = str(error)
        row = load_estimate(recording, open_predictors(self.settings, self.key), store=store)
        return {**row, "notes": "; ".join(filter(None, [problem, row["notes"]]))}


@dataclass(frozen=True)
class InspectTask:
    """Detecting in some frames of a view, with nothing kept; without a piece only the detector is opened.

    Args:
        detector: what is detected with.
    """

    detector: DetectorSettings

    def __call__(self, piece: Piece | None) -> Row:
        """What was found, and how long it took."""
        detector = open_detector(self.detector, "")
        if piece is None:
            return {"digest": detector.digest}
        view, frames = piece
        began_s = time.monotonic()
        found = detect_view(_open_video(view, file_fingerprint(view.video_path)), detector, frames=frames)
        return {"found": found, "seconds": time.monotonic() - began_s}


@lru_cache(maxsize=1)
def open_detector(settings: DetectorSettings, digest: str) -> Detector:
    """The detector of this process, open for all recordings.

    Raises:
        CorsmalError: its weights are missing or broken, or it is not the one that is meant.
    """
    detector = settings.open()
    _check(digest, detector.digest, "the detector's weights")
    return detector


@lru_cache(maxsize=1)
def open_predictors(settings: EstimateSettings, key: str) -> Predictors:
    """The predictors of this process, open for all recordings.

    Raises:
        CorsmalError: weights are missing or broken, or the predictors are not those that are meant.
    """
    predictors = settings.open()
    _check(key, predictors.key, "the networks or the version of the method")
    return predictors


@lru_cache(maxsize=3)
def _open_video(view: View, _fingerprint: object) -> Video:
    """The video of a view, open for all pieces of it."""
    return view.video()


def _check(expected: str, found: str, what: str) -> None:
    if expected and found != expected:
        raise CorsmalError(f"{what} on {platform.node()} differ from those where the run was started")
