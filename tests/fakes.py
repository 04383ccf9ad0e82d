"""Stand-ins that more than one file of tests uses."""

import numpy as np

from corsmal.detection import Detections
from corsmal.filling import FillingPrediction, LogMelParameters
from corsmal.mass import MassPrediction, restore_mask
from tests.tiny import CUP


class FakeDetector:
    """Finds one cup in every frame, and counts the frames."""

    name = "a test's detector"
    digest = "1"

    def __init__(self):
        self.seen = 0

    def detect(self, frames):
        self.seen += len(frames)
        mask = np.zeros((1, 360, 640), dtype=bool)
        mask[0, 150:200, 300:340] = True
        return [Detections([[300, 150, 340, 200]], [0.9], [CUP], mask) for _ in frames]


class FakeFilling:
    """A filling network that always gives the same answer, and notes what it heard."""

    name = "a fake filling network"

    def __init__(self, filling_type: int, filling_level: int) -> None:
        self.answer = (filling_type, filling_level)
        self.digest = f"fake filling {self.answer}"
        self.front_end = LogMelParameters()
        self.trained_on = None
        self.heard: np.ndarray | None = None
        self.steps_s: float | None = None

    def predict(
        self, features: np.ndarray, *, crop: tuple[int, int] | None = None, steps_s: float | None = None
    ) -> FillingPrediction:
        self.heard, self.steps_s = features, steps_s
        types, levels = np.zeros(4), np.zeros(3)
        types[self.answer[0]] = levels[self.answer[1]] = 3.0
        return FillingPrediction(types, levels, steps_s=steps_s, rows=crop)


class FakeMass:
    """A mass network that always gives the same answer, or none, and notes what it was asked."""

    name = "a fake mass network"

    def __init__(self, mass_g: float | None) -> None:
        self.answer = mass_g
        self.digest = f"fake mass {mass_g}"
        self.trained_on = None
        self.mask: np.ndarray | None = None
        self.inputs: dict[str, float | None] = {}

    def predict(self, mask: np.ndarray, **inputs: float | None) -> MassPrediction:
        self.mask, self.inputs = mask, inputs
        return MassPrediction(self.answer, "" if self.answer is not None else "nobody knows", restore_mask(mask), None)
