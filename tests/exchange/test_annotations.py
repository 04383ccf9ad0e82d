import json

import cv2
import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.detection import Detections, ViewDetections, read_coco_results
from corsmal.errors import ArgumentError
from corsmal.exchange import export_detections
from corsmal.exchange.annotations import polygons
from corsmal.stages.detections import load_detections

SIZE = (120, 200)


def ellipse(centre, axes):
    picture = np.zeros(SIZE, dtype=np.uint8)
    cv2.ellipse(picture, centre, axes, 0, 0, 360, 1, -1)
    return picture.astype(bool)


@pytest.fixture
def views():
    """One view: two detections in frame 3, none in frame 4."""
    masks = np.stack([ellipse((60, 60), (30, 40)), ellipse((150, 50), (20, 15))])
    boxes = [[30, 20, 91, 101], [130, 35, 171, 66]]
    found = Detections(boxes=boxes, scores=[0.9, 0.25], labels=[47, 84], masks=masks)
    nothing = Detections(boxes=[], scores=[], labels=[], masks=np.empty((0, *SIZE), dtype=bool))
    return {"view1": ViewDetections({3: found, 4: nothing}, size=SIZE, source="test")}


@pytest.fixture
def recording(tiny_dataset_root):
    return open_dataset(tiny_dataset_root)["000000"]


@pytest.mark.parametrize(("form", "folder"), [("coco", "detections"), ("cvat", "cvat")])
def test_what_is_written_is_read_again(form, folder, recording, views, tmp_path):
    [path] = export_detections(recording, views, tmp_path, form=form)
    assert path == tmp_path / "view1" / folder / "000000.json"
    found = read_coco_results(path, size=SIZE, frame_count=5)[3]
    wanted = views["view1"][3]
    np.testing.assert_allclose(found.boxes, wanted.boxes)
    np.testing.assert_allclose(found.scores, wanted.scores)
    np.testing.assert_array_equal(found.labels, wanted.labels)
    np.testing.assert_array_equal(found.masks, wanted.masks)


def test_instances_name_pictures_and_classes(recording, views, tmp_path):
    [path] = export_detections(recording, views, tmp_path, form="cvat")
    content = json.loads(path.read_text(encoding="utf-8"))
    assert [image["file_name"] for image in content["images"]] == ["frame_000003.jpg", "frame_000004.jpg"]
    assert content["categories"] == [{"id": 47, "name": "cup"}, {"id": 84, "name": "book"}]
    first = content["annotations"][0]
    assert (first["image_id"], first["bbox"]) == (content["images"][0]["id"], [30, 20, 61, 81])
    assert first["area"] == ellipse((60, 60), (30, 40)).sum()


def test_tasks_are_in_percent_of_the_picture(recording, tmp_path):
    mask = np.zeros((1, *SIZE), dtype=bool)
    mask[0, 30:61, 50:101] = True
    found = Detections(boxes=[[50, 30, 101, 61]], scores=[0.5], labels=[47], masks=mask)
    views = {"view3": ViewDetections({0: found, 1: found[:0]}, size=SIZE, source="by hand")}
    [path] = export_detections(recording, views, tmp_path, form="label-studio")
    first, second = json.loads(path.read_text(encoding="utf-8"))
    [prediction] = first["predictions"]
    assert prediction["model_version"] == "by hand"
    [region] = prediction["result"]
    assert region["value"]["polygonlabels"] == ["cup"]
    corners = sorted(tuple(point) for point in region["value"]["points"])
    left, right, top, bottom = 50.25 / 2, 100.75 / 2, 30.25 / 1.2, 60.75 / 1.2
    np.testing.assert_allclose(corners, [(left, top), (left, bottom), (right, top), (right, bottom)])
    assert second["predictions"][0]["result"] == []


def test_every_piece_has_its_polygon():
    mask = ellipse((60, 60), (30, 40))
    mask[5, 7] = mask[5, 150:152] = True
    assert sorted(map(len, polygons(mask)))[:2] == [4, 4]
    assert polygons(np.zeros(SIZE, dtype=bool)) == []
    [single] = polygons(np.eye(1, 3, 1, dtype=bool))
    assert (single.min(axis=0).tolist(), single.max(axis=0).tolist()) == ([1.25, 0.25], [1.75, 0.75])


def test_frames_are_written_beside(recording, store, tmp_path):
    views = load_detections(recording, store=store).views
    export_detections(recording, {"view1": views["view1"]}, tmp_path, with_frames=True)
    pictures = sorted((tmp_path / "view1" / "frames" / "000000").iterdir())
    assert [path.name for path in pictures] == [f"frame_{frame:06d}.jpg" for frame in views["view1"]]
    shown = cv2.cvtColor(cv2.imread(str(pictures[0])), cv2.COLOR_BGR2RGB).astype(int)
    with recording.video("view1") as video:
        assert np.abs(shown - video[0].astype(int)).mean() < 5


def test_another_form_is_refused(recording, views, tmp_path):
    with pytest.raises(ArgumentError, match="form"):
        export_detections(recording, views, tmp_path, form="yolo")
