"""Folders and annotations with something wrong: the app says what, and shows what there is."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.app.driver import Visitor

ANNOTATION = "ccm_tiny_annotation.json"


def assert_says(visitor: Visitor, *words: str) -> None:
    """No page crashes, and the first one says it in one sentence, be it in the sidebar, on the page or on both."""
    assert visitor.crashes == []
    sentences = {line for line in visitor.sentences.splitlines() if all(word in line for word in words)}
    assert len(sentences) == 1, visitor.sentences
    for page in ("frames", "shape"):
        assert visitor.open(page).crashes == []


def change_annotation(root: Path, change: Callable[[dict[str, Any]], object]) -> None:
    content = json.loads((root / ANNOTATION).read_text(encoding="utf-8"))
    for row in content["annotations"]:
        change(row)
    (root / ANNOTATION).write_text(json.dumps(content), encoding="utf-8")


def test_missing_folder(tmp_path: Path) -> None:
    visitor = Visitor(tmp_path / "nowhere")
    assert_says(visitor, str(tmp_path / "nowhere"), "no such folder")
    assert "Name a dataset folder in the sidebar" in visitor.sentences


@pytest.mark.parametrize("name", ["[x](http:example.com)", "$a$ and $b$", "*b*", "~no~"])
def test_name_of_a_folder_is_shown_as_it_is(tmp_path: Path, name: str) -> None:
    visitor = Visitor(tmp_path / name)
    assert_says(visitor, str(tmp_path / name), "no such folder")
    assert not any(name in element.value for element in visitor.test.error)


def test_empty_folder(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    assert_says(Visitor(tmp_path / "empty"), "empty", "holds no recordings", "view1/rgb/000618.mp4")


def test_folder_around_the_dataset_is_led_to_the_dataset(root: Path) -> None:
    assert_says(Visitor(root.parent), "did you mean its folder 'train'?")


def test_file_as_folder(root: Path) -> None:
    assert_says(Visitor(root / ANNOTATION), ANNOTATION, "is a file")


@pytest.mark.parametrize("folder", ["~no-such-user/train", "nul\0character", "/" + "long" * 2000])
def test_text_that_can_be_no_folder(folder: str) -> None:
    visitor = Visitor(folder)
    assert_says(visitor, "name the folder of a dataset")
    assert len(set(visitor.errors)) == 1


def test_folder_that_vanishes_while_it_is_shown(root: Path) -> None:
    visitor = Visitor(root).open("frames")
    shutil.rmtree(root)
    visitor.go_to(0)
    assert_says(visitor, str(root), "no such folder")


def test_video_that_vanishes_while_it_is_shown(root: Path) -> None:
    visitor = Visitor(root).open("shape")
    (root / "view1" / "rgb" / "000000.mp4").unlink()
    visitor.report("hull", values={"circumferences": 60}, settled=True)
    assert visitor.crashes == []
    assert "view1 has no video" in visitor.sentences or "Capacity" in visitor.metrics


def test_no_annotation(root: Path) -> None:
    (root / ANNOTATION).unlink()
    visitor = Visitor(root)
    assert visitor.count("video") == 3
    assert_says(visitor, "no annotation was found", str(root))
    visitor.open("shape")
    assert [line.strip() for line in visitor.sentences.splitlines() if line.startswith("no annotation  ")] == 4 * [
        "no annotation"
    ]


def test_annotation_that_is_no_json(root: Path) -> None:
    (root / ANNOTATION).write_text('{"annotations": [', encoding="utf-8")
    visitor = Visitor(root)
    assert visitor.count("video") == 3
    assert_says(visitor, ANNOTATION, "cannot be read")


def test_annotation_with_a_missing_column(root: Path) -> None:
    change_annotation(root, lambda row: row.pop("container capacity"))
    visitor = Visitor(root)
    assert_says(visitor, ANNOTATION, "no column 'container capacity'")
    visitor.open("shape")
    notes = [line for line in visitor.sentences.splitlines() if line.startswith(("annotated", "no annotation  "))]
    assert notes[0].strip() == "no annotation"
    assert notes[3].startswith("annotated 119 mm, error ")


@pytest.mark.parametrize("key", ["container capacity", "container id", "filling type"])
def test_annotation_with_a_nan(root: Path, key: str) -> None:
    change_annotation(root, lambda row: row.update({key: float("nan")}))
    assert_says(Visitor(root), ANNOTATION, f"'{key}'", "recording 000000")


def test_dataset_of_an_annotation_alone(root: Path) -> None:
    for part in ("view1", "view2", "view3", "audio"):
        shutil.rmtree(root / part)
    visitor = Visitor(root)
    assert "0 of 1 recordings" in visitor.sentences
    assert_says(visitor, "the whole set has no audio")
