from pathlib import Path

import pytest

from corsmal.ui.messages import WORD_JOINER
from tests.app.driver import Visitor, rings

FULL = {
    "recording": "000001",
    "pair": "view3-view1",
    "frame": "2",
    "preset": "lode",
    "L": "120",
    "dmax": "0.5",
    "fit": "any",
}


def test_full_address_shows_exactly_that(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, **FULL).open("shape")
    test = visitor.test
    assert visitor.warnings == []
    assert visitor.address == FULL
    assert test.selectbox(key="picker").value == "000001"
    assert visitor.frame == 2
    assert test.selectbox(key="shape_fit_rule").value == "any"
    sliders = {slider["name"]: slider["value"] for slider in visitor.plots["hull"]["sliders"]}
    assert sliders == {"circumferences": 120, "max_difference_mm": 0.5}
    assert set(visitor.plots) >= {"reprojection_view3", "reprojection_view1"}


def test_two_visitors_with_one_address_see_the_same(tiny_dataset_root: Path) -> None:
    first = Visitor(tiny_dataset_root).open("shape")
    first.report("hull", values={"circumferences": 77}, settled=True)
    first.go_to(4)
    second = Visitor(tiny_dataset_root, **first.address).open("shape")
    assert second.metrics == first.metrics
    assert rings(second.plots["hull"]) == rings(first.plots["hull"])


def test_address_without_a_recording_keeps_its_frame(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, frame="2").open("shape")
    assert visitor.address == {"recording": "000000", "frame": "2"}
    assert visitor.frame == 2


def test_unknown_recording_is_said_and_none_is_shown_instead(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, recording="000999", frame="3", pair="view3-view2").open("shape")
    assert visitor.crashes == []
    [error] = visitor.errors
    assert "000999" in error
    assert "does not have: nothing of it is shown" in error
    assert (visitor.plots, visitor.metrics) == ({}, {})
    visitor.press(f"Open {tiny_dataset_root.name} without the link")
    assert visitor.address == {"recording": "000000"}
    assert "Capacity" in visitor.metrics


def test_a_recordings_number_is_its_id(tiny_dataset_root: Path) -> None:
    assert Visitor(tiny_dataset_root, recording="1", frame="2").address == {"recording": "000001", "frame": "2"}


@pytest.mark.parametrize("page", ["frames", "shape"])
def test_frame_beyond_the_end_is_said_once_and_the_best_one_shown(sound_root: Path, page: str) -> None:
    visitor = Visitor(sound_root, recording="000000", frame="6").open(page)
    assert visitor.crashes == []
    assert len(visitor.warnings) == 1
    assert "frame='6'" in visitor.warnings[0]
    assert "allowed range 0–5" in visitor.warnings[0]
    assert visitor.address == {"recording": "000000"}
    visitor.test.run()
    assert len(visitor.warnings) == 1
    visitor.open("recordings")
    visitor.open(page)
    assert len(visitor.warnings) == 1


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("frame", "-1"),
        ("frame", "three"),
        ("frame", "9" * 400),
        ("pair", "view1-view1"),
        ("preset", "best"),
        ("L", "1"),
        ("L", "inf"),
        ("N", "19.5"),
        ("dmax", "-0.1"),
        ("rmax", "x" * 10_000),
        ("fit", "some"),
        ("z", "masks:20:-20"),
        ("z", "world:nan:1"),
        ("colour", "blue"),
        ("<b>bold</b>", "1"),
    ],
)
def test_garbage_is_one_warning_that_names_it_and_the_rest_is_used(sound_root: Path, name: str, value: str) -> None:
    visitor = Visitor(sound_root, **{"recording": "000000", "radii": "100", name: value}).open("shape")
    assert visitor.crashes == []
    assert visitor.errors == []
    assert len(visitor.warnings) == 1
    assert name in visitor.warnings[0]
    assert len(visitor.warnings[0]) < 300
    assert visitor.address == {"recording": "000000", "radii": "100"}
    assert "Capacity" in visitor.metrics


@pytest.mark.parametrize("text", ["[x](http://example.com)", "$a$", "*b*", "`c`", "<b>", ":red[d]", "~e~", "_f_"])
def test_what_stood_in_an_address_is_shown_as_it_is(sound_root: Path, text: str) -> None:
    visitor = Visitor(sound_root, recording="000000", frame=text).open("shape")
    [warning] = visitor.test.warning
    assert f"frame='{text}'" in visitor.warnings[0]
    assert text not in warning.value
    escaped = "".join(rf"\{mark}" if mark in "[]()$*`<>:~_" else mark for mark in text)
    assert escaped in warning.value.replace(WORD_JOINER, "")


def test_each_wrong_parameter_has_its_own_warning_and_a_choice_ends_them(sound_root: Path) -> None:
    visitor = Visitor(sound_root, recording="000000", frame="-1", L="x").open("shape")
    assert len(visitor.warnings) == 2
    visitor.report("hull", values={"circumferences": 99}, settled=True)
    visitor.test.run()
    assert visitor.warnings == []


def test_pages_share_the_choice_although_navigation_empties_the_address(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root).open("frames")
    visitor.go_to(4)
    visitor.open("shape")
    assert visitor.frame == 4
    visitor.report("hull", values={"circumferences": 60}, settled=True)
    visitor.open("recordings")
    assert visitor.address == {"recording": "000000", "frame": "4", "L": "60"}
    visitor.open("shape")
    assert {slider["value"] for slider in visitor.plots["hull"]["sliders"]} == {60, 1.0}


def test_pair_and_frame_are_shown_as_chosen_on_every_page(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root).open("frames")
    for page in ("frames", "shape", "mass", "shape"):
        visitor.open(page)
        assert visitor.widget("pair_control").value == ("view3", "view1")
    visitor.go_to(2)
    visitor.open("mass")
    assert visitor.frame == 2


def test_going_back_restores_what_the_older_address_says(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root).open("shape")
    visitor.report("hull", values={"circumferences": 60}, settled=True)
    older, metrics = visitor.address, visitor.metrics
    visitor.report("hull", values={"circumferences": 300}, settled=True)
    visitor.go_to(1)
    visitor.test.selectbox(key="picker").set_value("000001").run()
    visitor.go_back(**older)
    assert visitor.address == older
    assert visitor.metrics == metrics
    assert visitor.test.selectbox(key="picker").value == "000000"
    assert visitor.warnings == []


def test_a_run_with_the_address_of_a_moment_ago_takes_nothing_back(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root).open("shape")
    before = visitor.address
    visitor.report("hull", values={"circumferences": 60}, settled=True)
    visitor.run_at(**before)
    assert visitor.address == before | {"L": "60"}


def test_a_pair_that_an_input_showed_a_moment_ago_is_not_taken_for_a_choice(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, pair="view3-view2").open("shape")
    shown = visitor.widget("pair_control")
    visitor.go_back(recording="000000", pair="view3-view1")
    shown.set_value(("view3", "view2")).run()
    assert visitor.address == {"recording": "000000", "pair": "view3-view1"}


def test_a_report_that_was_answered_moves_the_playhead_no_more(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, frame="2").open("shape")
    visitor.go_to(3)
    visitor.go_back(recording="000000", frame="4")
    assert visitor.frame == 4
    assert visitor.address == {"recording": "000000", "frame": "4"}
