"""Results on disk, addressed by what they were computed from.

A result's key is a digest of everything it depends on, so a result never has to be invalidated, only computed again
when an input changes. Files are written under another name and renamed, so a reader sees a whole file or none, and
two processes may write the same result. There is no wait for the disk, but each file holds a checksum: one that a power
cut left broken, or in which a bit has flipped, is found when it is read, set aside as ``*.broken`` and computed again.
So is what is no file (a pipe, a socket, a folder, a link to nowhere), may not be read, or is far too large.
The store never stops a computation: what cannot be written is simply not kept.
"""

import hashlib
import io
import json
import os
import re
import struct
import threading
import time
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from corsmal.digests import digest, file_fingerprint
from corsmal.errors import ArgumentError, CorsmalError, FileError
from corsmal.files import check_plain_file, writing
from corsmal.installation import default_cache
from corsmal.notes import repeat

Result = TypeVar("Result")

PROBLEMS_MAX = 20
KEY = r"[0-9a-f]{32}"
CHECKSUM_BYTES = 32
BEGUN_MAX_S = 3600.0
BYTES_MAX = 256_000_000  # of a file that is read; a result has some megabytes at most
BROKEN = (
    CorsmalError, OSError, ValueError, TypeError, LookupError, AttributeError, EOFError, ArithmeticError, MemoryError,
    RuntimeError, SyntaxError, tokenize.TokenError, struct.error, zlib.error, zipfile.BadZipFile,
)  # fmt: skip
"""What readers raise on a file whose bytes were changed."""


