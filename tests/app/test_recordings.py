from pathlib import Path

import pytest

from tests.app.driver import Visitor
from tests.tiny import write_tiny_dataset


def test_table_lists_what_is_known_and_missing(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root)
    table = visitor.test.dataframe[0].value
    assert list(table.index) == ["000000", "000001", "000002"]
    assert list(table["container"]) == ["red cup", "green glass", "small white cup"]
    assert list(table["filling"]) == ["none", "rice", "water"]
    assert list(table["missing"]) == ["", "view2 video, audio", ""]
    assert table["picture"].str.fullmatch(r"/thumbnails/[0-9a-f]+/00000\d\.jpg").all()


def test_filters_leave_the_rows_that_fit(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root)
    visitor.test.multiselect(key="filter_container").set_value(["green glass", "small white cup"]).run()
    assert list(visitor.test.dataframe[0].value.index) == ["000001", "000002"]
    visitor.test.selectbox(key="filter_lacks").set_value("complete").run()
    assert list(visitor.test.dataframe[0].value.index) == ["000002"]
    visitor.test.multiselect(key="filter_filling").set_value(["none"]).run()
    assert list(visitor.test.dataframe[0].value.index) == []
    assert "0 of 3 recordings" in visitor.sentences
    assert visitor.crashes == []
    assert visitor.test.subheader[0].value == "Recording 000000"


def test_selected_row_of_a_filtered_table_is_the_recording_that_stands_there(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root)
    visitor.test.multiselect(key="filter_container").set_value(["green glass", "small white cup"]).run()
    visitor.select_row(1)
    assert visitor.address["recording"] == "000002"
    assert visitor.test.subheader[0].value == "Recording 000002"
    visitor.test.multiselect(key="filter_container").set_value([]).run()
    assert visitor.address["recording"] == "000002"


def test_selecting_a_row_forgets_the_other_recordings_frame_and_pair(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, recording="000000", frame="4", pair="view3-view2", L="99")
    visitor.select_row(2)
    assert visitor.address == {"recording": "000002", "L": "99"}


def test_views_and_sound_that_are_there_are_playable(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root)
    assert (visitor.count("video"), visitor.count("audio")) == (3, 1)
    visitor.test.selectbox(key="channel_control").set_value(7).run()
    assert visitor.count("audio") == 1
    visitor.select_row(1)
    assert (visitor.count("video"), visitor.count("audio")) == (2, 0)
    assert visitor.warnings == ["Missing: view2 video, audio."]


def test_real_set_lists_all_annotated_recordings_and_opens_one_without_files(real_root: Path) -> None:
    visitor = Visitor(real_root)
    assert list(visitor.test.dataframe[0].value.index) == ["000618"]
    assert visitor.count("video") == 4
    visitor.test.selectbox(key="filter_lacks").select_index(0).run()
    table = visitor.test.dataframe[0].value
    assert len(table) == 684
    visitor.select_row(list(table.index).index("000002"))
    assert visitor.address["recording"] == "000002"
    assert visitor.crashes == []
    assert visitor.warnings == ["Missing: view1 video, view2 video, view3 video, audio."]


@pytest.mark.parametrize("page", ["frames", "shape"])
def test_recording_without_files_is_said_to_have_none(real_root: Path, page: str) -> None:
    visitor = Visitor(real_root, recording="000002").open(page)
    assert visitor.crashes == []
    assert "view3" in visitor.sentences
    assert "video" in visitor.sentences


def picker(visitor: Visitor) -> list[str]:
    """The ids that the recording picker offers."""
    return [option.split(" · ")[0] for option in visitor.test.selectbox(key="picker").options]


def test_picker_follows_the_tables_filters_and_keeps_them_on_other_pages(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root)
    assert picker(visitor) == ["000000", "000001", "000002"]
    visitor.test.multiselect(key="filter_container").set_value(["small white cup"]).run()
    assert picker(visitor) == ["000000", "000002"]  # the chosen one stays
    visitor.press("Next")
    assert visitor.address["recording"] == "000002"
    assert picker(visitor) == ["000002"]
    visitor.open("filling").open("recordings")
    assert list(visitor.test.dataframe[0].value.index) == ["000002"]


def test_picker_offers_what_has_files_and_steps_through_it(real_root: Path) -> None:
    assert picker(Visitor(real_root)) == ["000618"]
    visitor = Visitor(real_root, recording="000002")
    assert picker(visitor) == ["000002", "000618"]
    visitor.press("Next")
    assert visitor.address["recording"] == "000618"


def test_steps_end_at_the_first_and_the_last_recording(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, recording="000000", frame="4")
    assert visitor.test.button(key="picker_Previous").disabled
    visitor.press("Next")
    visitor.press("Next")
    assert visitor.address["recording"] == "000002"
    assert visitor.test.button(key="picker_Next").disabled


def test_a_clicked_cell_opens_its_recording_until_another_is_chosen(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root)
    key = visitor.test.dataframe[0].proto.id.split("-", 2)[2]
    visitor.test.session_state[key] = {"selection": {"rows": [], "columns": [], "cells": [(1, "kind")]}}
    visitor.test.run()
    assert visitor.address["recording"] == "000001"
    visitor.test.session_state[key] = {"selection": {"rows": [], "columns": [], "cells": [(1, "kind")]}}
    visitor.press("Next")
    assert visitor.address["recording"] == "000002"


def test_another_dataset_opens_with_a_recording_that_has_files(tiny_dataset_root: Path, real_root: Path) -> None:
    visitor = Visitor(real_root, recording="000002")
    visitor.test.multiselect(key="filter_filling").set_value(["rice"]).run()
    visitor.test.text_input(key="data_folder").set_value(str(tiny_dataset_root)).run()
    assert visitor.address["recording"] == "000002"  # it has files here, although not there
    assert picker(visitor) == ["000000", "000001", "000002"]
    visitor.test.text_input(key="data_folder").set_value(str(real_root)).run()
    assert visitor.address["recording"] == "000618"
    assert visitor.crashes == visitor.warnings == []


def test_findings_of_the_set_and_of_its_files_are_listed(tmp_path: Path) -> None:
    root = write_tiny_dataset(tmp_path / "set", recordings=2, frames=2)
    (root / "view1/rgb/000000 (1).mp4").touch()
    (root / "view2/calib/000000.pickle").write_bytes(b"broken")
    visitor = Visitor(root)
    assert visitor.test.expander[0].label == "Files: 3 warnings, 1 note"
    assert visitor.test.dataframe[1].value["file"].iloc[0] == "view1/rgb/000000 (1).mp4"
    assert visitor.warnings == [
        "view1/rgb/000000 (1).mp4: is named like a copy of 000000 and is not used; rename it to 000000.mp4 if it is "
        "the one to use"
    ]
    visitor.press("Check all files")
    visitor.wait_for(lambda visitor: visitor.test.expander[0].label == "Files: 1 error, 3 warnings, 1 note")
    assert visitor.test.dataframe[1].value["file"].iloc[0] == "view2/calib/000000.pickle"
    assert any("view2/calib/000000.pickle: is no" in warning for warning in visitor.warnings)
    assert "Check all files again" in [button.label for button in visitor.test.button]
    assert visitor.crashes == []
