"""A file to which lines are appended, each with a checksum; several processes may append to one."""

import fcntl
import hashlib
import json
import os
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Generic, TypeVar

from corsmal.errors import CorsmalError, FileError
from corsmal.files import check_plain_file

Line = Mapping[str, Any]
Item = TypeVar("Item")

BYTES_MAX = 500_000_000
CHECKSUM_BYTES = 16
LOGS_KEPT = 64


class Log(Generic[Item]):
    """The lines of one file, read further as it grows.

    Args:
        path: the file, made when a line is first appended.
        read: makes an item of a line; it raises a ``CorsmalError``, ``LookupError``, ``TypeError``, ``ValueError`` or
            ``AttributeError`` for one that is none.
    """

    def __init__(self, path: Path, read: Callable[[Line], Item]) -> None:
        self.path = path
        self.damaged = 0
        self._read = read
        self._items: list[Item] = []
        self._read_to, self._inode = 0, 0
        self._lock = threading.RLock()

    def items(self) -> tuple[Item, ...]:
        """The items of all lines that are whole, in order; ``damaged`` counts the others.

        Raises:
            FileError: the file cannot be read.
        """
        with self._lock:
            try:
                check_plain_file(self.path, bytes_max=BYTES_MAX)
                with self.path.open("rb") as file:
                    self._read_on(file.fileno())
            except FileNotFoundError:
                self._begin(0)
            except OSError as error:
                raise FileError(self.path, f"cannot be read ({error.strerror})") from error
            return tuple(self._items)

    def append(self, make: Callable[[tuple[Item, ...]], Line | None]) -> Item | None:
        """Append a line that is made in view of those that are there; no other process appends meanwhile.

        Args:
            make: gives what JSON can hold, or None: nothing is appended.

        Returns:
            The new item, once it is on the disk.

        Raises:
            FileError: the file cannot be written.
        """
        with self._lock:
            try:
                with self._locked() as descriptor:
                    self._read_on(descriptor)
                    line = make(tuple(self._items))
                    if line is None:
                        return None
                    size = os.fstat(descriptor).st_size
                    is_cut = size > 0 and os.pread(descriptor, 1, size - 1) != b"\n"  # by a power cut
                    _write_all(descriptor, b"\n" * is_cut + _packed(line))
                    self._read_on(descriptor)
                    return self._items[-1]
            except OSError as error:
                problem = f"cannot be written ({error.strerror}); free the disk or set CORSMAL_CACHE"
                raise FileError(self.path, problem) from error

    @contextmanager
    def _locked(self) -> Iterator[int]:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(self.path, os.O_RDWR | os.O_APPEND | os.O_CREAT, 0o666)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX)
            yield descriptor
        finally:
            os.close(descriptor)

    def _read_on(self, descriptor: int) -> None:
        status = os.fstat(descriptor)
        if status.st_ino != self._inode or status.st_size < self._read_to:
            self._begin(status.st_ino)
        new = os.pread(descriptor, status.st_size - self._read_to, self._read_to)
        whole = new[: new.rfind(b"\n") + 1]
        self._read_to += len(whole)
        for text in filter(None, whole.split(b"\n")):
            try:
                self._items.append(self._read(_unpacked(text)))
            except (CorsmalError, LookupError, TypeError, ValueError, AttributeError):
                self.damaged += 1

    def _begin(self, inode: int) -> None:
        self._items, self.damaged, self._read_to, self._inode = [], 0, 0, inode


_logs: dict[Path, Log[Any]] = {}
_opening = threading.Lock()


def open_log(path: Path, read: Callable[[Line], Item]) -> Log[Item]:
    """The log of a file, the same for all threads; arguments as of the class."""
    with _opening:
        path = path.absolute()
        log = _logs.pop(path, None) or Log(path, read)
        _logs[path] = log
        while len(_logs) > LOGS_KEPT:
            del _logs[next(iter(_logs))]
        return log


def _write_all(descriptor: int, content: bytes) -> None:
    """Write to the disk; on a full one the first call may write a part without an error, the next one raises."""
    while content:
        content = content[os.write(descriptor, content) :]
    os.fsync(descriptor)


def _packed(line: Mapping[str, Any]) -> bytes:
    content = json.dumps(dict(line), allow_nan=False).encode()
    return _checksum(content) + b" " + content + b"\n"


def _unpacked(text: bytes) -> Line:
    """What a line holds; a ``ValueError`` where it is damaged."""
    checksum, _, content = text.partition(b" ")
    if checksum != _checksum(content):
        raise ValueError("holds other bytes than were written")
    line: Line = json.loads(content)
    return line


def _checksum(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=CHECKSUM_BYTES).hexdigest().encode()
