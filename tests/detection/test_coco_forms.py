"""Files of detections as other programs write them, each with a solid rectangle as the container."""

import json
import time

import numpy as np
import pytest

from corsmal.detection import coco, read_coco_results
from corsmal.detection.coco_classes import CLASS_NAMES, CONSECUTIVE, class_number
from corsmal.errors import FileError
from corsmal.notes import flags_of

HEIGHT, WIDTH, FRAMES = 36, 64, 6
SIZE = (HEIGHT, WIDTH)
INTERPRETED = ("detections-interpreted",)
POLYGON = [20.0, 10.0, 30.0, 10.0, 30.0, 25.0, 20.0, 25.0]
BOX = [20.0, 10.0, 10.0, 15.0]
RUNS = {"size": [36, 64], "counts": [20 * 36 + 10, *[15, 21] * 9, 15, 11 + 34 * 36]}


def read(folder, content, *, frame_count=FRAMES):
    path = folder / "000001.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return read_coco_results(path, size=SIZE, frame_count=frame_count)


def entry(frame, **more):
    return {"image_id": frame, "category_id": 47, "score": 0.9, "bbox": BOX, "segmentation": RUNS} | more


def cups(view):
    """Frames with a cup that covers the rectangle, the score of the first of them."""
    found = [frame for frame in view if 47 in view[frame].labels]
    expected = np.zeros(SIZE, dtype=bool)
    expected[10:25, 20:30] = True
    for frame in found:
        mask = view[frame].mask(view[frame].labels.tolist().index(47))
        assert (mask != expected).sum() <= 15, "at most a border of one pixel differs"
    return found, view[found[0]].scores[0] if found else None


CVAT = {
    "licenses": [{"name": "", "id": 0, "url": ""}],
    "info": {"contributor": "", "date_created": "", "description": "", "url": "", "version": "", "year": ""},
    "categories": [{"id": 1, "name": "hand", "supercategory": ""}, {"id": 2, "name": "cup", "supercategory": ""}],
    "images": [
        {"id": frame + 1, "width": WIDTH, "height": HEIGHT, "file_name": f"frame_{frame:06d}.PNG", "license": 0}
        for frame in range(FRAMES)
    ],
    "annotations": [
        {
            "id": 1,
            "image_id": 3,
            "category_id": 2,
            "segmentation": [POLYGON, [5.0, 5.0, 6.0, 6.0]],
            "area": 150.0,
            "bbox": BOX,
            "iscrowd": 0,
            "attributes": {"occluded": False, "track_id": 0, "keyframe": True},
        },
        {"id": 2, "image_id": 4, "category_id": 2, "segmentation": RUNS, "area": 150, "bbox": BOX, "iscrowd": 1},
    ],
}
LABEL_STUDIO = {
    "images": [
        {"width": WIDTH, "height": HEIGHT, "id": place, "file_name": f"images/1f9d3a7{place}-frame_{frame:04d}.png"}
        for place, frame in enumerate((2, 4))
    ],
    "categories": [{"id": 0, "name": "Cup"}],
    "annotations": [
        {
            "id": 0,
            "image_id": 1,
            "category_id": 0,
            "segmentation": [POLYGON],
            "bbox": BOX,
            "ignore": 0,
            "iscrowd": 0,
            "area": 150,
        }
    ],
    "info": {"year": 2026, "version": "1.0", "description": "", "contributor": "Label Studio", "url": ""},
}
FIFTYONE = {
    "info": {"year": "", "version": "", "description": "", "contributor": "", "url": "", "date_created": ""},
    "licenses": [],
    "categories": [{"id": 0, "name": "cup", "supercategory": None}],
    "images": [
        {"id": frame + 1, "file_name": f"{frame + 1:06d}.jpg", "height": HEIGHT, "width": WIDTH, "license": None}
        for frame in range(FRAMES)
    ],
    "annotations": [
        {
            "id": 1,
            "image_id": 5,
            "category_id": 0,
            "bbox": BOX,
            "segmentation": [POLYGON],
            "score": 0.75,
            "area": 150,
            "iscrowd": 0,
        }
    ],
}
ROBOFLOW = {
    "info": {"year": "2026", "version": "1", "description": "Exported from roboflow.com", "contributor": ""},
    "licenses": [{"id": 1, "url": "", "name": "Private"}],
    "categories": [
        {"id": 0, "name": "vessels", "supercategory": "none"},
        {"id": 1, "name": "cup", "supercategory": "vessels"},
    ],
    "images": [
        {
            "id": place,
            "license": 1,
            "file_name": f"frame_{frame:04d}_jpg.rf.9f8e7d6c5b4a39281706f5e4d3c2b1a{place}.jpg",
            "height": 2 * HEIGHT,
            "width": 2 * WIDTH,
            "extra": {"name": f"frame_{frame:04d}.jpg"},
        }
        for place, frame in enumerate((4, 1))
    ],
    "annotations": [
        {
            "id": 0,
            "image_id": 0,
            "category_id": 1,
            "bbox": [2 * value for value in BOX],
            "area": 600,
            "segmentation": [[2 * value for value in POLYGON]],
            "iscrowd": 0,
        }
    ],
}
DETECTRON2 = [
    {"image_id": "000001_4", "category_id": 41, "bbox": BOX, "score": 0.98, "segmentation": RUNS},
    {"image_id": "000001_4", "category_id": 0, "bbox": BOX, "score": 0.97, "segmentation": RUNS},
]
ULTRALYTICS = [
    {
        "image_id": "frame_5",
        "file_name": "frame_5.jpg",
        "category_id": 47,
        "bbox": BOX,
        "score": 0.88123,
        "segmentation": RUNS,
    }
]
ULTRALYTICS_RESULTS = [
    [],
    [
        {
            "name": "cup",
            "class": 41,
            "confidence": 0.91,
            "box": {"x1": 20.0, "y1": 10.0, "x2": 30.0, "y2": 25.0},
            "segments": {"x": [20.0, 30.0, 30.0, 20.0], "y": [10.0, 10.0, 25.0, 25.0]},
        }
    ],
    *[[]] * 4,
]
FORMS = {
    "CVAT": (CVAT, [2, 3], 1.0),
    "Label Studio": (LABEL_STUDIO, [4], 1.0),
    "FiftyOne": (FIFTYONE, [4], 0.75),
    "Roboflow": (ROBOFLOW, [4], 1.0),
    "Detectron2": (DETECTRON2, [4], 0.98),
    "Ultralytics": (ULTRALYTICS, [5], 0.88123),
    "Ultralytics, results": (ULTRALYTICS_RESULTS, [1], 0.91),
}