class Store:
    """A folder of results; threads and processes may share it.

    Args:
        root: the folder, made when something is first written. Default: what ``CORSMAL_CACHE`` names, else ``cache``
            of the checkout, else ``corsmal`` in the user's cache folder.

    Example:
        >>> store = Store()
        >>> key = digest("hull", Path("view1.mp4"), ShapeParameters.paper())  # doctest: +SKIP
        >>> store.save_arrays("hulls", key, radii_mm=radii_mm)  # doctest: +SKIP
        True
    """

    digest = staticmethod(digest)
    file_fingerprint = staticmethod(file_fingerprint)

    def __init__(self, root: Path | None = None) -> None:
        self.root = Path(root or os.environ.get("CORSMAL_CACHE") or default_cache())
        self._problems: dict[str, None] = {}
        self._lock = threading.Lock()

    def __reduce__(self) -> tuple[type["Store"], tuple[Path]]:
        return type(self), (self.root,)

    @property
    def problems(self) -> tuple[str, ...]:
        """Sentences about what could not be written or read, each once, the last one last; the newest 20."""
        with self._lock:
            return tuple(self._problems)

    def file(self, kind: str, key: str, suffix: str) -> Path:
        """Where a result is, or is to be.

        Args:
            kind: the sort of result, such as ``detections``: lower-case letters, digits, ``-`` and ``_``.
            key: from ``digest``.
            suffix: such as ``.npz``.

        Raises:
            ArgumentError: one of them cannot be part of a file name, or the key is no digest.
        """
        if not re.fullmatch(r"[a-z0-9_-]+", kind):
            raise ArgumentError(f"kind must be of lower-case letters, digits, - and _, got {kind!r}")
        if not re.fullmatch(KEY, key):
            raise ArgumentError(f"key must come from corsmal.store.digest, got {key!r}")
        if not re.fullmatch(r"\.[a-z0-9]+", suffix):
            raise ArgumentError(f"suffix must be a dot and letters or digits, got {suffix!r}")
        return self.root / kind / key[:2] / f"{key}{suffix}"

    @staticmethod
    def writing(path: Path, *, errors: tuple[type[Exception], ...] = ()) -> AbstractContextManager[Path]:
        """Write a file so that it appears whole or not at all.

        Args:
            path: where it is to be, from ``file``; an older one is replaced.
            errors: see ``corsmal.files.writing``, as for what is raised.
        """
        return writing(path, advice="free the disk or set CORSMAL_CACHE", errors=errors)

    def check_writable(self) -> None:
        """Make sure that results can be kept.

        Raises:
            FileError: they cannot.
        """
        with self.writing(self.root / "writable") as part:
            part.write_bytes(bytes(4096))  # a full disk still takes an empty file

    def leftovers(self) -> list[Path]:
        """Files that are not read: those that were set aside, and what killed programs had begun an hour ago."""
        begun = [path for path in self.root.glob("*/*/.*") if path.is_file()]
        old = [path for path in begun if time.time() - path.stat().st_mtime > BEGUN_MAX_S]
        return sorted([*self.root.glob("*/*/*.broken"), *old])

    def read(self, path: Path, reader: Callable[[Path], Result]) -> Result | None:
        """What a reader makes of a result's file, or None where there is none.

        A file that it cannot read is set aside, with a sentence in ``problems``; what is no file is not opened.

        Args:
            path: from ``file``.
            reader: raises a ``CorsmalError``, or what Python's and NumPy's own readers raise, on a broken file.
        """
        try:
            check_plain_file(path, bytes_max=BYTES_MAX)
            return reader(path)
        except (FileNotFoundError, NotADirectoryError):
            return None
        except BROKEN as error:
            self._set_aside(path, error)
            return None

    def has_remains(self, path: Path) -> bool:
        """Whether something is, or was, in the place of a result that ``read`` did not find."""
        return any(map(os.path.lexists, (path, _broken(path))))

    def write(self, path: Path, writer: Callable[[Path], object]) -> bool:
        """Keep a result; false, and a sentence in ``problems``, where it cannot be written.

        Args:
            path: from ``file``.
            writer: writes the file that it is given, which is then renamed; it raises an ``OSError`` where it cannot.
        """
        try:
            with self.writing(path) as part:
                writer(part)
        except FileError as error:
            self._note(str(error))
            return False
        return True

    def arrays(self, kind: str, key: str) -> dict[str, NDArray[Any]] | None:
        """Named arrays, or None where they are not stored."""
        return self.read(self.file(kind, key, ".npz"), _read_arrays)

    def save_arrays(self, kind: str, key: str, /, **arrays: ArrayLike) -> bool:
        """Keep named arrays; false, and a sentence in ``problems``, where they cannot be written.

        Raises:
            ArgumentError: an array holds Python objects.
        """
        checked = {name: np.asarray(array) for name, array in arrays.items()}
        for name, array in checked.items():
            if array.dtype.hasobject:
                raise ArgumentError(f"{name} must be an array of numbers, bools or text, got {array.dtype}")
        return self.write(self.file(kind, key, ".npz"), lambda part: _write_arrays(part, checked))

    def json(self, kind: str, key: str) -> dict[str, Any] | None:
        """A JSON object, or None where it is not stored."""
        return self.read(self.file(kind, key, ".json"), _read_json)

    def save_json(self, kind: str, key: str, value: Mapping[str, Any]) -> bool:
        """Keep a JSON object; false, and a sentence in ``problems``, where it cannot be written.

        Raises:
            ArgumentError: the value holds what JSON has not, such as NaN or an array.
        """
        try:
            text = json.dumps(dict(value), allow_nan=False)
        except (TypeError, ValueError) as error:
            raise ArgumentError(f"value must be what JSON can hold: {error}") from error
        content = text.encode()
        return self.write(
            self.file(kind, key, ".json"), lambda part: part.write_bytes(content + b"\n" + _checksum(content))
        )

    def keys(self, kind: str) -> tuple[str, ...]:
        """The keys of one kind of JSON objects, in no particular order of time."""
        files = sorted((self.root / kind).glob("*/*.json"))
        return tuple(path.stem for path in files if re.fullmatch(KEY, path.stem))

    def _set_aside(self, path: Path, error: Exception) -> None:
        reason = getattr(error, "problem", None) or getattr(error, "strerror", None) or type(error).__name__
        done = "it was set aside, and what can be computed is computed again"
        try:
            os.replace(path, _broken(path))
        except FileNotFoundError:  # by another process meanwhile
            pass
        except OSError as failure:
            done = f"it cannot be set aside either ({failure.strerror}), delete it"
        self._note(f"{path}: cannot be read ({reason}); {done}")

    def _note(self, sentence: str) -> None:
        repeat([sentence])
        with self._lock:
            self._problems.pop(sentence, None)
            self._problems[sentence] = None
            while len(self._problems) > PROBLEMS_MAX:
                del self._problems[next(iter(self._problems))]


def _broken(path: Path) -> Path:
    """Where a file is set aside."""
    return path.with_name(f"{path.name}.broken")


def _checksum(content: bytes) -> bytes:
    """32 hexadecimal digits."""
    return hashlib.blake2b(content, digest_size=CHECKSUM_BYTES // 2).hexdigest().encode()


def _read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    content = path.read_bytes()
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        if not archive.comment or _checksum(content[:-CHECKSUM_BYTES]) != content[-CHECKSUM_BYTES:]:
            raise FileError(path, "holds other bytes than were written")
    with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
        return {name: arrays[name] for name in arrays.files}


def _write_arrays(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    buffer = io.BytesIO()
    # np.savez takes its own arguments' names from the arrays' names.
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array, allow_pickle=False)
        archive.comment = bytes(CHECKSUM_BYTES)
    content = buffer.getvalue()[:-CHECKSUM_BYTES]
    path.write_bytes(content + _checksum(content))


def _read_json(path: Path) -> dict[str, Any]:
    content, _, checksum = path.read_bytes().partition(b"\n")
    if checksum != _checksum(content):
        raise FileError(path, "holds other bytes than were written")
    value = json.loads(content)
    if not isinstance(value, dict):
        raise FileError(path, "is no JSON object")
    return value
