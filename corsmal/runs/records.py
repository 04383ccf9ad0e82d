"""Records as JSON and back."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from types import UnionType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

Record = TypeVar("Record")


def record_json(record: Any) -> dict[str, Any]:
    """A dataclass as what JSON can hold: paths become texts, sets lists."""

    def plain(fields: list[tuple[str, Any]]) -> dict[str, Any]:
        return {name: _plain(value) for name, value in fields}

    return dataclasses.asdict(record, dict_factory=plain)


def record_of(kind: type[Record], content: Mapping[str, Any]) -> Record:
    """A dataclass from its JSON.

    Raises:
        CorsmalError, LookupError, TypeError, ValueError, AttributeError: it is the JSON of something else, such as one
            that another version wrote.
    """
    made: Record = _typed(kind, content)
    return made


def _plain(value: Any) -> Any:
    if isinstance(value, frozenset):
        return sorted(value)
    return str(value) if isinstance(value, Path) else value


def _typed(kind: Any, value: Any) -> Any:
    """A value of JSON as a field's type has it."""
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        types = get_type_hints(kind)
        return kind(**{name: _typed(types[name], item) for name, item in value.items()})
    if get_origin(kind) is UnionType:
        return None if value is None else _typed(get_args(kind)[0], value)
    if get_origin(kind) in (tuple, frozenset):
        return get_origin(kind)(_typed(get_args(kind)[0], item) for item in value)
    return Path(value) if kind is Path else value
