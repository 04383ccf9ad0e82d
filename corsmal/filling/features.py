"""What the filling network is given of a recording: log-mel rows of its sound, or an array made elsewhere."""

import tokenize
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset.audio import ChannelRule, read_audio
from corsmal.dataset.layout import Recording
from corsmal.digests import digest
from corsmal.errors import FileError, NotFoundError
from corsmal.filling.frontend import LogMelParameters, log_mel
from corsmal.store import Store

ARRAY_ROW_S = 0.96
"""Seconds of sound per row of (T, 128) arrays, as VGGish has it."""

KIND = "log-mel"
"""Where a store keeps log-mel rows."""


@dataclass(frozen=True, eq=False)
class Features:
    """What the network is given of one recording.

    Args:
        values: (C, T, 128) float32, finite, C and T at least 1.
        row_s: seconds from one row to the next.
    """

    values: NDArray[np.float32]
    row_s: float


def recording_features(
    recording: Recording,
    *,
    folder: str | Path | None = None,
    channels: ChannelRule = "strict",
    parameters: LogMelParameters | None = None,
    store: Store | None = None,
    end_s: float | None = None,
) -> Features:
    """A recording's features, from its sound or from a folder of arrays.

    Log-mel rows are rounded to half precision, stored or not, so that a stored answer is the computed one. What
    follows ``Recording.sound_end_s`` is left out, of the sound and of rows in a folder.

    Args:
        recording: the recording.
        folder: holds ``ID.npy``, (T, 128) with a row per 0.96 s or (C, T, 128) with the log-mel front end's rows;
            None: log-mel of the sound.
        channels: what to do with a sound of another number of channels than eight.
        parameters: of the log-mel front end; default: the paper's.
        store: keeps log-mel rows, so that they are computed once.
        end_s: leave out all that was heard later, as if the recorder had been stopped then; default: nothing.

    Raises:
        NotFoundError: the recording has no sound, or the folder no array of it.
        FileError: the sound or the array is broken or not what it should be.
    """
    parameters = parameters or LogMelParameters()
    ends_s = [end for end in (recording.sound_end_s, end_s) if end is not None]
    end_s = min(ends_s, default=None)
    if folder is not None:
        return _from_array(Path(folder), recording.id, parameters, end_s)
    if recording.audio_path is None:
        raise NotFoundError(f"recording {recording.id} has no sound: audio/{recording.id}.wav is missing")
    key = digest(KIND, recording.audio_path, end_s, channels, parameters)
    kept = store.arrays(KIND, key) if store else None
    if kept is not None and "rows" in kept:
        return Features(kept["rows"].astype(np.float32), parameters.row_s)
    audio = read_audio(recording.audio_path, end_s=end_s, channels=channels)
    rows = log_mel(audio.samples, sample_rate_hz=audio.sample_rate_hz, parameters=parameters).astype(np.float16)
    if store:
        store.save_arrays(KIND, key, rows=rows)
    return Features(rows.astype(np.float32), parameters.row_s)


def _from_array(folder: Path, name: str, parameters: LogMelParameters, end_s: float | None) -> Features:
    if not folder.is_dir():
        raise FileError(folder, "there is no such folder of features")
    path = folder / f"{name}.npy"
    if not path.is_file():
        raise NotFoundError(f"recording {name} has no features: {path} is missing")
    try:
        with path.open("rb") as file:
            array = np.lib.format.read_array(file, allow_pickle=False)
    except (OSError, ValueError, EOFError, MemoryError, tokenize.TokenError) as error:
        raise FileError(path, "is no NumPy array of numbers; make or download it again") from error
    _check(path, array, parameters.mels)
    is_plain = array.ndim == 2
    row_s = ARRAY_ROW_S if is_plain else parameters.row_s
    values = array[None] if is_plain else array
    if end_s is not None:
        # a row of a plain array is a stretch of sound; a log-mel row is an instant, the first at 0 s
        rows = int(end_s / row_s) + (0 if is_plain else 1)
        values = values[:, :rows]
        if not values.shape[1]:
            raise NotFoundError(f"recording {name} has no features before {end_s:.2f} s")
    return Features(np.ascontiguousarray(values, dtype=np.float32), row_s)


def _check(path: Path, array: NDArray[Any], width: int) -> None:
    shape = f"(rows, {width}) or (channels, rows, {width})"
    if array.dtype.kind not in "fiu":
        raise FileError(path, f"must hold numbers, {shape}, and holds {array.dtype}")
    if array.ndim not in (2, 3) or array.shape[-1] != width or 0 in array.shape:
        raise FileError(path, f"has shape {array.shape} where {shape} is expected")
    if not (np.abs(array) <= np.finfo(np.float32).max).all():
        raise FileError(path, "holds numbers that are not finite; make or download it again")
