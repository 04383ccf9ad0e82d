"""Files that appear whole or not at all."""

import contextlib
import os
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
