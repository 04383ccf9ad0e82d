"""Calibration files: the colour camera of a view, and in which unit its place was written."""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset.plain_pickle import UNPICKLING_ERRORS, ForbiddenError, PlainArray, load_plain
from corsmal.errors import ArgumentError, FileError
from corsmal.geometry import Camera
from corsmal.notes import Note

CALIBRATED_SIZE = (1280, 720)
"""Width and height, in pixels, of the images that the intrinsics of the calibration files are for."""

BYTES_MAX = 1_000_000
"""The dataset's files have about 4 kB; a larger one is no calibration."""

METRES_MAX, CENTIMETRES_MAX, MILLIMETRES_MAX = 10.0, 300.0, 20_000.0
"""The largest distance of a camera from the world's origin, as its file gives it, that is taken for metres, for
centimetres and for millimetres. The dataset's cameras are half a metre to a metre from it."""

CHECKED_POINTS_M = np.array([[0, 0, 0, 1], [0.1, 0, 0, 1], [0, 0.1, 0, 1], [0, 0, 0.1, 1]])
CONTRADICTION_PX = 10.0
"""Points of the table that both descriptions of a camera must show alike, and how nearly."""

NUMBERS_MAX = 16
DEPTH_MAX = 3
"""Of nested lists of numbers: a matrix has 9 numbers and is two deep."""

_SENSOR = "rgb"


@dataclass(frozen=True, eq=False)
class Calibration:
    """A calibration file.

    Args:
        camera: the colour camera.
        notes: sentences on how the file was read, where it was not as expected.
    """

    camera: Camera
    notes: tuple[str, ...] = ()


def read_camera(path: str | Path) -> Camera:
    """Read the colour camera from a calibration file; see ``read_calibration``."""
    return read_calibration(path).camera


def read_calibration(path: str | Path) -> Calibration:
    """Read the colour camera from a calibration file.

    The file is a list or tuple whose item 0 maps ``rgb`` to a (3, 3) intrinsic matrix and whose item 1 maps ``rgb`` to
    ``rvec``, a (3, 3) rotation *matrix*, and ``tvec``, (3,) or (3, 1) metres. A ``tvec`` that puts the camera too far
    away for metres is taken for centimetres or millimetres. The redundant ``projMatrix``, (3, 4), is only compared.

    Args:
        path: a pickle, as Python 2 or 3 and NumPy 1 or 2 write it; the line ends of a text pickle may have changed.

    Returns:
        The camera for images of 1280×720 pixels, and how the file was read.

    Raises:
        FileError: the file is absent, is no pickle, holds anything other than containers, strings, numbers and number
            arrays, gives no extrinsics, or its numbers are no camera.
    """
    path = Path(path)
    content, notes = _load(path)
    if not isinstance(content, list | tuple) or len(content) < 2:
        raise FileError(path, "is no calibration: a list of intrinsics and extrinsics was expected")
    if content[1] is None:
        raise FileError(
            path, "has no extrinsics, only intrinsics: this camera was moving and cannot be used for geometry"
        )
    try:
        intrinsic, extrinsic = content[0][_SENSOR], content[1][_SENSOR]
        rotation, translation = extrinsic["rvec"], extrinsic["tvec"]
    except (LookupError, TypeError) as error:
        raise FileError(path, f"is no calibration: '{_SENSOR}' with 'rvec' and 'tvec' was expected") from error
    try:
        arrays = [_numbers(value) for value in (intrinsic, rotation, translation)]
        camera = Camera(arrays[0], arrays[1], arrays[2].reshape(-1), CALIBRATED_SIZE)
    except (ArgumentError, TypeError, ValueError, OverflowError) as error:
        raise FileError(
            path, f"is no usable calibration: {error} ('rvec' is the rotation, 'tvec' the translation)"
        ) from error
    found = _in_metres(camera, notes)
    return replace(found, notes=(*found.notes, *_contradiction(found.camera, extrinsic)))


