"""What the filling network is given of a recording: log-mel rows of its sound, or an array made elsewhere."""

import tokenize
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset.audio import SAMPLE_RATE_HZ, ChannelRule, read_audio
from corsmal.dataset.layout import Recording
from corsmal.dataset.places import file_of
from corsmal.digests import digest
from corsmal.errors import FileError, NotFoundError
from corsmal.filling.config import FrontEnd
from corsmal.filling.frontend import LogMelParameters, check_loud, log_mel
from corsmal.notes import Note
from corsmal.store import Store

ARRAY_ROW_S = 0.96
"""Seconds of sound per row of (T, 128) arrays, as VGGish has it."""

RATE_MIN_HZ = 8_000
"""Sound of a lower sampling rate has little left of what the network learned from."""

READING = 2
"""Raised when a sound file is read in another way than before."""

KIND = "log-mel"
"""Where a store keeps log-mel rows."""


@dataclass(frozen=True, eq=False)
class Features:
    """What the network is given of one recording.

    Args:
        values: (C, T, 128) float32, C and T at least 1; finite, but for a front end without a floor.
        row_s: seconds from one row to the next.
        notes: sentences on how the sound was read, where that was not as expected.
    """

    values: NDArray[np.float32]
    row_s: float
    notes: tuple[str, ...] = ()


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

    Log-mel rows are rounded to half precision, stored or not, so that a stored answer is the computed one; those of a
    front end in single precision are kept as they are, with −∞ where it has no floor and the sound is silent. What
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
        FileError: the sound or the array is broken or not what it should be, or the sound's rate is too low.
    """
    parameters = parameters or LogMelParameters()
    ends_s = [end for end in (recording.sound_end_s, end_s) if end is not None]
    end_s = min(ends_s, default=None)
    cut = _cut_notes(recording)
    if folder is not None:
        return replace(_from_array(Path(folder), recording.id, parameters, end_s), notes=cut)
    if recording.audio_path is None:
        raise NotFoundError(f"recording {recording.id} has no sound: audio/{recording.id}.wav is missing")
    key = digest(KIND, READING, recording.audio_path, end_s, channels, parameters)
    kept = store.arrays(KIND, key) if store else None
    if kept is not None and {"rows", "notes"} <= set(kept):
        return Features(kept["rows"].astype(np.float32), parameters.row_s, (*cut, *_as_notes(kept["notes"])))
    audio = read_audio(recording.audio_path, end_s=end_s, channels=channels)
    if audio.sample_rate_hz < RATE_MIN_HZ:
        problem = f"was recorded at {audio.sample_rate_hz / 1000:g} kHz, too low for a prediction"
        raise FileError(recording.audio_path, f"{problem}; record at {SAMPLE_RATE_HZ / 1000:g} kHz")
    rows = log_mel(audio.samples, sample_rate_hz=audio.sample_rate_hz, parameters=parameters)
    if parameters.precision == "double":
        rows = rows.astype(np.float16)
    if store:
        store.save_arrays(KIND, key, rows=rows, notes=_as_array(audio.notes))
    return Features(rows.astype(np.float32), parameters.row_s, (*cut, *audio.notes))


def training_features(
    recording: Recording,
    *,
    front_end: FrontEnd = "paper",
    folder: str | Path | None = None,
    store: Store | None = None,
) -> Features:
    """What a network that has this front end is trained on of a recording; otherwise as ``recording_features``.

    With the authors' front end a recording whose recorder was not stopped (000377) is left out, as their program does.

    Raises:
        ArgumentError: the sound is silent where the front end has no number for silence.
        NotFoundError: the recording is left out, or as ``recording_features``.
        FileError: as ``recording_features``.
    """
    if front_end == "released" and recording.sound_end_s is not None:
        raise NotFoundError("its recorder was not stopped: the authors' program does not train on it")
    parameters = LogMelParameters.of(front_end)
    found = recording_features(recording, folder=folder, parameters=parameters, store=store)
    check_loud(found.values, row_s=found.row_s)
    return found


def _as_array(notes: Sequence[str]) -> NDArray[np.str_]:
    """(n, 2) sentences and their flags."""
    return np.array([[str(note), getattr(note, "flag", "")] for note in notes], dtype=np.str_).reshape(-1, 2)


def _as_notes(array: NDArray[Any]) -> list[str]:
    return [Note(str(sentence), flag=str(flag)) if flag else str(sentence) for sentence, flag in array]


def _cut_notes(recording: Recording) -> tuple[str, ...]:
    if recording.sound_end_s is None:
        return ()
    return (Note(f"it was cut at {recording.sound_end_s:.1f} s, its recorder was not stopped", flag="sound-cut"),)


def read_array(folder: Path, name: str, *, width: int) -> NDArray[Any]:
    """A recording's array in a folder, (rows, width) or (channels, rows, width) finite numbers of any type.

    Raises:
        NotFoundError: the folder has no array of the recording.
        FileError: there is no such folder, or the array is broken or of another form.
    """
    if not folder.is_dir():
        raise FileError(folder, "there is no such folder of features")
    path = file_of(folder, name, ".npy")
    if not path.is_file():
        raise NotFoundError(f"recording {name} has no features: {path} is missing")
    try:
        with path.open("rb") as file:
            array = np.lib.format.read_array(file, allow_pickle=False)
    except (OSError, ValueError, EOFError, MemoryError, tokenize.TokenError) as error:
        raise FileError(path, "is no NumPy array of numbers; make or download it again") from error
    _check(path, array, width)
    return np.asarray(array)


def _from_array(folder: Path, name: str, parameters: LogMelParameters, end_s: float | None) -> Features:
    array = read_array(folder, name, width=parameters.mels)
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
