"""Named collections of pins, kept in the store: a JSON file for each collection, and a file for what each pin shows.

The threads of one server change a collection one after the other; each change is made to what is on the disk then, so
that two people who share a collection lose nothing of each other's.
"""

import json
import threading
import uuid
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import plotly.graph_objects as go

from corsmal.digests import digest
from corsmal.errors import ArgumentError, CorsmalError, FileError
from corsmal.figures.data import unpacked
from corsmal.figures.pins import Medium, Pin
from corsmal.store import Store

KIND, CONTENTS = "pins", "pinned"
"""Kinds of the store: collections, and what their pins show."""

PINS_MAX, COLLECTIONS_MAX, REMOVED_MAX = 100, 500, 20
NAME_MAX, TITLE_MAX, NOTE_MAX = 60, 300, 2000
ENDINGS: dict[Medium, str] = {"image/jpeg": ".jpg", "image/png": ".png", "audio/wav": ".wav"}
FIGURE = "figure"

_changing = threading.Lock()


@dataclass(frozen=True)
class KeptPin:
    """A pin as a collection lists it, without what it shows.

    Args:
        id: of the pin; also names the file of what it shows.
        kind: a medium, or ``figure``.
        facts: the other fields of ``Pin``.
    """

    id: str
    kind: str
    facts: Mapping[str, Any]

    @property
    def title(self) -> str:
        """See ``Pin``."""
        return str(self.facts["title"])

    @property
    def note(self) -> str:
        """See ``Pin``."""
        return str(self.facts["note"])

    def load(self, *, store: Store) -> Pin | None:
        """The pin with what it shows; None where its file is gone or broken."""
        if self.kind == FIGURE:
            figure = store.json(CONTENTS, self.id)
            return None if figure is None else Pin(**self.facts, figure=go.Figure(unpacked(figure)))
        medium = next(each for each in ENDINGS if each == self.kind)
        content = store.read(store.file(CONTENTS, self.id, ENDINGS[medium]), lambda path: path.read_bytes())
        return Pin(**self.facts, content=content, medium=medium) if content else None


@dataclass(frozen=True)
class Collection:
    """Pins of one dataset under a name, in order.

    Args:
        name: of the collection, unique within the dataset.
        dataset: the dataset's fingerprint.
        is_named: whether a person named it; others are not listed.
        pins: in order.
        removed: the last ones that were removed, the latest last, each with its place.

    Raises:
        ArgumentError: the name is empty, too long or not printable.
    """

    name: str
    dataset: str
    is_named: bool = False
    pins: tuple[KeptPin, ...] = ()
    removed: tuple[tuple[int, KeptPin], ...] = ()

    def __post_init__(self) -> None:
        if not self.name.strip() or len(self.name) > NAME_MAX or not self.name.isprintable():
            raise ArgumentError(
                f"a collection's name must be 1 to {NAME_MAX} printable characters, got {self.name[:80]!r}"
            )

    def load(self, *, store: Store) -> list[Pin]:
        """The pins with what they show, without those whose file is gone or broken."""
        return [pin for kept in self.pins if (pin := kept.load(store=store)) is not None]

    def ordered(self, ids: Sequence[str]) -> "Collection":
        """With the pins in the order of these ids; what is not among them keeps its order, at the end."""
        place = {name: index for index, name in enumerate(ids)}
        return replace(self, pins=tuple(sorted(self.pins, key=lambda pin: place.get(pin.id, len(place)))))

    def noted(self, name: str, text: str) -> "Collection":
        """With a note on one pin."""
        return replace(
            self,
            pins=tuple(
                replace(pin, facts={**pin.facts, "note": text[:NOTE_MAX]}) if pin.id == name else pin
                for pin in self.pins
            ),
        )

    def without(self, name: str) -> "Collection":
        """Without one pin, which can be put back."""
        index = next((index for index, pin in enumerate(self.pins) if pin.id == name), None)
        if index is None:
            return self
        removed = (*self.removed, (index, self.pins[index]))
        return replace(self, pins=self.pins[:index] + self.pins[index + 1 :], removed=removed)

    def restored(self) -> "Collection":
        """With the pin that was removed last, at its place."""
        if not self.removed:
            return self
        *earlier, (index, pin) = self.removed
        return replace(self, pins=(*self.pins[:index], pin, *self.pins[index:]), removed=tuple(earlier))


def load_collection(name: str, *, dataset: str, store: Store) -> Collection:
    """The collection of a name on a dataset; an empty one where there is none.

    Raises:
        ArgumentError: there can be none of that name.
    """
    return _collection_of(store.json(KIND, _key(name, dataset))) or Collection(name, dataset)


