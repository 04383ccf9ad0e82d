"""Masks by hand as COCO files, there and back."""

import json

import numpy as np
import pytest

from corsmal.by_hand import HandMask, MaskHistory, export_masks, import_masks
from corsmal.dataset import open_dataset
from corsmal.detection import read_coco_results
from corsmal.store import Store
from tests.tiny import write_tiny_dataset

SHAPE = (72, 128)


def rectangle(top, bottom, left, right):
    mask = np.zeros(SHAPE, dtype=bool)
    mask[top:bottom, left:right] = True
    return mask


@pytest.fixture(scope="module")
def view(tmp_path_factory):
    root = write_tiny_dataset(tmp_path_factory.mktemp("set"), recordings=1, frames=4, size=SHAPE[::-1])
    return open_dataset(root)["000000"].views["view1"]


@pytest.fixture
def history(view, tmp_path):
    return MaskHistory("000000", view, store=Store(tmp_path / "cache"))


def drawn(history):
    facts = {"tool": "brush", "who": "Ada", "based_on": "detection 1"}
    first = HandMask.of(rectangle(20, 50, 40, 70), frame=1, amodal=rectangle(20, 60, 40, 70), **facts)
    history.keep(first, after=0)
    history.keep(HandMask.of(rectangle(22, 52, 41, 71), frame=3, is_accepted=False, **facts), after=0)
    return history.masks(accepted_only=False)


def test_what_is_written_is_read_by_any_reader_of_coco(history, tmp_path):
    export_masks(drawn(history), tmp_path / "masks.json", video=history.video)
    found = read_coco_results(tmp_path / "masks.json", size=SHAPE, frame_count=4)
    np.testing.assert_array_equal(found[1].mask(0), rectangle(20, 50, 40, 70))
    [first, _] = json.loads((tmp_path / "masks.json").read_text())
    assert (first["source"], first["who"], first["based_on"]) == ("by hand", "Ada", "detection 1")
    assert first["when"]
    assert first["video"] == history.video


def test_what_is_written_comes_back_whole(history, view, tmp_path):
    masks = drawn(history)
    export_masks(masks, tmp_path / "masks.json", video=history.video)
    other = Store(tmp_path / "other")
    assert import_masks("000000", view, tmp_path / "masks.json", store=other) == (2, ())
    back = MaskHistory("000000", view, store=other).masks(accepted_only=False)
    for frame, mask in masks.items():
        assert (back[frame].counts, back[frame].amodal) == (mask.counts, mask.amodal)
        assert (back[frame].who, back[frame].based_on, back[frame].is_accepted) == (
            "Ada",
            "detection 1",
            mask.is_accepted,
        )


def test_polygons_of_a_labelling_tool_serve(history, view, tmp_path):
    outline = [40.0, 20, 70, 20, 70, 50, 40, 50]
    entries = [
        {"image_id": 2, "category_id": 47, "score": 0.4, "segmentation": [outline]},
        {"image_id": 2, "category_id": 1, "score": 1.0, "segmentation": [[0.0, 0, 20, 0, 20, 20]]},
    ]
    (tmp_path / "tool.json").write_text(json.dumps(entries))
    count, _ = import_masks("000000", view, tmp_path / "tool.json", store=Store(tmp_path / "cache"), who="Bob")
    mask = history.masks()[2]
    assert count == 1
    assert abs(mask.area - 900) < 65
    assert (mask.who, mask.tool, mask.based_on) == ("Bob", "import", "tool.json")


def test_masks_of_another_video_and_empty_ones_are_left_out_with_a_sentence(history, view, tmp_path):
    masks = drawn(history)
    export_masks(masks, tmp_path / "masks.json", video="0123456789abcdef")
    count, said = import_masks("000000", view, tmp_path / "masks.json", store=Store(tmp_path / "other"))
    assert count == 0
    assert [sentence.split(":")[0] for sentence in said] == ["frame 1", "frame 3"]
    assert "another video" in said[0]
    empty = HandMask.of(np.zeros(SHAPE, dtype=bool), frame=1)
    [entry] = HandMask.of(rectangle(1, 3, 1, 3), frame=1).detections().to_coco(1)
    entry["segmentation"]["counts"] = empty.counts.decode()
    (tmp_path / "empty.json").write_text(json.dumps([entry]))
    count, said = import_masks("000000", view, tmp_path / "empty.json", store=Store(tmp_path / "other"))
    assert (count, said[-1]) == (0, "frame 1: the mask is empty; not imported")


def test_an_imported_mask_leaves_the_one_that_was_there_in_the_history(history, view, tmp_path):
    store = Store(tmp_path / "cache")
    export_masks(drawn(history), tmp_path / "masks.json")
    history.keep(HandMask.of(rectangle(5, 9, 5, 9), frame=1, tool="brush"), after=history.frame(1).version)
    import_masks("000000", view, tmp_path / "masks.json", store=store)
    assert history.masks()[1].area == 900
    history.undo(1, after=history.frame(1).version)
    assert history.masks()[1].area == 16
