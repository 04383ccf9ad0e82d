import pickle
import subprocess
import sys

import numpy as np
import pytest

from corsmal.detection import Detections, ViewDetections
from corsmal.detection.parquet import read_parquet, write_parquet
from corsmal.errors import ArgumentError, FileError, NotFoundError

SIZE = (9, 12)


def some_detections():
    masks = np.zeros((3, *SIZE), dtype=bool)
    masks[0, 2:5, 3:7] = True
    masks[1, 8, 11] = True
    return Detections(
        boxes=[[3, 2, 7, 5], [11, 8, 12, 9], [-1.5, 0, 4, 4]], scores=[0.9, 0.25, 1.0], labels=[47, 44, 64], masks=masks
    )


def no_detections(size=SIZE):
    return Detections(boxes=[], scores=[], labels=[], masks=np.zeros((0, *size), dtype=bool))


def test_none_detected_is_a_record_that_knows_the_image():
    none = no_detections()
    assert len(none) == 0
    assert none.size == SIZE
    assert none.boxes.shape == (0, 4)
    assert none.masks.shape == (0, *SIZE)
    assert none.mask_areas.shape == none.scores.shape == none.labels.shape == (0,)
    assert none.counts == ()
    assert none.to_coco(0) == []
    assert len(none[[]]) == len(none[:]) == 0


def test_masks_come_back_whole_one_by_one_and_as_areas():
    detections = some_detections()
    masks = detections.masks
    assert masks.dtype == bool
    assert masks[0, 2:5, 3:7].all()
    assert masks[1, 8, 11]
    np.testing.assert_array_equal(masks.sum(axis=(1, 2)), [12, 1, 0])
    np.testing.assert_array_equal(detections.mask_areas, [12, 1, 0])
    np.testing.assert_array_equal(detections.mask(-2), masks[1])
    assert detections.mask(0).flags.c_contiguous


def test_arrays_are_copies_that_cannot_be_changed():
    boxes = np.array([[0.0, 0, 1, 1]])
    detections = Detections(boxes, [0.5], [1], np.ones((1, 2, 2), dtype=bool))
    boxes[:] = 7
    assert detections.boxes.tolist() == [[0, 0, 1, 1]]
    for array in (detections.boxes, detections.scores, detections.labels):
        assert not array.flags.writeable
    with pytest.raises(AttributeError):
        detections.size = (1, 1)


@pytest.mark.parametrize(
    ("index", "labels"),
    [
        ([2, 0], [64, 47]),
        (np.array([-1]), [64]),
        ([False, True, True], [44, 64]),
        (np.zeros(3, dtype=bool), []),
        (slice(1, None), [44, 64]),
        ([], []),
    ],
)
def test_a_selection_keeps_rows_together(index, labels):
    detections = some_detections()
    chosen = detections[index]
    assert chosen.labels.tolist() == labels
    assert chosen.size == SIZE
    for position, label in enumerate(labels):
        original = detections.labels.tolist().index(label)
        np.testing.assert_array_equal(chosen.mask(position), detections.mask(original))
        np.testing.assert_array_equal(chosen.boxes[position], detections.boxes[original])


@pytest.mark.parametrize("index", [0, [3], [0.5], [True], [[0]], "a"])
def test_an_index_that_selects_nothing_sensible_is_an_error(index):
    with pytest.raises(ArgumentError, match="index"):
        some_detections()[index]


