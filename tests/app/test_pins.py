"""Pins: made on the pages, kept on the server, ordered and annotated in the tray."""

from pathlib import Path
from typing import Any

import pytest
import streamlit as st

from corsmal.dataset import open_dataset
from corsmal.figures.pin_collections import load_collection
from corsmal.figures.pins import Pin
from corsmal.ui import shared
from tests.app.driver import Visitor


def pinned(visitor: Visitor) -> list[Pin]:
    """What the visitor's collection holds on the server."""
    fingerprint = visitor.link["dataset"].rpartition("-")[2]
    name = visitor.link.get("pins")
    if name is None:
        return []
    return load_collection(name, dataset=fingerprint, store=shared.store()).load(store=shared.store())


def titles(visitor: Visitor) -> list[str]:
    return [pin.title for pin in pinned(visitor)]


def tray(visitor: Visitor) -> dict[str, Any]:
    """What the tray was given to show."""
    return visitor._components["pin_list"]


def test_pins_are_kept_with_their_numbers_parameters_and_link(sound_root: Path) -> None:
    visitor = Visitor(sound_root, L="99", frame="5").open("shape")
    visitor.report("hull", camera=[1.0, -0.5, 0.25, 0.0, 0.0, 0.1])
    visitor.press("Pin the hull")
    title = "Hull of 000000, view3 + view1, frame 5, paper, own values"
    assert [toast.value.replace("\\", "") for toast in visitor.test.toast] == [f"Pinned: {title}"]
    visitor.open("frames")
    assert not visitor.test.toast
    visitor.press("Pin the pictures")
    assert visitor.crashes == []
    assert titles(visitor) == [title, "000000, view3, frame 5", "000000, view1, frame 5"]
    hull, picture, _ = pinned(visitor)
    assert hull.figure is not None
    assert hull.figure.layout.scene.camera.eye.y == -0.5
    assert hull.numbers["Capacity, frame 5, paper, own values"].endswith(" mL")
    assert hull.parameters["L, circumferences"] == "99"
    assert (hull.dataset, hull.recording, hull.frame, hull.run) == (sound_root.name, "000000", 5, None)
    assert hull.link is not None
    assert hull.link.startswith(f"shape?dataset={visitor.link['dataset']}&recording=000000&frame=5&")
    assert "pins=" not in hull.link
    assert picture.content[:2] == b"\xff\xd8"  # JPEG
    assert [pin["kind"] for pin in tray(visitor)["pins"]] == ["figure", "picture", "picture"]
    later = Visitor(sound_root, **visitor.link)  # after a reload, or another day
    assert titles(later) == titles(visitor)
    assert [pin["title"] for pin in tray(later)["pins"]] == titles(visitor)


def test_visitors_have_pins_of_their_own_until_they_open_a_named_collection(sound_root: Path) -> None:
    first, second = Visitor(sound_root).open("frames"), Visitor(sound_root).open("frames")
    first.press("Pin the pictures")
    assert "pins" not in second.link
    second.press("Pin the pictures")
    assert first.link["pins"] != second.link["pins"]
    first.test.text_input(key="pins_name").set_value("meeting <b>").run()
    assert first.link["pins"] == "meeting <b>"
    first.report("pin_list", actions=[{"do": "note", "id": tray(first)["pins"][0]["id"], "text": "=1+1"}])
    second.test.run()
    assert second.test.selectbox(key="pins_open").options[0] == "meeting <b>"
    second.test.selectbox(key="pins_open").set_value("meeting <b>").run()
    assert [pin["note"] for pin in tray(second)["pins"]] == ["=1+1", ""]
    assert first.crashes == second.crashes == []


def test_the_tray_orders_notes_removes_and_restores(sound_root: Path) -> None:
    visitor = Visitor(sound_root).open("frames")
    visitor.press("Pin the pictures")
    one, two = (pin["id"] for pin in tray(visitor)["pins"])
    visitor.report("pin_list", actions=[{"do": "order", "order": [two, one]}, {"do": "remove", "id": one}])
    assert titles(visitor) == ["000000, view1, frame 5"]
    assert tray(visitor)["removed"] == "000000, view3, frame 5"
    visitor.report("pin_list", actions=[{"do": "restore"}])
    assert titles(visitor) == ["000000, view1, frame 5", "000000, view3, frame 5"]
    for actions in ([{"do": "burn"}], "x", [1], [{"do": "order", "order": 3}]):
        visitor.report("pin_list", actions=actions)
        assert "reload the page" in visitor.errors[0]
        assert visitor.crashes == []
    assert len(pinned(visitor)) == 2


def test_what_cannot_be_pinned_is_said_and_nothing_is_pinned(root: Path) -> None:
    visitor = Visitor(root).open("frames")
    video = root / "view3" / "rgb" / "000000.mp4"
    video.write_bytes(b"")
    st.cache_resource.clear()
    visitor.press("Pin the pictures")
    assert visitor.crashes == []
    assert str(video) in visitor.test.toast[0].value.replace("\\", "")
    assert pinned(visitor) == []


def test_sound_and_masks_are_pinned(sound_root: Path) -> None:
    visitor = Visitor(sound_root, frame="5").open("filling")
    visitor.press("Pin the sound")
    visitor.open("mass")
    visitor.press("Pin the masks")
    assert visitor.crashes == []
    sound, masks = pinned(visitor)
    assert sound.title.startswith("Sound of 000000, ")
    assert sound.title.endswith(", whole recording")
    assert sound.content[:4] == b"RIFF"
    assert sound.numbers["Filling type"].endswith(" %")
    assert masks.title == "Mask of 000000, view3, frame 5"
    assert masks.figure is not None
    assert masks.parameters["axis"] == "whole"


@pytest.mark.parametrize("name", ["x" * 61, "a" * 80])
def test_a_collections_name_that_cannot_be_one_is_said(sound_root: Path, name: str) -> None:
    visitor = Visitor(sound_root, pins=name)
    assert visitor.crashes == []
    assert "printable characters" in visitor.errors[0]
    assert open_dataset(sound_root).fingerprint in visitor.link["dataset"]
