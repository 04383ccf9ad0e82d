"""Run a detector over a video."""

from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from corsmal.detection.record import Detections
from corsmal.detection.view import ViewDetections
from corsmal.errors import ArgumentError, CorsmalError

if TYPE_CHECKING:
    from corsmal.dataset import Video

Frame = NDArray[np.uint8]
"""(H, W, 3) RGB."""


class Detector(Protocol):
    """What finds objects in images."""

    @property
    def name(self) -> str:
        """For people, such as ``Mask R-CNN, COCO weights``."""

    @property
    def digest(self) -> str:
        """Changes with everything that its detections depend on besides the image."""

    def detect(self, frames: Sequence[Frame]) -> list[Detections]:
        """The detections of each (H, W, 3) uint8 RGB image."""


def detect_view(
    video: "Video",
    detector: Detector,
    *,
    frames: Sequence[int] | None = None,
    batch_size: int = 4,
    progress: Callable[[int, int], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> ViewDetections:
    """Detect in a video's frames.

    When it is cancelled, or the video cannot be read to its end, what was done until then is returned, and
    ``problems`` says so.

    Args:
        video: the view's video.
        detector: such as ``MaskRCNNDetector``.
        frames: the frames to inspect; default: all.
        batch_size: number of frames handed to the detector at a time.
        progress: called after every batch with the numbers of frames done and wanted.
        cancelled: checked before every batch; true stops the work.

    Raises:
        ArgumentError: ``batch_size`` or a frame is out of range, or the detector returns the wrong number of results.
    """
    wanted = tuple(range(video.frame_count)) if frames is None else tuple(sorted(set(frames)))
    if wanted and not 0 <= wanted[0] <= wanted[-1] < video.frame_count:
        raise ArgumentError(f"frames must lie in 0..{video.frame_count - 1}, got {wanted[0]}..{wanted[-1]}")
    if batch_size < 1:
        raise ArgumentError(f"batch_size must be at least 1, got {batch_size}")
    found: dict[int, Detections] = {}
    problems: list[str] = []
    reader = _readable(video, wanted, problems)
    while batch := list(islice(reader, batch_size)):
        if cancelled is not None and cancelled():
            problems.append("detection was stopped")
            break
        results = detector.detect([image for _, image in batch])
        if len(results) != len(batch):
            raise ArgumentError(f"detector returned {len(results)} results for {len(batch)} frames")
        found.update((index, result) for (index, _), result in zip(batch, results, strict=True))
        if progress is not None:
            progress(len(found), len(wanted))
    if len(found) < len(wanted):
        problems.append(f"{len(found)} of {len(wanted)} frames were inspected")
    width, height = video.size
    return ViewDetections(found, size=(height, width), source=detector.name, problems=tuple(problems))


def _readable(video: "Video", wanted: tuple[int, ...], problems: list[str]) -> Iterator[tuple[int, Frame]]:
    """Frame numbers and images until the video breaks, which leaves a sentence in ``problems``."""
    try:
        if len(wanted) == video.frame_count:
            yield from enumerate(islice(video, len(wanted)))  # reading on is faster than seeking
        else:
            for index in wanted:
                yield index, video[index]
    except CorsmalError as error:
        problems.append(f"the video cannot be read on: {error}")
