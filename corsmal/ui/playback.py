"""What the time line plays: pictures of frames with their detections, and the sound. Routes call it, outside a page."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset import Recording, Video
from corsmal.detection import ViewDetections, filter_detections
from corsmal.errors import NotFoundError
from corsmal.figures import draw_detections, jpeg
from corsmal.parameters import CentreRule, SelectionParameters
from corsmal.ui import media

PICTURE_WIDTH_PX = 640
"""Three of them side by side fill a screen. Half of 1280 pixels is made in a fraction of the time of three quarters."""

ORIGINAL_QUALITY = 95


def with_detections(
    image: NDArray[np.uint8],
    found: ViewDetections | None,
    frame: int,
    *,
    centre_rule: CentreRule,
    selection: SelectionParameters,
) -> NDArray[np.uint8]:
    """A frame of a view with its detections drawn on it where it was inspected: (H, W, 3) uint8 RGB."""
    if found is None or frame not in found:
        return image
    filtered = filter_detections(found[frame], centre_rule=centre_rule, parameters=selection)
    return draw_detections(image, found[frame], filtered)


@dataclass(frozen=True, eq=False)
class Playback:
    """A recording as it is played. Several threads may use one.

    Args:
        recording: the recording.
        videos: the views that can be read. Each is decoded in sequence as long as frames are asked for in sequence.
        detections: by view.
        centre_rule: the rule by which detections are dropped.
        selection: the other rules.
    """

    recording: Recording
    videos: Mapping[str, Video]
    detections: Mapping[str, ViewDetections]
    centre_rule: CentreRule
    selection: SelectionParameters = field(default_factory=SelectionParameters)

    def picture(self, view: str, frame: int) -> bytes:
        """One frame as JPEG, with its detections.

        Raises:
            NotFoundError: there is no such view or frame.
            FileError: the frame is damaged.
        """
        image, found = self._image(view, frame), self.detections.get(view)
        drawn = with_detections(image, found, frame, centre_rule=self.centre_rule, selection=self.selection)
        return jpeg(drawn, width=PICTURE_WIDTH_PX)

    def original(self, view: str, frame: int) -> bytes:
        """One frame as JPEG of its own size, nothing drawn on it; raises what ``picture`` does."""
        return jpeg(self._image(view, frame), quality=ORIGINAL_QUALITY)

    def _image(self, view: str, frame: int) -> NDArray[np.uint8]:
        if view not in self.videos or frame < 0:
            raise NotFoundError(f"recording {self.recording.id} has no frame {frame} of {view}")
        return self.videos[view][frame]

    def sound(self, channel: int | None) -> bytes:
        """One channel, from 0, or the mean of all, as a WAV with the fixed gain.

        Raises:
            NotFoundError: the recording has no sound.
            FileError: it cannot be read.
        """
        return media.audio_wav(self.recording.audio(), channel=channel)
