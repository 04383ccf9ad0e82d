"""The exceptions that the library raises on purpose."""

from collections.abc import Iterable
from pathlib import Path


class CorsmalError(Exception):
    """Root of every error that the library raises on purpose; its text is one sentence for the user."""


class ArgumentError(CorsmalError, ValueError):
    """An argument has the wrong shape, type or range; the text names it, what was expected and what came."""


def check_choice(name: str, value: object, choices: Iterable[str]) -> None:
    """Raise an ``ArgumentError`` that names an argument whose value is none of the choices."""
    if value not in (known := tuple(choices)):
        raise ArgumentError(f"{name} must be one of {', '.join(known)}, got {value!r}")


class FileError(CorsmalError):
    """A file is absent, broken or not what it should be; the text names it and says what to do."""

    def __init__(self, path: str | Path, problem: str) -> None:
        super().__init__(f"{path}: {problem}")
        self.path = Path(path)
        self.problem = problem

    def __reduce__(self) -> tuple[type["FileError"], tuple[Path, str]]:
        return type(self), (self.path, self.problem)


class NotFoundError(CorsmalError, LookupError):
    """A requested recording, view or result does not exist; the text says what exists instead."""
