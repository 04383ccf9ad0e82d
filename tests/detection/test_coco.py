import json

import numpy as np
import pytest

from corsmal.detection import Detections, ViewDetections, read_coco_results, write_coco_results
from corsmal.errors import CorsmalError, FileError

SIZE = (6, 8)
CUP = {
    "image_id": 0,
    "category_id": 47,
    "bbox": [2, 1, 3, 4],
    "score": 0.75,
    "segmentation": {"size": [6, 8], "counts": [13, 4, 2, 4, 2, 4, 19]},
}


def file_of(folder, entries):
    path = folder / "detections" / "000001.json"
    path.parent.mkdir(exist_ok=True)
    path.write_text(entries if isinstance(entries, str) else json.dumps(entries))
    return path


def cup(**change):
    return {key: value for key, value in (CUP | change).items() if value is not ...}


def test_every_frame_of_the_video_counts_as_inspected(tmp_path):
    view = read_coco_results(file_of(tmp_path, [cup(image_id=2)]), size=SIZE, frame_count=4)
    assert view.frames == (0, 1, 2, 3)
    assert [len(view[frame]) for frame in view] == [0, 0, 1, 0]
    assert view.size == SIZE
    assert view.source == "file detections/000001.json"
    assert view.problems == ()
    [box], [score], [label] = view[2].boxes, view[2].scores, view[2].labels
    assert (box.tolist(), score, label) == ([2, 1, 5, 5], 0.75, 47)
    expected = np.zeros(SIZE, dtype=bool)
    expected[1:5, 2:5] = True
    np.testing.assert_array_equal(view[2].mask(0), expected)


def test_without_the_number_of_frames_those_with_an_entry_were_inspected(tmp_path):
    entries = [cup(image_id=9), cup(image_id=3, score=7), cup(image_id=1)]
    assert read_coco_results(file_of(tmp_path, entries), size=SIZE).frames == (1, 9)


def test_an_empty_list_says_that_nothing_was_found(tmp_path):
    path = file_of(tmp_path, [])
    assert read_coco_results(path, size=SIZE).frames == ()
    assert read_coco_results(path, size=SIZE, frame_count=2).frames == (0, 1)


def test_a_missing_box_is_taken_from_the_mask(tmp_path):
    view = read_coco_results(file_of(tmp_path, [cup(bbox=...)]), size=SIZE)
    assert view[0].boxes.tolist() == [[2, 1, 5, 5]]


def test_polygons_are_read(tmp_path):
    view = read_coco_results(file_of(tmp_path, [cup(segmentation=[[2, 1, 5, 1, 5, 5, 2, 5]])]), size=SIZE)
    assert view[0].mask_areas.tolist() == [12]


