from .training.detector import train_detector as train_detector
from .training.detector_report import detector_report as detector_report
from .training.detector_report import detector_table as detector_table
from .training.frames import DetectorTraining as DetectorTraining
from .writing.dataset import DemoProgress as DemoProgress
from .writing.dataset import write_demo as write_demo
from .writing.parts import ANNOTATION_FILE as ANNOTATION_FILE
