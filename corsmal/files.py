"""Files that appear whole or not at all, and those that can be read to an end."""

import contextlib
import os
import stat
import uuid
from collections.abc import Iterator
from pathlib import Path

from corsmal.errors import FileError


@contextlib.contextmanager
def writing(path: Path, *, advice: str, errors: tuple[type[Exception], ...] = ()) -> Iterator[Path]:
    """Write a file under another name and rename it: a killed program leaves no half file.

    Args:
        path: where it is to be; an older one is replaced.
        advice: what the user can do when it cannot be written.
        errors: what else the block may raise for a file that cannot be written; ``OSError`` is always among them.

    Yields:
        Another path in the same folder, with the same suffix. It is renamed to ``path`` when the block ends, and
        deleted when the block raises.

    Raises:
        FileError: the folder or the file cannot be written.
    """
    failures: tuple[type[Exception], ...] = (OSError, *errors)
    part = path.with_name(f".{path.stem}.{uuid.uuid4().hex}{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield part
        os.replace(part, path)
    except failures as error:
        reason = getattr(error, "strerror", None) or error
        raise FileError(path, f"cannot be written ({reason}); {advice}") from error
    finally:
        with contextlib.suppress(OSError):
            part.unlink()


BYTES_MAX = 2_000_000_000
"""Of a file that is read whole; networks have some hundred megabytes."""


def check_plain_file(path: Path, *, bytes_max: int = BYTES_MAX) -> None:
    """Refuse what is no file, such as a pipe, whose reader waits for a writer, and what would fill the memory.

    Raises:
        FileNotFoundError: there is nothing.
        FileError: it is no file, a link to nowhere, or larger than ``bytes_max``.
        OSError: it may not be read.
    """
    try:
        status = path.stat()
    except FileNotFoundError:
        if path.is_symlink():
            raise FileError(path, "is a link to nowhere") from None
        raise
    if not stat.S_ISREG(status.st_mode):
        raise FileError(path, "is no file")
    if status.st_size > bytes_max:
        raise FileError(path, f"is larger than {bytes_max // 1_000_000} MB")
    path.open("rb").close()  # raises where it may not be read
