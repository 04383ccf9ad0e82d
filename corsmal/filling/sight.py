"""What the fused network is given of a recording's videos: an array made elsewhere, such as R(2+1)D's."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset.layout import Recording
from corsmal.errors import FileError, NotFoundError
from corsmal.filling.features import ARRAY_ROW_S, Features, read_array, recording_features
from corsmal.filling.records import FEATURE_FOLDERS

WIDTH = 512
"""Features per row of R(2+1)D-18."""

VIEWS = 3
"""The dataset's view1, view2 and view3, in this order."""

CLIP_FRAMES = 16
"""Frames that a row is computed from."""

ROW_S = CLIP_FRAMES / 30
"""Seconds from one row to the next, at the dataset's frame rate."""


SLACK_S = 1e-6
"""By which a row that ends where a stretch does may exceed it: sums of lengths are rounded."""

NO_SIGHT = (
    "no features of the videos are named; make them with the command features and name their folder in "
    f"{FEATURE_FOLDERS}"
)


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

    @classmethod
    def in_environment(cls) -> "FeatureFolders":
        """Those that ``CORSMAL_FEATURES`` names; errors are those of ``of``."""
        named = [name for name in os.environ.get(FEATURE_FOLDERS, "").split(os.pathsep) if name]
        return cls.of([Path(name).expanduser().absolute() for name in named])


@dataclass(frozen=True, eq=False)
class Senses:
    """What a fused network is given of one recording.

    Args:
        sound: features of its sound; None: it is missing.
        sight: (3, T, 512) float32 of its videos; None: they are missing.
        notes: sentences on what is missing, and on how the sound was read.
    """

    sound: Features | None
    sight: NDArray[np.float32] | None
    notes: tuple[str, ...]

    @property
    def duration_s(self) -> float:
        """How long a recording the longer sense is of, s."""
        heard_s = 0.0 if self.sound is None else self.sound.values.shape[1] * self.sound.row_s
        return max(heard_s, 0.0 if self.sight is None else self.sight.shape[1] * ROW_S)


def recording_senses(recording: Recording, *, sight: Path | None, folder: Path | None = None, **heard: Any) -> Senses:
    """A recording's sound and sight; either may be missing, which is noted.

    Args:
        recording: the recording.
        sight: folder of ``sight_features``; None: the videos' features are missing.
        folder: of the sound's arrays; None: log-mel of the sound.
        heard: further arguments of ``recording_features``. Where ``end_s`` ends the sound, sight ends, too.

    Raises:
        NotFoundError: both are missing.
        FileError: an array or the sound is broken.
    """
    notes: list[str] = []
    sound, seen = None, None
    try:
        sound = recording_features(recording, folder=folder, **heard)
        notes += sound.notes
    except NotFoundError as error:
        notes.append(str(error))
    try:
        if sight is None:
            raise NotFoundError(NO_SIGHT)
        seen = sight_features(sight, recording.id, end_s=heard.get("end_s"))
    except NotFoundError as error:
        notes.append(str(error))
    if sound is None and seen is None:
        raise NotFoundError("; ".join(notes))
    return Senses(sound, seen, tuple(notes))


def part_of(given: Senses, start_s: float, end_s: float) -> Senses:
    """What was heard and seen in a stretch of a recording, of which rows count that lie within it whole.

    Args:
        given: of the whole recording.
        start_s: seconds from its start.
        end_s: likewise.

    Returns:
        The rows; a sense that has none there is missing.

    Raises:
        NotFoundError: neither has any.
    """
    sound, sight = given.sound, given.sight
    if sound is not None:
        length_s = ARRAY_ROW_S if sound.row_s == ARRAY_ROW_S else 0.0  # a log-mel row is an instant
        rows = _rows_within(sound.values.shape[1], sound.row_s, length_s, start_s, end_s)
        sound = replace(sound, values=sound.values[:, rows]) if rows.start < rows.stop else None
    if sight is not None:
        rows = _rows_within(sight.shape[1], ROW_S, ROW_S, start_s, end_s)
        sight = sight[:, rows] if rows.start < rows.stop else None
    if sound is None and sight is None:
        raise NotFoundError(f"no row of features lies between {start_s:.2f} and {end_s:.2f} s")
    return replace(given, sound=sound, sight=sight)


def _rows_within(total: int, row_s: float, length_s: float, start_s: float, end_s: float) -> slice:
    starts_s = np.arange(total) * row_s
    inside = np.flatnonzero((starts_s >= start_s - SLACK_S) & (starts_s + length_s <= end_s + SLACK_S))
    return slice(int(inside[0]), int(inside[-1]) + 1) if len(inside) else slice(0, 0)


def sight_features(folder: Path, name: str, *, end_s: float | None = None) -> NDArray[np.float32]:
    """The rows of a recording's views, (3, T, 512) float32; a view that is missing is zero everywhere.

    Args:
        folder: holds ``ID.npy``, (3, T, 512), a row per 16 frames.
        name: the recording's id.
        end_s: leave out clips that end later; default: none.

    Raises:
        NotFoundError: the folder has no array of it, or nothing was seen by then.
        FileError: the array is broken or of another form.
    """
    array = read_array(folder, name, width=WIDTH)
    if array.ndim != 3 or len(array) != VIEWS:
        raise FileError(folder / f"{name}.npy", f"has shape {array.shape} where ({VIEWS}, rows, {WIDTH}) is expected")
    rows = array.shape[1] if end_s is None else int(end_s / ROW_S)
    if not rows:
        raise NotFoundError(f"recording {name} has no features of its views before {end_s:.2f} s")
    return np.ascontiguousarray(array[:, :rows], dtype=np.float32)


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
