"""Stand-ins that more than one file of tests uses."""

import numpy as np

from corsmal.detection import Detections
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