@pytest.mark.parametrize("program", FORMS)
def test_an_export_opens_as_it_is(tmp_path, program):
    content, frames, score = FORMS[program]
    view = read(tmp_path, content)
    assert view.frames == tuple(range(FRAMES))
    assert cups(view) == (frames, score)
    assert "detections-interpreted" in flags_of(view.problems)


def test_the_notes_of_an_export_name_every_reading(tmp_path):
    said = read(tmp_path, CVAT).problems
    assert said == (
        "a dictionary of 6 images: the last number of a picture's name was read as the frame",
        "classes were read by name: cup is 47 (cup)",
        "there are no scores: the file was read as ground truth, each with a score of 1",
        "1 of the polygons left out: a polygon of the mask is not a list of three or more points [x0, y0, x1, y1, ...]",
    )
    assert flags_of(said) == ("detections-interpreted", "detections-incomplete")
    said = read(tmp_path, ROBOFLOW).problems
    assert "outlines were drawn in pictures of another size and scaled to 64x36" in said
    said = read(tmp_path, FIFTYONE).problems
    assert "frames are counted from 1 (up to 6) and were read as counted from 0" in said


@pytest.mark.parametrize("write", [str, float, "frame_{:04d}.png".format, "000001_{}".format, " {} ".format])
def test_frames_are_read_however_they_are_written(tmp_path, write):
    view = read(tmp_path, [entry(write(0)), entry(write(5))])
    assert cups(view)[0] == [0, 5]
    assert flags_of(view.problems) == INTERPRETED


def test_frames_are_counted_from_1_only_where_nothing_else_is_possible(tmp_path):
    assert cups(read(tmp_path, [entry(frame) for frame in range(1, 7)]))[0] == [0, 1, 2, 3, 4, 5]
    assert cups(read(tmp_path, [entry(frame) for frame in (3, 6)]))[0] == [2, 5]
    for frames in ([1, 5], [0, 5]):
        view = read(tmp_path, [entry(frame) for frame in frames])
        assert cups(view)[0] == frames
        assert view.problems == ()
    view = read(tmp_path, [entry(frame) for frame in (0, 6)])
    assert cups(view)[0] == [0]
    assert view.problems == ("1 entry skipped: frame (image_id) out of range, expected from 0 to 5",)


