"""Calibration files: pickles from the internet, read without running anything that is in them."""

import io
import math
import pickle
import re
import struct
from collections import OrderedDict
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from corsmal.errors import ArgumentError, FileError
from corsmal.geometry import Camera

CALIBRATED_SIZE = (1280, 720)
"""Width and height, in pixels, of the images that the intrinsics of the calibration files are for."""

BYTES_MAX = 1_000_000
"""The dataset's files have about 4 kB; a larger one is no calibration."""

_SENSOR = "rgb"
_NUMBER_TYPE = re.compile(r"[<>|=]?(b1|[iu][1248]|f[248])")
_UNPICKLING_ERRORS = (
    pickle.UnpicklingError,
    struct.error,
    ArithmeticError,
    AssertionError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    RecursionError,
    TypeError,
    ValueError,
)


def read_camera(path: str | Path) -> Camera:
    """Read the colour camera from a calibration file.

    The file is a list or tuple whose item 0 maps ``rgb`` to a (3, 3) intrinsic matrix and whose item 1 maps ``rgb`` to
    ``rvec``, a (3, 3) rotation *matrix*, and ``tvec``, (3,) or (3, 1) metres. The redundant ``projMatrix`` is not used.

    Args:
        path: a pickle, as Python 2 or 3 and NumPy 1 or 2 write it.

    Returns:
        The camera for images of 1280×720 pixels.

    Raises:
        FileError: the file is absent, is no pickle, holds anything other than containers, strings, numbers and number
            arrays, gives no extrinsics, or its numbers are no camera.
    """
    path = Path(path)
    content = _load(path)
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
        return Camera(arrays[0], arrays[1], arrays[2].reshape(-1), CALIBRATED_SIZE)
    except (ArgumentError, TypeError, ValueError) as error:
        raise FileError(
            path, f"is no usable calibration: {error} ('rvec' is the rotation, 'tvec' the translation)"
        ) from error


def _load(path: Path) -> Any:
    try:
        with path.open("rb") as file:
            content = file.read(BYTES_MAX + 1)
    except OSError as error:
        raise FileError(path, f"the calibration cannot be read ({error.strerror})") from error
    if len(content) > BYTES_MAX:
        raise FileError(path, f"is larger than {BYTES_MAX} bytes, too large for a calibration, and was not loaded")
    try:
        return _PlainUnpickler(io.BytesIO(content), encoding="latin1").load()
    except _ForbiddenError as error:
        problem = f"holds something other than plain numbers ({error}) and was not loaded; nothing in it was run"
        raise FileError(path, problem) from error
    except _UNPICKLING_ERRORS as error:
        raise FileError(path, "is no complete calibration pickle: download it again") from error


def _numbers(value: object) -> NDArray[np.float64]:
    """A float array from an array of the file or from nested lists of numbers."""
    values = value.values if isinstance(value, _Array) else value
    if values is None or isinstance(values, dict | set | str):
        raise TypeError(f"an array was expected, not {type(values).__name__}")
    return np.array(values, dtype=np.float64)


class _ForbiddenError(pickle.UnpicklingError):
    """The file names something that is not on the list of what may be in it."""


class _NumberType:
    """Stands for a NumPy dtype: numbers only, so no objects, no fields, no shapes within."""

    def __init__(self, code: str, *_flags: object) -> None:
        if not isinstance(code, str) or not _NUMBER_TYPE.fullmatch(code):
            raise _ForbiddenError(f"an array of {str(code)[:40]!r}")
        self._dtype = np.dtype(code)

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        byte_order, subarray, names, fields = state[1:5]
        if byte_order not in ("<", ">", "=", "|") or any(part is not None for part in (subarray, names, fields)):
            raise _ForbiddenError("an array of a compound type")
        self._dtype = self._dtype.newbyteorder(byte_order)

    def read(self, content: object, shape: tuple[int, ...], order: str) -> NDArray[Any]:
        """The array whose bytes ``content`` is (Python 2 wrote them as text)."""
        data = content.encode("latin1") if isinstance(content, str) else content
        if not isinstance(data, bytes | bytearray):
            raise _ForbiddenError("an array of objects")
        if not isinstance(shape, tuple) or math.prod(shape) * self._dtype.itemsize != len(data):
            raise ValueError(f"{len(data)} bytes do not fill an array of shape {shape}")
        return np.frombuffer(data, dtype=self._dtype).reshape(shape, order="F" if order == "F" else "C")


class _Array:
    """Stands for a NumPy array while the file is read; NumPy's own constructors never see the file's content."""

    def __init__(self) -> None:
        self.values: NDArray[Any] | None = None

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        shape, number_type, is_fortran, content = state[-4:]
        self.values = _as_number_type(number_type).read(content, shape, "F" if is_fortran else "C")


class _Allowed:
    """What a permitted name of the file stands for: it can be called, and nothing in the file can change it."""

    __slots__ = ("_function",)

    def __init__(self, function: Callable[..., object]) -> None:
        self._function = function

    def __call__(self, *arguments: object) -> object:
        return self._function(*arguments)

    def __setstate__(self, state: object) -> NoReturn:
        raise _ForbiddenError("a change to a function")


def _as_number_type(value: object) -> _NumberType:
    if not isinstance(value, _NumberType):
        raise _ForbiddenError("an array without a number type")
    return value


def _empty_array(*_arguments: object) -> _Array:
    return _Array()


def _array_from_buffer(content: object, number_type: object, shape: tuple[int, ...], order: str) -> _Array:
    array = _Array()
    array.values = _as_number_type(number_type).read(content, shape, order)
    return array


def _scalar(number_type: object, content: object) -> object:
    return _as_number_type(number_type).read(content, (), "C").item()


def _encoded(text: str, encoding: str = "latin1") -> bytes:
    if encoding not in ("latin1", "latin-1"):
        raise _ForbiddenError(f"the encoding {str(encoding)[:40]!r}")
    return text.encode("latin1")


def _allowed_names() -> dict[tuple[str, str], _Allowed]:
    functions: dict[tuple[str, str], Callable[..., object]] = {
        ("numpy", "ndarray"): _empty_array,
        ("numpy", "dtype"): _NumberType,
        ("_codecs", "encode"): _encoded,
        ("collections", "OrderedDict"): OrderedDict,
    }
    for core in ("numpy.core", "numpy._core"):
        functions[f"{core}.multiarray", "_reconstruct"] = _empty_array
        functions[f"{core}.multiarray", "scalar"] = _scalar
        functions[f"{core}.numeric", "_frombuffer"] = _array_from_buffer
    for module in ("builtins", "__builtin__"):
        for container in (dict, list, tuple, set, frozenset):
            functions[module, container.__name__] = container
    return {name: _Allowed(function) for name, function in functions.items()}


_ALLOWED = _allowed_names()


class _PlainUnpickler(pickle._Unpickler):
    """An unpickler of plain containers, strings, numbers and number arrays.

    The pure Python one is used because it notes repeated objects in a dict: a few bytes of a file cannot make it
    reserve gigabytes, as they can the compiled one.
    """

    def find_class(self, module: str, name: str) -> _Allowed:
        """What the file's ``module.name`` stands for; a name that is not on the list is an error."""
        try:
            return _ALLOWED[module, name]
        except KeyError:
            raise _ForbiddenError(f"{module}.{name}"[:80]) from None
