"""Links that mean one thing: they name their dataset, and show nothing of another."""

import shutil
from pathlib import Path

import pytest

from corsmal.dataset import open_dataset
from corsmal.demo.opening import demo_folder
from corsmal.ui import shared
from tests.app.driver import Visitor
from tests.tiny import write_tiny_dataset

TITLE = "This link cannot be shown here"


@pytest.fixture(scope="module")
def other(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset with recordings of the same numbers, and no annotation; read only."""
    root = write_tiny_dataset(tmp_path_factory.mktemp("others") / "other", recordings=3, frames=2)
    (root / "ccm_tiny_annotation.json").unlink()
    return root


def title(visitor: Visitor) -> str:
    return str(visitor.test.title[0].value)


def test_a_link_is_shown_nowhere_else_until_its_dataset_is_named(tiny_dataset_root: Path, other: Path) -> None:
    link = Visitor(tiny_dataset_root, recording="000001", frame="2", L="99").link
    shutil.rmtree(shared.store().root / "datasets")  # another server, which never opened that dataset
    visitor = Visitor(other, **link)
    assert title(visitor) == TITLE
    assert "000001" in visitor.errors[0]
    assert "another dataset" in visitor.errors[0]
    assert visitor.count("video", "audio", "arrow_data_frame", "bidi_component") == 0
    assert visitor.test.selectbox.values == []
    assert visitor.link == link  # to be read again, or sent on
    visitor.test.run()
    assert title(visitor) == TITLE
    visitor.test.text_input(key="data_folder").set_value(str(tiny_dataset_root)).run()
    assert (title(visitor), visitor.link) == ("Recordings", link)
    assert visitor.test.selectbox(key="picker").value == "000001"
    assert visitor.crashes == visitor.errors == []


@pytest.mark.parametrize("begins", ["overview", "recordings"])
def test_a_visit_that_begins_with_nothing_to_show_has_the_sidebar(begins: str, other: Path, tmp_path: Path) -> None:
    for folder, link in ((other, {"recording": "999999"}), (tmp_path, {})):
        visitor = Visitor(folder, begins=begins, **link)
        visitor.test.text_input(key="data_folder").set_value(str(other)).run()
        assert visitor.crashes == []


def test_a_link_opens_a_dataset_that_the_server_has_opened_before(tiny_dataset_root: Path, other: Path) -> None:
    link = Visitor(tiny_dataset_root, recording="000002").link
    visitor = Visitor(other, **link)
    assert visitor.test.text_input(key="data_folder").value == str(tiny_dataset_root)
    assert visitor.test.selectbox(key="picker").value == "000002"
    assert visitor.link == link
    visitor.test.text_input(key="data_folder").set_value(str(other)).run()  # the link binds no more
    assert visitor.test.selectbox(key="picker").value in open_dataset(other)
    assert visitor.link["dataset"] != link["dataset"]
    visitor.go_back(**link)
    assert visitor.test.text_input(key="data_folder").value == str(tiny_dataset_root)
    assert visitor.crashes == visitor.errors == visitor.warnings == []


def test_a_link_can_be_left_or_shown_in_a_dataset_of_the_same_name(other: Path) -> None:
    link = {"dataset": "other-00000000", "recording": "000001", "frame": "3"}
    visitor = Visitor(other, **link)
    assert title(visitor) == TITLE
    visitor.press("Open other without the link")
    assert title(visitor) == "Recordings"
    assert visitor.address == {"recording": "000000"}
    visitor = Visitor(other, **link)
    visitor.press("Show it in the dataset other of this server, whose recordings or annotation differ")
    assert visitor.address == {"recording": "000001", "frame": "3"}
    assert visitor.link["dataset"] == f"other-{open_dataset(other).fingerprint}"


def test_a_link_to_the_demo_opens_on_every_server(other: Path) -> None:
    link = Visitor().link
    assert link["dataset"].startswith("demo-six-")
    shutil.rmtree(shared.store().root)
    visitor = Visitor(other, **link)
    assert visitor.test.text_input(key="data_folder").value == str(demo_folder(shared.store()))
    assert visitor.link == link
    assert visitor.crashes == visitor.errors == []


def test_hostile_names_in_a_link_are_shown_as_they_are(other: Path) -> None:
    visitor = Visitor(other, dataset="<b>[x](http://a)</b>-00000000", recording="$a$ `b` <script>")
    assert title(visitor) == TITLE
    assert "<b>[x](http://a)</b>" in visitor.errors[0]
    assert "$a$ `b` <script>" in visitor.errors[0]
    assert "<b>" not in visitor.test.error[0].value
    assert visitor.crashes == []


def test_filters_are_in_the_address_and_followed(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root)
    names = sorted(visitor.test.multiselect(key="filter_container").options)
    visitor.test.multiselect(key="filter_container").set_value(names[:2]).run()
    visitor.test.selectbox(key="filter_lacks").set_value("all").run()
    assert visitor.address["container"] == "~".join(names[:2])
    other = Visitor(tiny_dataset_root, **visitor.link)
    assert other.test.multiselect(key="filter_container").value == names[:2]
    assert list(other.test.dataframe[0].value.index) == list(visitor.test.dataframe[0].value.index)
    wrong = Visitor(tiny_dataset_root, container="no such cup", files="all")
    assert "container='no such cup'" in wrong.warnings[0]
    assert wrong.address == {"recording": "000000", "files": "all"}
