"""Every page, opened by a visitor who has done nothing else."""

import sys
from pathlib import Path

import pytest

from tests.app.driver import PAGES, Visitor


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.parametrize("dataset", ["tiny_dataset_root", "real_root"])
def test_page_shows_the_recording_without_a_complaint(page: str, dataset: str, request: pytest.FixtureRequest) -> None:
    visitor = Visitor(request.getfixturevalue(dataset)).open(page)
    assert visitor.crashes == []
    assert visitor.errors == []
    assert [warning for warning in visitor.warnings if "synthetic" not in warning] == []
    assert visitor.test.title[0].value == page.capitalize()
    assert list(visitor.address) == ["recording"]


@pytest.mark.parametrize("page", PAGES)
def test_page_without_a_folder_says_how_to_name_one(page: str) -> None:
    visitor = Visitor("").open(page)
    assert visitor.crashes == []
    assert visitor.errors == []
    assert "Name a dataset folder in the sidebar" in visitor.sentences
    assert visitor.address == {}


def test_folder_comes_from_the_command_line_else_from_the_environment(
    tiny_dataset_root: Path, sound_root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CORSMAL_DATA", str(sound_root))
    assert len(Visitor().test.selectbox(key="picker").options) == 1
    monkeypatch.setattr(sys, "argv", ["app.py", "--data", str(tiny_dataset_root)])
    assert len(Visitor().test.selectbox(key="picker").options) == 3


def test_typing_another_folder_opens_it_and_keeps_it_on_other_pages(tiny_dataset_root: Path, sound_root: Path) -> None:
    visitor = Visitor(sound_root)
    visitor.test.text_input(key="data_folder").set_value(str(tiny_dataset_root)).run()
    assert len(visitor.test.selectbox(key="picker").options) == 3
    visitor.open("frames")
    assert len(visitor.test.selectbox(key="picker").options) == 3
    assert visitor.crashes == []


def test_recording_picker_chooses_for_all_pages(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root)
    visitor.test.selectbox(key="picker").set_value("000001").run()
    assert visitor.test.subheader[0].value == "Recording 000001"
    assert visitor.address == {"recording": "000001"}
    visitor.open("frames")
    assert visitor.address == {"recording": "000001"}
    assert "000001" in visitor.plots["scores"]["label"]
