"""Digests of what a result was computed from."""

import dataclasses
import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from corsmal.errors import ArgumentError, FileError
from corsmal.fields import UNLESS_DEFAULT

Chunk = bytes | memoryview
"""A part of what is digested."""

FORMAT_VERSION = 1
"""Part of every digest; raised when stored files change their form."""


def digest(*parts: Any) -> str:
    """A stable digest of values, the same in every process and on every machine.

    Args:
        parts: None, bools, numbers (exact, type included), strings, bytes, paths (by ``file_fingerprint``), NumPy
            arrays, and dataclasses, tuples, lists, sets and mappings of these; see ``fields.UNLESS_DEFAULT``.

    Returns:
        32 hexadecimal digits.

    Raises:
        ArgumentError: a value of another type.
        FileError: a path names no file.
    """
    found = hashlib.blake2b(digest_size=16)
    for chunk in _encode((FORMAT_VERSION, *parts)):
        found.update(chunk)
    return found.hexdigest()


def file_fingerprint(path: str | Path) -> str:
    """A file's size, its time of change (ns), the last three parts of its path, and whether it may not be read.

    The folders are part of it because the views of one recording share a name, and after a download often the time.
    A dataset that is moved as a whole keeps its fingerprints.

    Raises:
        FileError: there is no such file.
    """
    path = Path(path)
    try:
        status = path.stat()
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror})") from error
    if not path.is_file():
        raise FileError(path, "is no file")
    may_read = os.access(path, os.R_OK, effective_ids=os.access in os.supports_effective_ids)
    ending = "" if may_read else ", not readable"  # what is kept of such a file is not that of the file
    return f"{status.st_size} bytes, {status.st_mtime_ns} ns, {'/'.join(path.absolute().parts[-3:])}{ending}"


def _encode(value: Any) -> list[Chunk]:
    """Type, length and content, so that no two values have the same bytes; arrays are not copied."""
    kind, content = _content(value)
    return [f"{kind}:{sum(map(len, content))}:".encode(), *content]


def _content(value: Any) -> tuple[str, Sequence[Chunk]]:
    if isinstance(value, np.generic):
        value = value.item()
    for kind, scalar, to_bytes in SCALARS:
        if isinstance(value, scalar):
            return kind, [to_bytes(value)]
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        content = np.ascontiguousarray(value).reshape(-1).view(np.uint8).data
        return "array", [*_encode((value.dtype.str, value.shape)), content]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {
            field.name: getattr(value, field.name)
            for field in dataclasses.fields(value)
            if not (UNLESS_DEFAULT.items() <= field.metadata.items() and getattr(value, field.name) == field.default)
        }
        return "record", _encode((type(value).__qualname__, fields))
    return _collection(value)


SCALARS: tuple[tuple[str, type, Callable[[Any], bytes]], ...] = (
    ("none", type(None), lambda _: b""),
    ("bool", bool, lambda value: b"1" if value else b"0"),
    ("int", int, lambda value: b"%d" % value),
    ("float", float, lambda value: float(value).hex().encode()),
    ("str", str, lambda value: value.encode("utf-8", "surrogatepass")),
    ("bytes", bytes, bytes),
    ("file", Path, lambda value: file_fingerprint(value).encode("utf-8", "surrogatepass")),
)
"""Name, type and content of what is no collection; bool stands before int, which it is a kind of."""


def _collection(value: Any) -> tuple[str, Sequence[Chunk]]:
    if isinstance(value, tuple | list):
        return "sequence", [chunk for item in value for chunk in _encode(item)]
    if isinstance(value, set | frozenset):
        return "set", sorted(b"".join(_encode(item)) for item in value)
    if isinstance(value, Mapping):
        return "mapping", sorted(b"".join(_encode(key) + _encode(item)) for key, item in value.items())
    raise ArgumentError(f"parts must be numbers, text, paths, arrays or records of these, got {type(value).__name__}")