@pytest.mark.parametrize(
    ("category", "others", "label"),
    [("47", (), 47), (47.0, (), 47), ("Wine-Glass", (), 46), (39, (0,), 44), (75, (0, 56), 86)],
)
def test_classes_are_read_however_they_are_written(tmp_path, category, others, label):
    view = read(tmp_path, [entry(0, category_id=category), *(entry(1, category_id=other) for other in others)])
    assert view[0].labels.tolist() == [label]
    assert flags_of(view.problems) == INTERPRETED


def test_negative_classes_are_no_yolo_classes(tmp_path):
    view = read(tmp_path, [entry(0), entry(1, category_id=0), entry(2, category_id=-200)])
    assert cups(view)[0] == [0]
    assert view.problems == ("2 entries skipped: unknown class, COCO's numbers are 1 to 90",)


@pytest.mark.parametrize(
    ("number", "name", "first"), [(41, "skateboard", 0), (42, "surfboard", 1), (40, "baseball", 0)]
)
def test_classes_of_which_none_is_a_container_are_named(tmp_path, number, name, first):
    [said] = read(tmp_path, [entry(0, category_id=number), entry(1, category_id=number)]).problems
    assert f"it holds class {number} ({name}" in said
    assert said.startswith("no class in it is a container (44 (bottle), 46 (wine glass), 47 (cup), ")
    assert f"counted without gaps from {first}, as YOLO's are, {number} is " in said
    assert flags_of([said]) == ("detections-incomplete",)


def test_the_numbers_of_classes_are_cocos():
    assert (len(CLASS_NAMES), CLASS_NAMES[1], CLASS_NAMES[90]) == (80, "person", "toothbrush")
    assert [CONSECUTIVE[place] for place in (39, 40, 41, 73, 75)] == [44, 46, 47, 84, 86]
    assert [class_number(name) for name in ("Cups", "wine_glass", "mug", "thing")] == [47, 46, 47, None]


def test_names_that_are_no_class_are_told_apart_from_a_single_one(tmp_path):
    content = {"annotations": [entry(1), entry(2)], "categories": [{"id": 47, "name": "my thing"}]}
    view = read(tmp_path, content)
    assert cups(view)[0] == [1, 2]
    assert "its only class, 'my thing', was taken for a cup" in view.problems
    content["annotations"].append(entry(3, category_id=5))
    content["categories"].append({"id": 5, "name": "robot"})
    with pytest.raises(FileError, match="2 entries skipped: the class 'my thing' is none of COCO's"):
        read(tmp_path, content)


PAIRS = [[[20, 10], [30, 10], [30, 25], [20, 25]]]
SHARES = [[value / (WIDTH, HEIGHT)[place % 2] for place, value in enumerate(POLYGON)]]
SHARE_BOX = [20 / WIDTH, 10 / HEIGHT, 10 / WIDTH, 15 / HEIGHT]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ([entry(2, score="0.9")], "scores are written as text"),
        ([entry(2, score=" 0,9 ")], "scores are written as text"),
        ([entry(2, score=90), entry(3, score=89.5)], "scores are written in percent"),
        ([entry(2, segmentation=PAIRS)], "points of outlines are written as pairs"),
        ([entry(2, segmentation=SHARES, bbox=SHARE_BOX)], "written as shares of the image's width and height"),
        ([entry(2, bbox=[20, 10, 30, 25])], "boxes were written as two corners"),
        ([{"image_id": 2, "category_name": "cup", "score": 0.9, "segmentation": RUNS}], "COCO's number or name"),
        ({"results": [entry(2)]}, ""),
        ({"predictions": [entry("frame_0002_1280x720.jpg")]}, "the last number in it was read as the frame"),
        (
            {
                "images": [{"id": 70 + i, "file_name": "x.png", "frame": i} for i in range(6)],
                "annotations": [entry(72)],
            },
            "the number that a picture has as its frame was read as the frame",
        ),
        (
            {
                "images": [{"id": 70 + i, "file_name": f"000618_{i:04d}_small2.png"} for i in range(6)],
                "annotations": [entry(72)],
            },
            "the number 2 from the end of a picture's name was read as the frame",
        ),
        (
            {
                "images": [{"id": 70 + i, "file_name": f"f_{i}.png", "width": 640, "height": 360} for i in range(6)],
                "annotations": [entry(72, segmentation=SHARES, bbox=SHARE_BOX)],
            },
            "written as shares",
        ),
    ],
)
def test_other_keys_scores_outlines_and_boxes_have_one_reading(tmp_path, content, said):
    view = read(tmp_path, content)
    frames, score = cups(view)
    assert (frames[0], score) == (2, pytest.approx(0.9))
    np.testing.assert_allclose(view[2].boxes[0], [20, 10, 30, 25])
    assert any(said in problem for problem in view.problems) if said else view.problems == ()


