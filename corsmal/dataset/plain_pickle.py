"""Pickles from the internet, read without running anything that is in them, and at a bounded cost."""

import io
import math
import pickle
import re
import struct
from collections import OrderedDict
from collections.abc import Callable
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

OPCODES_MAX = 5_000
"""A calibration has about 350; one of nested lists of numbers about 100."""

BYTES_CREATED_MAX = 4_000_000
"""Of arrays and texts that are made from what is in the file, over the whole file."""

DIMENSIONS_MAX = 4
NUMBER_BITS_MAX = 64

_KEY_TYPES = (str, bytes, int, float, bool, type(None))
_NUMBER_TYPE = re.compile(r"[<>|=]?(b1|[iu][1248]|f[248])")

UNPICKLING_ERRORS = (
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
"""What reading a broken pickle raises."""


class ForbiddenError(pickle.UnpicklingError):
    """The file names something that is not on the list of what may be in it, or would cost too much."""


def load_plain(content: bytes) -> Any:
    """What a pickle of plain containers, strings, numbers and number arrays holds; an array is a ``PlainArray``.

    Raises:
        ForbiddenError: it holds something else, or more than a small file needs; nothing in it was run.
        UNPICKLING_ERRORS: it is broken.
    """
    return _PlainUnpickler(io.BytesIO(content), encoding="latin1").load()


class _NumberType:
    """Stands for a NumPy dtype: numbers only, so no objects, no fields, no shapes within."""

    def __init__(self, code: str, *_flags: object) -> None:
        if not isinstance(code, str) or not _NUMBER_TYPE.fullmatch(code):
            raise ForbiddenError(
                f"an array of {code[:40]!r}" if isinstance(code, str) else "an array of no number type"
            )
        self._dtype = np.dtype(code)

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        byte_order, subarray, names, fields = state[1:5]
        if byte_order not in ("<", ">", "=", "|") or any(part is not None for part in (subarray, names, fields)):
            raise ForbiddenError("an array of a compound type")
        self._dtype = self._dtype.newbyteorder(byte_order)

    def read(self, content: object, shape: object, order: str) -> NDArray[Any]:
        """The array whose bytes ``content`` is (Python 2 wrote them as text)."""
        if not isinstance(shape, tuple) or len(shape) > DIMENSIONS_MAX or not all(type(side) is int for side in shape):
            raise ForbiddenError("an array of an impossible shape")
        if not isinstance(content, str | bytes | bytearray):
            raise ForbiddenError("an array of objects")
        if math.prod(shape) * self._dtype.itemsize != len(content):
            raise ValueError(f"{len(content)} bytes do not fill an array of shape {shape}")
        data = content.encode("latin1") if isinstance(content, str) else content
        return np.frombuffer(data, dtype=self._dtype).reshape(shape, order="F" if order == "F" else "C")


class PlainArray:
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
        raise ForbiddenError("a change to a function")


def _as_number_type(value: object) -> _NumberType:
    if not isinstance(value, _NumberType):
        raise ForbiddenError("an array without a number type")
    return value


def _empty_array(*_arguments: object) -> PlainArray:
    return PlainArray()


def _array_from_buffer(content: object, number_type: object, shape: tuple[int, ...], order: str) -> PlainArray:
    array = PlainArray()
    array.values = _as_number_type(number_type).read(content, shape, order)
    return array


def _scalar(number_type: object, content: object) -> object:
    return _as_number_type(number_type).read(content, (), "C").item()


def _encoded(text: str, encoding: str = "latin1") -> bytes:
    if encoding not in ("latin1", "latin-1"):
        raise ForbiddenError("text in an encoding other than latin1")
    return text.encode("latin1")


def _plain_keys(keys: Any) -> None:
    if not all(isinstance(key, _KEY_TYPES) for key in keys):
        raise ForbiddenError("a dictionary with keys that are no numbers and no texts")


def _dictionary(*pairs: Any) -> "OrderedDict[Any, Any]":
    """Python 2 wrote ordered dictionaries with a list of their pairs."""
    if not all(isinstance(items, list) and all(len(item) == 2 for item in items) for items in pairs):
        raise ForbiddenError("a dictionary that is made from no list of pairs")
    for items in pairs:
        _plain_keys(item[0] for item in items)
    return OrderedDict(*pairs)


def _is_callable(function: list[Any]) -> bool:
    return len(function) == 1 and isinstance(function[0], _Allowed)


def _cost(value: object) -> int:
    return len(value) if isinstance(value, str | bytes | bytearray | list | tuple) else 0


def _allowed_names() -> dict[tuple[str, str], _Allowed]:
    functions: dict[tuple[str, str], Callable[..., object]] = {
        ("numpy", "ndarray"): _empty_array,
        ("numpy", "dtype"): _NumberType,
        ("_codecs", "encode"): _encoded,
        ("collections", "OrderedDict"): _dictionary,
    }
    for core in ("numpy.core", "numpy._core"):
        functions[f"{core}.multiarray", "_reconstruct"] = _empty_array
        functions[f"{core}.multiarray", "scalar"] = _scalar
        functions[f"{core}.numeric", "_frombuffer"] = _array_from_buffer
    return {name: _Allowed(function) for name, function in functions.items()}


_ALLOWED = _allowed_names()


class _PlainUnpickler(pickle._Unpickler):
    """An unpickler of plain containers, strings, numbers and number arrays, which does a bounded amount of work.

    The pure Python one is used because it notes repeated objects in a dict: a few bytes of a file cannot make it
    reserve gigabytes, as they can the compiled one. What a dictionary hashes is checked first: a tuple of tuples that
    share their parts has as many to be hashed as there are ways through it.
    """

    stack: list[Any]
    read: Callable[[int], bytes]
    append: Callable[[Any], None]

    def __init__(self, file: io.BytesIO, *, encoding: str) -> None:
        super().__init__(file, encoding=encoding)
        self._opcodes = self._created = 0

    def find_class(self, module: str, name: str) -> _Allowed:
        """What the file's ``module.name`` stands for; a name that is not on the list is an error."""
        try:
            return _ALLOWED[module, name]
        except KeyError:
            raise ForbiddenError(ascii(f"{module}.{name}"[:80])[1:-1]) from None

    def count(self, code: int) -> None:
        """Count one opcode, and what it will copy of what is in the file."""
        self._opcodes += 1
        if self._opcodes > OPCODES_MAX:
            raise ForbiddenError(f"more than {OPCODES_MAX} instructions")
        if code in _CALLS and self.stack:
            arguments = self.stack[-1]
            # a call of something else fails with a text that spells it out, however large it is
            if code == pickle.REDUCE[0] and not (isinstance(arguments, tuple) and _is_callable(self.stack[-2:-1])):
                raise ForbiddenError("a call of something that is no function")
            parts = arguments if isinstance(arguments, tuple | list) else ()
            self._created += sum(map(_cost, parts)) + len(parts)
            if self._created > BYTES_CREATED_MAX:
                raise ForbiddenError(f"arrays and texts of more than {BYTES_CREATED_MAX} bytes")
        elif code == pickle.SETITEM[0]:
            _plain_keys(self.stack[-2:-1])
        elif code in (pickle.SETITEMS[0], pickle.DICT[0]):
            _plain_keys(self.stack[::2])

    def check_number(self) -> None:
        """Refuse a whole number that no calibration has."""
        if isinstance(self.stack[-1], int) and self.stack[-1].bit_length() > NUMBER_BITS_MAX:
            raise ForbiddenError(f"a whole number of more than {NUMBER_BITS_MAX} bits")

    def read_bytearray(self) -> None:
        """As the original, but nothing is reserved before it is there."""
        (length,) = struct.unpack("<Q", self.read(8))
        data = self.read(min(length, BYTES_CREATED_MAX))
        if len(data) != length:
            raise EOFError
        self.append(bytearray(data))


_CALLS = frozenset(code[0] for code in (pickle.REDUCE, pickle.BUILD))
_NUMBERS = frozenset(code[0] for code in (pickle.INT, pickle.LONG, pickle.LONG1, pickle.LONG4))
_FORBIDDEN = {
    code[0]: what
    for what, codes in {
        "a set": (pickle.EMPTY_SET, pickle.ADDITEMS, pickle.FROZENSET),
        "an object of a class": (pickle.OBJ, pickle.INST, pickle.NEWOBJ, pickle.NEWOBJ_EX),
        "a reference to something outside": (pickle.PERSID, pickle.BINPERSID, pickle.EXT1, pickle.EXT2, pickle.EXT4),
    }.items()
    for code in codes
}


def _bounded(code: int, handler: Callable[[Any], None]) -> Callable[[Any], None]:
    def run(unpickler: _PlainUnpickler) -> None:
        if code in _FORBIDDEN:
            raise ForbiddenError(_FORBIDDEN[code])
        unpickler.count(code)
        handler(unpickler)
        if code in _NUMBERS:
            unpickler.check_number()

    return run


_HANDLERS: dict[int, Any] = {**pickle._Unpickler.dispatch, pickle.BYTEARRAY8[0]: _PlainUnpickler.read_bytearray}
_PlainUnpickler.dispatch = {code: _bounded(code, handler) for code, handler in _HANDLERS.items()}
