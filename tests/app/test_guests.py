"""A server for visitors: a data root, and read-only for guests."""

import os
import sys
from pathlib import Path

import pytest

from corsmal.demo.opening import open_demo
from corsmal.errors import CorsmalError
from corsmal.ui import shared
from corsmal.ui.folders import READ_ONLY, REFUSED
from tests.app.driver import Visitor

ACTS = (
    *("Run", "Update", "Delete", "Undo", "Restore", "Save", "Archive", "Resume", "Make all thirty recordings"),
    *(
        "Reproduce Table 2",
        "Sweep",
        "Attribute",
        "Find the best frame",
        "Inspect all frames",
        "Compute the rest",
        "Pin ",
    ),
)


@pytest.fixture
def read_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["app.py", "--read-only"])


@pytest.mark.usefixtures("read_only")
@pytest.mark.parametrize("page", ["overview", "frames", "evaluation"])
def test_guests_see_every_page_and_change_nothing(page: str) -> None:
    visitor = Visitor().open(page)
    visitor.wait_for(lambda seen: not seen.progress)
    assert visitor.crashes == visitor.errors == []
    assert READ_ONLY in visitor.sentences
    assert [label for label in visitor.buttons if label.startswith(ACTS)] == []
    if page == "evaluation":
        for section in ("Attribution", "Sweep", "Report"):
            visitor.choose("section_control", section)
            assert visitor.crashes == visitor.errors == []
            assert [label for label in visitor.buttons if label.startswith(ACTS)] == []
        for view in ("reproduction", "rules", "runs"):
            visitor.choose("evaluation_view", view)
            assert visitor.crashes == visitor.errors == []
            assert [label for label in visitor.buttons if label.startswith(ACTS)] == []
        visitor.select_row(0)
        assert "Show its results" in visitor.buttons
        assert [label for label in visitor.buttons if label.startswith(ACTS)] == []


@pytest.mark.usefixtures("read_only")
def test_jobs_of_guests_are_refused_whatever_a_page_offers() -> None:
    with pytest.raises(CorsmalError, match="read-only"):
        shared.jobs().start("key", "label", print)


def test_other_folders_than_the_data_root_are_refused_in_the_same_words(
    tiny_dataset_root: Path, sound_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    root = tmp_path / "data"
    root.mkdir()
    os.symlink(sound_root, root / "leads_out")
    os.rename(Path(open_demo(store=shared.store())), root / "six")
    monkeypatch.setattr(sys, "argv", ["app.py", "--data-root", str(root)])
    visitor = Visitor("six")
    assert visitor.link["dataset"].startswith("six-")
    for folder in (tiny_dataset_root, "/etc/none", "../data/../x", "leads_out", sound_root):
        visitor.test.text_input(key="data_folder").set_value(str(folder)).run()
        assert visitor.errors == [REFUSED] * 2  # in the sidebar and on the page
        assert visitor.crashes == []
    link = {"dataset": f"{tiny_dataset_root.name}-00000000", "recording": "000000"}
    assert str(tiny_dataset_root.parent) not in Visitor("six", **link).sentences