def test_a_few_scores_above_1_are_no_percentages(tmp_path):
    view = read(tmp_path, [entry(0), entry(1, score=1.0000001), entry(2, score=1.5)])
    assert cups(view)[0] == [0, 1]
    assert view[1].scores[0] == 1.0
    assert view.problems == ("1 entry skipped: the score is no number from 0 to 1",)


def test_a_bad_outline_among_good_ones_costs_only_itself(tmp_path):
    bad = [[1.0, 1.0], [], ["a"] * 6, [1, 2, 3, 4, 5, 1e9]]
    view = read(tmp_path, [entry(0, segmentation=[POLYGON, *bad]), entry(1, segmentation=POLYGON)])
    assert cups(view)[0] == [0, 1]
    assert [said.split(" of ")[0] for said in view.problems] == ["3", "1"]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"images": [{"id": "a", "file_name": "cup.png"}], "annotations": [entry(0)]}, "gives no frames"),
        ({"images": [{"id": 1}, {"id": 1}], "annotations": [entry(0)]}, "gives no frames"),
        ({"images": [{"id": 80}], "annotations": [entry(80)]}, "a number of its own up to 5"),
        ({"images": [{"id": 0}], "annotations": [entry(3)]}, "an image that is not listed"),
        ({"shapes": []}, "a JSON dict without 'annotations'"),
    ],
)
def test_what_has_no_sensible_reading_is_refused_in_one_sentence(tmp_path, content, message):
    with pytest.raises(FileError, match=message) as caught:
        read(tmp_path, content)
    assert "\n" not in str(caught.value)


def test_what_a_file_may_cost_is_bounded(tmp_path, monkeypatch):
    began_s = time.perf_counter()
    rng = np.random.default_rng(0)
    wild = (rng.random((16_000, 2)) * (WIDTH, HEIGHT)).ravel().tolist()
    fan = [[0, 0, WIDTH, 0, 0, 1]] * 1001
    many = [entry(2, segmentation=RUNS)] * 1003
    view = read(tmp_path, [entry(0, segmentation=[wild]), entry(1, segmentation=fan), *many])
    assert len(view[2]) == 1000
    assert [said.partition(": ")[2] for said in view.problems] == [
        "the mask's outlines are longer than 50 times the image's width and height",
        "the mask has more than 1000 polygons, write run lengths instead",
        "a frame has more than 1000 detections, the first were read",
    ]
    for item, count in (("{}", 1_000_001), ("[]", 5_000_001), ("1", 20_000_002)):
        with pytest.raises(FileError, match="too large for the detections of one view; it was not read"):
            read(tmp_path, f"[{','.join([item] * count)}]")
    monkeypatch.setattr(coco, "BYTES_MAX", 1000)
    with pytest.raises(FileError, match="too large for the detections of one view"):
        read(tmp_path, " " * 1001)
    assert time.perf_counter() - began_s < 5, "bounded work"


def test_an_outline_of_many_short_steps_is_read(tmp_path):
    steps = np.linspace(0, 2 * np.pi, 20_000, endpoint=False)
    circle = np.column_stack([32 + 10 * np.cos(steps), 18 + 10 * np.sin(steps)]).ravel().tolist()
    view = read(tmp_path, [entry(0, segmentation=[circle])])
    assert view[0].mask_areas[0] == pytest.approx(np.pi * 100, rel=0.03)
    assert view.problems == ()