def list_collections(*, dataset: str, store: Store) -> list[str]:
    """The names of the collections on a dataset that people named."""
    found = [_collection_of(store.json(KIND, key)) for key in store.keys(KIND)]
    return sorted(each.name for each in found if each is not None and each.dataset == dataset and each.is_named)


def change_collection(
    name: str, change: Callable[[Collection], Collection], *, dataset: str, store: Store
) -> Collection:
    """Change a collection as it is on the disk now, and keep it.

    Args:
        name: of the collection; one that is not there begins empty.
        change: gives the changed one.
        dataset: the dataset's fingerprint.
        store: keeps it.

    Raises:
        ArgumentError: there can be none of that name, or it is full.
        FileError: it cannot be written.
    """
    with _changing:
        before = load_collection(name, dataset=dataset, store=store)
        return _keep(change(before), store=store)


def add_pins(name: str, pins: Iterable[Pin], *, dataset: str, store: Store) -> Collection:
    """Append pins to a collection; it begins with them where it is not there.

    Raises:
        ArgumentError: the collection is full, or there are too many collections.
        FileError: it cannot be written.
    """
    with _changing:
        before, added = load_collection(name, dataset=dataset, store=store), list(pins)
        if len(before.pins) + len(added) > PINS_MAX:
            raise ArgumentError(f"the collection {name!r} holds {len(before.pins)} pins, and at most {PINS_MAX}")
        if not before.pins and len(store.keys(KIND)) >= COLLECTIONS_MAX:
            raise ArgumentError(f"this server keeps at most {COLLECTIONS_MAX} collections of pins; use one of them")
        kept = tuple(_write_content(pin, store=store) for pin in added)
        return _keep(replace(before, pins=before.pins + kept), store=store)


def name_collection(name: str, new_name: str, *, dataset: str, store: Store) -> Collection:
    """Give a collection a name by which people find it, and open it under that name only.

    Raises:
        ArgumentError: there is a collection of the new name, or there can be none.
        FileError: it cannot be written.
    """
    with _changing:
        if _collection_of(store.json(KIND, _key(new_name, dataset))) is not None:
            raise ArgumentError(f"there is a collection named {new_name!r} already; open it, or choose another name")
        named = replace(load_collection(name, dataset=dataset, store=store), name=new_name, is_named=True)
        _keep(named, store=store)
        if new_name != name:
            _delete(store, KIND, _key(name, dataset), ".json")
        return named


def _keep(collection: Collection, *, store: Store) -> Collection:
    """Write a collection; what was removed long ago is deleted for good."""
    for _, pin in collection.removed[:-REMOVED_MAX]:
        _delete(store, CONTENTS, pin.id, _ending(pin))
    collection = replace(collection, removed=collection.removed[-REMOVED_MAX:])
    if not store.save_json(KIND, _key(collection.name, collection.dataset), asdict(collection)):
        raise FileError(store.root, f"the pins could not be kept: {store.problems[-1]}")
    return collection


def _write_content(pin: Pin, *, store: Store) -> KeptPin:
    """Keep what a pin shows."""
    facts = {field.name: getattr(pin, field.name) for field in fields(Pin) if field.name not in _SHOWN}
    facts |= {"numbers": dict(pin.numbers), "parameters": dict(pin.parameters)}
    facts |= {"title": pin.title[:TITLE_MAX], "note": pin.note[:NOTE_MAX]}
    kept = KeptPin(uuid.uuid4().hex, pin.medium or FIGURE, facts)
    if pin.figure is not None:
        is_kept = store.save_json(CONTENTS, kept.id, json.loads(pin.figure.to_json()))
    else:
        is_kept = store.write(store.file(CONTENTS, kept.id, _ending(kept)), lambda part: part.write_bytes(pin.content))
    if not is_kept:
        raise FileError(store.root, f"the pin could not be kept: {store.problems[-1]}")
    return kept


_SHOWN = ("figure", "content", "medium")


def _ending(pin: KeptPin) -> str:
    return next((ending for medium, ending in ENDINGS.items() if medium == pin.kind), ".json")


def _delete(store: Store, kind: str, key: str, ending: str) -> None:
    store.file(kind, key, ending).unlink(missing_ok=True)


def _key(name: str, dataset: str) -> str:
    return digest("pins", dataset, name)


def _collection_of(content: Mapping[str, Any] | None) -> Collection | None:
    """A collection from its JSON; None for what is none."""
    try:
        if content is None:
            return None
        pins = tuple(KeptPin(**pin) for pin in content["pins"])
        removed = tuple((int(index), KeptPin(**pin)) for index, pin in content["removed"])
        return Collection(content["name"], content["dataset"], bool(content["is_named"]), pins, removed)
    except (CorsmalError, LookupError, TypeError, ValueError):
        return None
