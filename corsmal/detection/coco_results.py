"""Entries on their way into the form of a COCO results file."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from corsmal.notes import Note

FLAG = "detections-interpreted"


@dataclass
class Results:
    """Entries as of a COCO results file, as far as they could be put into that form, and how they were read.

    Args:
        entries: the entries.
        notes: sentences on how they were read.
        is_relative: whether their outlines were written as shares of the image's size.
    """

    entries: list[Any]
    notes: list[str] = field(default_factory=list)
    is_relative: bool = False

    def note(self, sentence: str) -> None:
        """Say how the file was read."""
        self.notes.append(Note(sentence, flag=FLAG))

    def mappings(self) -> Iterator[tuple[int, dict[str, Any]]]:
        """The entries that are mappings, each with its place; an entry may be replaced meanwhile."""
        return ((place, entry) for place, entry in enumerate(self.entries) if isinstance(entry, dict))


def whole(value: object) -> int | None:
    """A whole number, however it is written (3, 3.0, "3", "3.0"); None for anything else."""
    if isinstance(value, str):
        text = value.strip()
        if not re.fullmatch(r"\d{1,9}(\.0{1,9})?", text, re.ASCII):
            return None
        return int(text.partition(".")[0])
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e9:
        return int(value)
    return value if type(value) is int else None
