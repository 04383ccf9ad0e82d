"""A view's video by the frames of its recording, where the views do not have the same frames."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset.video import Video


class MatchedVideo(Video):
    """A video that has, for each frame of the recording, the one of its own that is nearest in time.

    Args:
        path: a video file.
        nearest: (n,) its own frame for each of the recording's, see ``FrameClock.nearest``.

    Raises:
        FileError: as of ``Video``.
    """

    def __init__(self, path: str | Path, nearest: NDArray[np.int64]) -> None:
        super().__init__(path)
        self._nearest = np.minimum(nearest, len(self._times) - 1)

    def __len__(self) -> int:
        return len(self._nearest)

    def _own(self, index: int) -> int:
        return int(self._nearest[index])
