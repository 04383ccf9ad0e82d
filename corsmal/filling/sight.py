"""What the fused network is given of a recording's videos: an array made elsewhere, such as R(2+1)D's."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from corsmal.errors import FileError
from corsmal.filling.features import read_array

WIDTH = 512
"""Features per row of R(2+1)D-18."""

VIEWS = 3
"""The dataset's view1, view2 and view3, in this order."""

CLIP_FRAMES = 16
"""Frames that a row is computed from."""


@dataclass(frozen=True)
class FeatureFolders:
    """Folders of arrays, one for each sense.

    Args:
        sound: see ``recording_features``; None: log-mel of the sound.
        sight: see ``sight_features``; None: there is no sight.
    """

    sound: Path | None = None
    sight: Path | None = None

    @classmethod
    def of(cls, folders: Sequence[Path]) -> "FeatureFolders":
        """The folders by what their arrays are: rows of 512 numbers are sight, all others are sound.

        Raises:
            FileError: a folder is absent or has no array, or two hold the same sense.
        """
        found: dict[str, Path] = {}
        for folder in folders:
            sense = "sight" if _width(folder) == WIDTH else "sound"
            if sense in found:
                raise FileError(folder, f"holds features of {sense}, as does {found[sense]}; name one folder of each")
            found[sense] = folder
        return cls(**found)


def sight_features(folder: Path, name: str) -> NDArray[np.float32]:
    """The rows of a recording's views, (3, T, 512) float32; a view that is missing is zero everywhere.

    Args:
        folder: holds ``ID.npy``, (3, T, 512), a row per 16 frames.
        name: the recording's id.

    Raises:
        NotFoundError: the folder has no array of it.
        FileError: the array is broken or of another form.
    """
    array = read_array(folder, name, width=WIDTH)
    if array.ndim != 3 or len(array) != VIEWS:
        raise FileError(folder / f"{name}.npy", f"has shape {array.shape} where ({VIEWS}, rows, {WIDTH}) is expected")
    return np.ascontiguousarray(array, dtype=np.float32)


def _width(folder: Path) -> int:
    """Numbers per row of the first array in a folder."""
    if not folder.is_dir():
        raise FileError(folder, "there is no such folder of features")
    path = min(folder.glob("*.npy"), default=None)
    if path is None:
        raise FileError(folder, "holds no arrays named ID.npy")
    try:
        return int(np.load(path, mmap_mode="r", allow_pickle=False).shape[-1])
    except (OSError, ValueError, EOFError, IndexError) as error:
        raise FileError(path, "is no NumPy array of numbers; make or download it again") from error
