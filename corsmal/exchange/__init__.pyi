from .annotations import ANNOTATION_FORMS as ANNOTATION_FORMS
from .annotations import export_detections as export_detections
from .rerun import write_rerun as write_rerun
