"""One frame of one view as the editor holds it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from corsmal.by_hand import FrameHistory, HandMask, MaskHistory
from corsmal.by_hand.record import CUP
from corsmal.detection import filter_detections
from corsmal.errors import ArgumentError
from corsmal.parameters import CONTAINER_CLASSES
from corsmal.ui import shared
from corsmal.ui.opened import OpenedRecording


@dataclass(frozen=True, eq=False)
class EditedFrame:
    """One frame of one view as it is edited; made anew after each change.

    Args:
        opened: the recording with its detected masks.
        view: of the method.
        frame: of the recording.
    """

    opened: OpenedRecording
    view: str
    frame: int

    @cached_property
    def own(self) -> int:
        """The view's own frame.

        Raises:
            ArgumentError: the view shows nothing with this frame.
        """
        own = self.opened.recording.clock().own(self.view, self.frame)
        if own is None:
            raise ArgumentError(f"{self.view} has no picture of frame {self.frame}")
        return own

    @property
    def masks(self) -> MaskHistory:
        """Of the view."""
        recording = self.opened.recording
        return MaskHistory(recording.id, recording.views[self.view], store=shared.store())

    @cached_property
    def history(self) -> FrameHistory:
        """Of the frame, as it was when this was first asked for."""
        return self.masks.frame(self.own)

    @cached_property
    def detected(self) -> HandMask | None:
        """The container that was detected in the frame wherever it is; None where none was."""
        found = self.opened.detections.views.get(self.view)
        if found is None or self.frame not in found:
            return None
        detections = found[self.frame]
        index = filter_detections(detections, centre_rule="none", parameters=self.opened.selection).container
        if index is None:
            return None
        label = int(detections.labels[index])
        return HandMask(
            self.own,
            detections.size,
            detections.counts[index],
            label=label if label in CONTAINER_CLASSES else CUP,
            based_on=f"{found.source}, detection {index + 1}",
        )

    @cached_property
    def shown(self) -> HandMask:
        """As ``history``: the mask by hand, else the detected one, else an empty one: what a tool changes."""
        width, height = self.opened.video(self.view).size
        empty = np.zeros((height, width), dtype=bool)
        return self.history.mask or self.detected or HandMask.of(empty, frame=self.own)
