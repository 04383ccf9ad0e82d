from .annotation import Annotation as Annotation
from .audio import Audio as Audio
from .layout import Recording as Recording
from .layout import View as View
from .opening import Dataset as Dataset
from .opening import open_dataset as open_dataset
from .provenance import TrainedOn as TrainedOn
from .video import Video as Video