@pytest.mark.parametrize(
    ("entry", "reason"),
    [
        (cup(segmentation={"size": [5, 8], "counts": [40]}), "mask size 8x5, expected 8x6"),
        (cup(segmentation={"size": [6, 8], "counts": "abc"}), "the mask's run lengths (RLE) are broken"),
        (cup(segmentation={"size": [6, 8], "counts": [13, 4]}), "the mask's run lengths (RLE) are broken"),
        (cup(segmentation=...), "the mask (segmentation) is missing or neither polygons nor run lengths"),
        (cup(category_id=91), "unknown class, COCO's numbers are 1 to 90"),
        (cup(category_id=True), "unknown class, COCO's numbers are 1 to 90"),
        (cup(category_id=...), 'the key "category_id" is missing'),
        (cup(score=1.5), "the score is no number from 0 to 1"),
        (cup(score=float("nan")), "the score is no number from 0 to 1"),
        (cup(score=10**400), "the score is no number from 0 to 1"),
        (cup(score="high"), "the score is no number from 0 to 1"),
        (cup(image_id=...), 'the key "image_id" is missing'),
        (cup(image_id=-1), "frame (image_id) out of range, expected from 0 to 2"),
        (cup(image_id="first"), "the frame (image_id) is 'first', expected a whole number"),
        (cup(image_id=0.5), "the frame (image_id) is '0.5', expected a whole number"),
        (cup(image_id=7), "frame (image_id) out of range, expected from 0 to 2"),
        (cup(bbox=[0, 0, float("nan"), 1]), "the box is not four finite numbers x, y, width, height"),
        (cup(bbox=[0, 0, -1, 1]), "the box is not four finite numbers x, y, width, height"),
        (cup(bbox=[0, 0, 1]), "the box is not four finite numbers x, y, width, height"),
        (cup(bbox=[0, 0, 1, 10**400]), "the box is not four finite numbers x, y, width, height"),
        (cup(bbox=[1e308, 0, 1e308, 1]), "the box is not four finite numbers x, y, width, height"),
        (cup(bbox=..., segmentation={"size": [6, 8], "counts": [48]}), "no box, and the mask is empty"),
        ("cup", "not a mapping of keys to values"),
    ],
)
def test_an_entry_that_cannot_be_used_is_skipped_counted_and_reported(tmp_path, entry, reason):
    view = read_coco_results(file_of(tmp_path, [entry, cup(image_id=1), entry]), size=SIZE, frame_count=3)
    assert [len(view[frame]) for frame in view] == [0, 1, 0]
    assert view.problems == (f"2 entries skipped: {reason}",)
    with pytest.raises(FileError, match="no detection in it can be used") as caught:
        read_coco_results(file_of(tmp_path, [entry]), size=SIZE, frame_count=3)
    assert f"1 entry skipped: {reason}" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is not JSON"),
        ("[{", "is not JSON"),
        ("[" * 100_000, "is not JSON"),
        ("{}", "is not a list"),
        ("null", "is not a list"),
    ],
)
def test_a_file_that_is_no_list_is_an_error(tmp_path, text, message):
    with pytest.raises(FileError, match=message):
        read_coco_results(file_of(tmp_path, text), size=SIZE)


def test_a_file_that_is_not_text_or_not_there_is_an_error(tmp_path):
    binary = tmp_path / "binary.json"
    binary.write_bytes(b"\x80\x81\xff")
    for path in (binary, tmp_path, tmp_path / "absent.json"):
        with pytest.raises(FileError):
            read_coco_results(path, size=SIZE)


def test_what_was_written_is_read_again(tmp_path):
    rng = np.random.default_rng(5)
    frames = {
        frame: Detections(
            boxes=[[0, 1, 2, 3], [4, 1, 7.5, 5.25]],
            scores=rng.random(2),
            labels=[47, 44],
            masks=rng.random((2, *SIZE)) < 0.5,
        )
        for frame in (0, 2)
    }
    view = ViewDetections(frames, size=SIZE, source="a test")
    write_coco_results(view, tmp_path / "out.json")
    again = read_coco_results(tmp_path / "out.json", size=SIZE, frame_count=3)
    assert again.frames == (0, 1, 2)
    for frame in (0, 2):
        np.testing.assert_array_equal(again[frame].boxes, view[frame].boxes)
        np.testing.assert_array_equal(again[frame].scores, view[frame].scores)
        np.testing.assert_array_equal(again[frame].labels, view[frame].labels)
        np.testing.assert_array_equal(again[frame].masks, view[frame].masks)


def test_a_folder_that_cannot_be_is_an_error_on_writing(tmp_path):
    view = ViewDetections({}, size=SIZE, source="a test")
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(CorsmalError, match="cannot be written"):
        write_coco_results(view, tmp_path / "file" / "out.json")


@pytest.mark.parametrize("view", ["view1", "view2", "view3"])
def test_the_real_recording_has_one_cup_in_every_frame(real_dataset_root, view):
    path = real_dataset_root / view / "detections" / "000618.json"
    found = read_coco_results(path, size=(720, 1280), frame_count=77)
    assert found.frames == tuple(range(77))
    assert found.problems == ()
    for detections in found.values():
        assert detections.labels.tolist() == [47]
        x_min, y_min, x_max, y_max = detections.boxes[0]
        rows, columns = np.nonzero(detections.mask(0))
        assert detections.mask_areas[0] == len(rows)
        assert (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1) == (x_min, y_min, x_max, y_max)