def test_a_mask_beyond_the_last_is_an_error():
    with pytest.raises(ArgumentError, match="3 detections, got 3"):
        some_detections().mask(3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"masks": np.zeros((1, 4, 5))}, "masks must be .* bool"),
        ({"masks": np.zeros((4, 5), dtype=bool)}, "masks must be"),
        ({"masks": np.zeros((1, 0, 5), dtype=bool)}, "size must be two positive"),
        ({"masks": np.zeros((2, 4, 5), dtype=bool)}, r"boxes must have shape \(2, 4\)"),
        ({"boxes": [[0, 0, 1]]}, r"boxes must have shape \(1, 4\)"),
        ({"boxes": [[0, 0, 1, np.nan]]}, "boxes must be finite"),
        ({"boxes": [[2, 0, 1, 1]]}, "x_min <= x_max"),
        ({"boxes": [[0, 0, 1], [1]]}, "boxes must be an array of numbers"),
        ({"scores": [0.5, 0.5]}, "scores must have shape"),
        ({"scores": [1.01]}, "scores must lie in 0..1"),
        ({"scores": [np.nan]}, "scores must lie in 0..1"),
        ({"labels": [[47]]}, "labels must have shape"),
        ({"labels": [47.0]}, "labels must be integers"),
        ({"labels": [0]}, "COCO category numbers 1 to 90"),
        ({"labels": [91]}, "COCO category numbers 1 to 90"),
    ],
)
def test_a_wrong_argument_is_named(change, message):
    right = {"boxes": [[0, 0, 1, 1]], "scores": [0.5], "labels": [47], "masks": np.zeros((1, 4, 5), dtype=bool)}
    with pytest.raises(ArgumentError, match=message):
        Detections(**(right | change))


def test_run_lengths_and_coco_entries_give_the_same_record_back():
    detections = some_detections()
    again = Detections.from_counts(
        detections.boxes, detections.scores, detections.labels, detections.counts, size=detections.size
    )
    from_entries = Detections.from_coco(detections.to_coco(5), size=SIZE)
    for other in (again, from_entries):
        np.testing.assert_array_equal(other.boxes, detections.boxes)
        np.testing.assert_array_equal(other.scores, detections.scores)
        np.testing.assert_array_equal(other.labels, detections.labels)
        np.testing.assert_array_equal(other.masks, detections.masks)


def test_a_kept_file_with_broken_run_lengths_is_refused(tmp_path):
    broken = Detections.from_counts([[0, 0, 1, 1]], [0.5], [47], [b"abc"], size=SIZE)
    write_parquet(ViewDetections({0: broken}, size=SIZE, source="a test"), tmp_path / "a.parquet")
    with pytest.raises(FileError, match="is broken: the mask's run lengths"):
        read_parquet(tmp_path / "a.parquet")


def test_a_bad_coco_entry_is_named_by_its_position():
    entries = [*some_detections().to_coco(0), {"category_id": 47}]
    with pytest.raises(ArgumentError, match=r'entries\[3\]: the key "score" is missing'):
        Detections.from_coco(entries, size=SIZE)


def test_coco_entries_hold_plain_numbers_and_text():
    entry = some_detections().to_coco(7)[0]
    assert entry["image_id"] == 7
    assert entry["category_id"] == 47
    assert entry["bbox"] == [3, 2, 4, 3]
    assert entry["score"] == 0.9
    assert entry["segmentation"]["size"] == [9, 12]
    assert isinstance(entry["segmentation"]["counts"], str)


def test_records_travel_between_processes():
    view = ViewDetections({0: some_detections()}, size=SIZE, source="a test")
    again = pickle.loads(pickle.dumps(view))
    np.testing.assert_array_equal(again[0].masks, view[0].masks)
    assert again.source == "a test"


def test_a_view_maps_its_frames_in_order():
    view = ViewDetections({5: some_detections(), 0: no_detections()}, size=SIZE, source="a test", problems=["one"])
    assert view.frames == tuple(view) == (0, 5)
    assert len(view) == 2
    assert len(view[0]) == 0
    assert len(view[5]) == 3
    assert view.problems == ("one",)
    assert 5 in view
    assert 4 not in view
    assert view.get(4) is None


def test_a_frame_that_was_not_inspected_is_an_error():
    view = ViewDetections({0: no_detections()}, size=SIZE, source="file a.json")
    with pytest.raises(NotFoundError) as caught:
        view[3]
    assert str(caught.value) == "frame 3 was not inspected, 1 frames were (file a.json)"


def test_a_view_takes_one_size_and_no_negative_frame():
    with pytest.raises(ArgumentError, match="size"):
        ViewDetections({0: no_detections((4, 5))}, size=SIZE, source="a test")
    with pytest.raises(ArgumentError, match="from 0, got -1"):
        ViewDetections({-1: no_detections()}, size=SIZE, source="a test")


def test_the_record_is_imported_without_torch():
    code = "import sys, corsmal.detection, corsmal.store; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
