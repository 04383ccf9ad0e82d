"""Collections of pins on the disk."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
import pytest

from corsmal.errors import ArgumentError, FileError
from corsmal.figures import pin_collections
from corsmal.figures.pin_collections import (
    Collection,
    add_pins,
    change_collection,
    list_collections,
    load_collection,
    name_collection,
)
from corsmal.figures.pins import Pin
from corsmal.store import Store

HOSTILE = "<script>alert(1)</script> =1+1 \\input{x} $a$ `b` \x00 \u202e"


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "cache")


def picture(title: str, **others: object) -> Pin:
    return Pin(title, content=b"\xff\xd8" + title.encode(), medium="image/jpeg", **others)  # type: ignore[arg-type]


def titles(collection: Collection) -> list[str]:
    return [pin.title for pin in collection.pins]


def test_pins_come_back_as_they_were_pinned(store: Store) -> None:
    figure = go.Figure(go.Scatter(x=np.arange(3.0), y=np.array([1, np.nan, 3]), name=HOSTILE))
    facts = {
        "numbers": {"Capacity": "563 mL", HOSTILE: HOSTILE},
        "parameters": {"preset": "paper"},
        "dataset": "train",
        "recording": "000618",
        "frame": 25,
        "run": "tuned",
        "link": "shape?recording=000618&frame=25",
        "note": HOSTILE,
    }
    made = [Pin(HOSTILE, figure, **facts), picture("two"), Pin("three", content=b"RIFF", medium="audio/wav")]
    add_pins("a", made, dataset="d", store=store)
    found = load_collection("a", dataset="d", store=store).load(store=store)
    assert [pin.title for pin in found] == [HOSTILE, "two", "three"]
    assert all(getattr(found[0], name) == value for name, value in facts.items())
    assert found[0].figure is not None
    np.testing.assert_array_equal(found[0].figure.data[0].y, [1, np.nan, 3])
    assert [(pin.medium, pin.content) for pin in found[1:]] == [
        ("image/jpeg", b"\xff\xd8two"),
        ("audio/wav", b"RIFF"),
    ]


def test_collections_of_other_names_and_datasets_do_not_mix(store: Store) -> None:
    for name, dataset in (("a", "d"), ("b", "d"), ("a", "e")):
        add_pins(name, [picture(f"{name} on {dataset}")], dataset=dataset, store=store)
    assert titles(load_collection("b", dataset="d", store=store)) == ["b on d"]
    assert titles(load_collection("a", dataset="e", store=store)) == ["a on e"]
    assert load_collection("b", dataset="e", store=store).pins == ()


def test_order_note_removal_and_its_undoing(store: Store) -> None:
    first, second, third = add_pins("a", map(picture, "xyz"), dataset="d", store=store).pins

    def changed(change: object) -> Collection:
        change_collection("a", change, dataset="d", store=store)  # type: ignore[arg-type]
        return load_collection("a", dataset="d", store=store)

    assert titles(changed(lambda found: found.ordered([third.id, "gone", first.id]))) == ["z", "x", "y"]
    assert changed(lambda found: found.noted(first.id, "n" * 5000)).pins[1].note == "n" * 2000
    assert titles(changed(lambda found: found.without(first.id).without("gone"))) == ["z", "y"]
    assert titles(changed(lambda found: found.without(second.id))) == ["z"]
    assert titles(changed(lambda found: found.restored())) == ["z", "y"]
    assert titles(changed(lambda found: found.restored().restored())) == ["z", "x", "y"]


def test_what_was_removed_long_ago_is_deleted_for_good(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pin_collections, "REMOVED_MAX", 1)
    pins = add_pins("a", map(picture, "xy"), dataset="d", store=store).pins
    for pin in pins:
        change_collection("a", lambda found, name=pin.id: found.without(name), dataset="d", store=store)  # type: ignore[misc]
    files = [path.stem for path in (store.root / "pinned").rglob("*.jpg")]
    assert files == [pins[1].id]
    assert titles(load_collection("a", dataset="d", store=store).restored()) == ["y"]


def test_named_collections_are_listed_and_no_name_is_given_twice(store: Store) -> None:
    add_pins("pins-1", [picture("x")], dataset="d", store=store)
    add_pins("pins-2", [picture("y")], dataset="d", store=store)
    assert list_collections(dataset="d", store=store) == []
    assert titles(name_collection("pins-1", "meeting", dataset="d", store=store)) == ["x"]
    assert list_collections(dataset="d", store=store) == ["meeting"]
    assert list_collections(dataset="e", store=store) == []
    assert load_collection("pins-1", dataset="d", store=store).pins == ()
    with pytest.raises(ArgumentError, match="already"):
        name_collection("pins-2", "meeting", dataset="d", store=store)


def test_two_who_pin_at_once_lose_nothing(store: Store) -> None:
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda number: add_pins("a", [picture(str(number))], dataset="d", store=store), range(24)))
    assert sorted(titles(load_collection("a", dataset="d", store=store)), key=int) == [str(each) for each in range(24)]


@pytest.mark.parametrize("name", ["", " ", "x" * 61, "a\nb"])
def test_names_that_nobody_could_read_are_refused(store: Store, name: str) -> None:
    with pytest.raises(ArgumentError, match="printable"):
        add_pins(name, [picture("x")], dataset="d", store=store)


def test_a_full_collection_says_so(store: Store) -> None:
    add_pins("a", map(picture, map(str, range(100))), dataset="d", store=store)
    with pytest.raises(ArgumentError, match="at most 100"):
        add_pins("a", [picture("x")], dataset="d", store=store)


def test_broken_files_cost_their_pin_only(store: Store) -> None:
    figure, photo = add_pins("a", [Pin("f", go.Figure()), picture("p")], dataset="d", store=store).pins
    store.file("pinned", figure.id, ".json").write_bytes(b"{}")
    found = load_collection("a", dataset="d", store=store)
    assert [pin.title for pin in found.load(store=store)] == ["p"]
    store.file("pinned", photo.id, ".jpg").unlink()
    assert found.load(store=store) == []
    for path in (store.root / "pins").rglob("*.json"):
        path.write_bytes(b"[]")
    assert load_collection("a", dataset="d", store=store) == Collection("a", "d")


def test_a_store_that_cannot_be_written_says_so(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(FileError, match="could not be kept"):
        add_pins("a", [picture("x")], dataset="d", store=Store(tmp_path / "file"))


def test_a_collection_that_is_none_is_not_read(store: Store) -> None:
    add_pins("a", [picture("x")], dataset="d", store=store)
    [key] = store.keys("pins")
    content = store.json("pins", key)
    assert content is not None
    for change in ({"pins": None}, {"name": ""}, {"pins": [{"id": 1}]}, {"removed": [[1]]}):
        store.save_json("pins", key, content | change)
        assert load_collection("a", dataset="d", store=store).pins == ()
