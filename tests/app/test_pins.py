from pathlib import Path

import streamlit as st

from corsmal.ui import pins
from tests.app.driver import Visitor


def pinned(visitor: Visitor) -> list[str]:
    state = visitor.test.session_state
    return [pin.title for pin in state[pins.KEY]] if pins.KEY in state else []


def test_hull_and_pictures_are_pinned_in_order_and_kept_between_pages(sound_root: Path) -> None:
    visitor = Visitor(sound_root).open("shape")
    visitor.press("Pin the hull")
    assert [toast.value.replace("\\", "") for toast in visitor.test.toast] == [
        "Pinned: Hull of 000000, view3 + view1, frame 5"
    ]
    visitor.open("frames")
    assert not visitor.test.toast
    visitor.press("Pin the pictures")
    assert visitor.crashes == []
    assert pinned(visitor) == [
        "Hull of 000000, view3 + view1, frame 5",
        "000000, view3, frame 5",
        "000000, view1, frame 5",
    ]
    hull, picture, _ = visitor.test.session_state[pins.KEY]
    assert hull.figure.data
    assert picture.content[:2] == b"\xff\xd8"  # JPEG


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
    visitor = Visitor(sound_root).open("filling")
    visitor.press("Pin the sound")
    visitor.open("mass")
    visitor.press("Pin the masks")
    assert visitor.crashes == []
    sound, masks = visitor.test.session_state[pins.KEY]
    assert sound.title.startswith("Sound of 000000, ")
    assert sound.title.endswith(", whole recording")
    assert sound.content[:4] == b"RIFF"
    assert masks.title == "Mask of 000000, view3, frame 5"
    assert masks.figure.data
