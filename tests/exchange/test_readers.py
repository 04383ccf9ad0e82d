"""What is exported for annotation tools, opened by other programs' own readers."""

import numpy as np
import pytest
from pycocotools.coco import COCO

from corsmal.dataset import open_dataset
from corsmal.exchange import export_detections
from corsmal.stages.detections import load_detections
from corsmal.store import Store

pytestmark = pytest.mark.filterwarnings("ignore:__array__ implementation")  # pycocotools' own
CLASSES = {"bottle", "wine glass", "cup", "book", "vase"}


@pytest.fixture(scope="module")
def exported(tiny_dataset_root, tmp_path_factory):
    """A recording's detections in view1, and where they were written with its frames."""
    folder = tmp_path_factory.mktemp("exported")
    recording = open_dataset(tiny_dataset_root)["000000"]
    views = load_detections(recording, store=Store(folder / "cache")).views
    export_detections(recording, views, folder, form="cvat", with_frames=True)
    return views["view1"], folder / "view1"


def overlap(first, second):
    """Intersection over union of two masks."""
    return (first & second).sum() / (first | second).sum()


def test_pycocotools_reads_masks_boxes_and_classes(exported):
    view, folder = exported
    read = COCO(folder / "cvat" / "000000.json")
    assert {entry["name"] for entry in read.cats.values()} <= CLASSES
    assert [entry["file_name"] for entry in read.imgs.values()] == [f"frame_{frame:06d}.jpg" for frame in view]
    compared = 0
    for frame, detections in view.items():
        entries = read.loadAnns(read.getAnnIds(imgIds=frame + 1))
        assert [entry["category_id"] for entry in entries] == detections.labels.tolist()
        for index, entry in enumerate(entries):
            left, top, width, height = entry["bbox"]
            np.testing.assert_allclose([left, top, left + width, top + height], detections.boxes[index])
            assert overlap(read.annToMask(entry).astype(bool), detections.mask(index)) > 0.95
            compared += 1
    assert compared > 0


def test_supervision_reads_it_as_a_dataset_with_its_pictures(exported):
    supervision = pytest.importorskip("supervision", reason="is installed by .ci/run")
    view, folder = exported
    read = supervision.DetectionDataset.from_coco(
        images_directory_path=str(folder / "frames" / "000000"),
        annotations_path=str(folder / "cvat" / "000000.json"),
        force_masks=True,
    )
    assert set(read.classes) <= CLASSES
    assert len(read) == len(view)
    compared = 0
    for path, picture, found in read:
        detections = view[int(path.rpartition("_")[2].removesuffix(".jpg"))]
        assert picture.shape[:2] == view.size
        assert len(found) == len(detections)
        for index in range(len(found)):
            assert overlap(found.mask[index], detections.mask(index)) > 0.85  # outlines are rounded to pixels
            compared += 1
    assert compared > 0