def _in_metres(camera: Camera, notes: tuple[str, ...]) -> Calibration:
    """The camera with its translation in metres, whatever unit it seems to be in."""
    distance = math.hypot(*camera.translation)
    if distance <= METRES_MAX or distance > MILLIMETRES_MAX:
        return Calibration(camera, notes)
    unit, per_metre = ("cm", 100.0) if distance <= CENTIMETRES_MAX else ("mm", 1000.0)
    sentence = (
        f"'tvec' has a length of {distance:.0f}, too much for metres, and was taken for {unit}, "
        f"which puts the camera {distance / per_metre:.2f} m from the world's origin"
    )
    scaled = replace(camera, translation=camera.translation / per_metre)
    return Calibration(scaled, (*notes, Note(sentence, flag="unit-assumed")))


def _contradiction(camera: Camera, extrinsic: Any) -> tuple[Note, ...]:
    """A sentence where ``projMatrix`` shows points about the world's origin elsewhere than the camera does."""
    try:
        with np.errstate(all="raise", under="ignore"):
            x, y, scale = _numbers(extrinsic["projMatrix"]) @ CHECKED_POINTS_M.T
            pixels = np.column_stack([x / scale, y / scale])
    except (LookupError, TypeError, ValueError, OverflowError, FloatingPointError):
        return ()
    away_px = float(np.abs(pixels - camera.project(CHECKED_POINTS_M[:, :3])).max())
    if not away_px > CONTRADICTION_PX:  # what cannot be compared contradicts nothing
        return ()
    sentence = f"'projMatrix' contradicts 'rvec' and 'tvec', which were used: points lie {away_px:.0f} pixels elsewhere"
    return (Note(sentence, flag="implausible"),)


def _load(path: Path) -> tuple[Any, tuple[str, ...]]:
    """What the file holds, and a sentence where its line ends were changed."""
    try:
        with path.open("rb") as file:
            content = file.read(BYTES_MAX + 1)
    except OSError as error:
        raise FileError(path, f"the calibration cannot be read ({error.strerror})") from error
    if len(content) > BYTES_MAX:
        raise FileError(path, f"is larger than {BYTES_MAX} bytes, too large for a calibration, and was not loaded")
    text, notes = _with_own_line_ends(content)
    try:
        return load_plain(text), notes
    except ForbiddenError as error:
        problem = f"holds something other than plain numbers ({error}) and was not loaded; nothing in it was run"
        raise FileError(path, problem) from error
    except UNPICKLING_ERRORS as error:
        changed = " or copy it as a binary file: its line ends may have been changed" if b"\r\n" in content else ""
        raise FileError(path, f"is no complete calibration pickle: download it again{changed}") from error


def _with_own_line_ends(content: bytes) -> tuple[bytes, tuple[str, ...]]:
    """A text pickle with the line ends that it was written with: within its texts line ends are never written plainly.

    A binary pickle begins with its protocol and stays as it is.
    """
    text = content.removeprefix(b"\xef\xbb\xbf")
    if text.startswith(b"\x80"):
        return content, ()
    if b"\r\n" in text:
        text = text.replace(b"\r\n", b"\n")
    elif b"\r" in text and b"\n" not in text:
        text = text.replace(b"\r", b"\n")
    if text == content:
        return content, ()
    return text, ("its line ends were changed by a text editor, git or an ASCII transfer, it was read all the same",)


def _numbers(value: object) -> NDArray[np.float64]:
    """A float array from an array of the file or from nested lists of numbers."""
    values = value.values if isinstance(value, PlainArray) else value
    if isinstance(values, np.ndarray):
        if values.size > NUMBERS_MAX:
            raise TypeError(f"an array of at most {NUMBERS_MAX} numbers was expected, not of {values.size}")
    elif _count(values, DEPTH_MAX) > NUMBERS_MAX:
        raise TypeError(f"at most {NUMBERS_MAX} numbers were expected")
    return np.array(values, dtype=np.float64)


def _count(values: object, depth: int) -> int:
    """Numbers in nested lists, without walking through more of them than there may be."""
    if isinstance(values, int | float):
        return 1
    if not isinstance(values, list | tuple):
        raise TypeError(f"an array was expected, not {type(values).__name__}")
    if not depth or len(values) > NUMBERS_MAX:
        raise TypeError(f"lists of at most {NUMBERS_MAX} numbers, {DEPTH_MAX} deep, were expected")
    return sum(_count(item, depth - 1) for item in values)
