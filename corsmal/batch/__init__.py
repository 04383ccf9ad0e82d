"""The stages of recordings, with what they computed kept in the store; and many recordings at once."""

from corsmal.batch.cluster import DaskCluster
from corsmal.batch.detecting import DetectionSet, detect_recording, load_detections
from corsmal.batch.engines import Engine, in_turn, run_batch
from corsmal.batch.estimating import Predictors, load_estimate
from corsmal.batch.fitting import load_fit
from corsmal.batch.processes import Processes
from corsmal.batch.tasks import DetectTask, EstimateTask
from corsmal.batch.walls import LearntWall, learn_wall
from corsmal.batch.weighing import mass_rows

__all__ = [
    "DaskCluster",
    "DetectTask",
    "DetectionSet",
    "Engine",
    "EstimateTask",
    "LearntWall",
    "Predictors",
    "Processes",
    "detect_recording",
    "in_turn",
    "learn_wall",
    "load_detections",
    "load_estimate",
    "load_fit",
    "mass_rows",
    "run_batch",
]
