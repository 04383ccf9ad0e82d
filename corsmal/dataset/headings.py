"""Headings of tables as other programs write them: in another case, with underscores, with a unit in brackets."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from corsmal.errors import ArgumentError

_UNIT = re.compile(r"(.*?)\s*[(\[]\s*(\S{1,6})\s*[)\]]")
_UNITS = {"ml", "mm", "g", "g/ml", "ms", "s", "l", "cl", "dl", "cm", "m", "kg", "mg", "in", "oz"}
IDS = ("recording_id", "id", "configuration_id", "recording", "config_id")
"""What a column of recording ids is called in one table or another."""


def heading_key(text: object) -> str:
    """A heading without what programs change about it: case, spaces, underscores, hyphens, points."""
    return re.sub(r"[\W_]+", "", str(text).casefold())


@dataclass(frozen=True)
class Columns:
    """The columns that a kind of table may have.

    Args:
        ids: name of the column with the recordings' ids.
        spellings: name of each other column to its other names; case, spaces, underscores and hyphens do not matter.
        units: name of a column to its unit, where it has one.
        texts: those that hold text, in which no number is looked for.
    """

    ids: str
    spellings: Mapping[str, tuple[str, ...]]
    units: Mapping[str, str] = field(default_factory=dict)
    texts: frozenset[str] = frozenset()

    def spelled(self, name: str) -> tuple[str, ...]:
        """How a column is called where nobody changed anything."""
        return (self.ids, *IDS) if name == self.ids else (name, *self.spellings[name])

    def names(self, headings: Sequence[object]) -> list[str | None]:
        """The columns' names for a table's headings; None for what is no column of this kind of table.

        Raises:
            ArgumentError: a heading names another unit than the column's.
        """
        known = {heading_key(spelling): name for name in (self.ids, *self.spellings) for spelling in self.spelled(name)}
        return [self._name(heading, known) for heading in headings]

    def _name(self, heading: object, known: Mapping[str, str]) -> str | None:
        if (key := heading_key(heading)) in known:
            return known[key]
        parts = _UNIT.fullmatch(str(heading).strip())
        if parts is None or (name := known.get(heading_key(parts[1]))) is None:
            return None
        unit, expected = parts[2].lower(), self.units.get(name, "")
        if unit in _UNITS and expected and unit != expected.lower():
            raise ArgumentError(f"the column {str(heading)!r} is in {parts[2]}, and {expected} is expected")
        return name


def repeated(names: Iterable[str | None]) -> list[str]:
    """Names that stand more than once."""
    seen: set[str] = set()
    twice = []
    for name in names:
        if name is not None and name in seen and name not in twice:
            twice.append(name)
        seen |= {name} if name is not None else set()
    return twice
