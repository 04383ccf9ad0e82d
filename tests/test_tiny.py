from pathlib import Path

import cv2
import numpy as np
import pytest
from pycocotools import mask as coco_mask

from corsmal.dataset import open_dataset
from tests.tiny import CONTAINERS, FRAMES, base_in_frame, detections_of, silhouette, tiny_cameras


def test_silhouette_is_where_points_of_the_solid_project() -> None:
    rng = np.random.default_rng(0)
    heights_mm, radii_mm = np.array([0.0, 40, 50, 120]), np.array([30.0, 45, 20, 50])
    height = rng.uniform(0, 120, 400_000)
    radius = np.interp(height, heights_mm, radii_mm) * np.sqrt(rng.uniform(0, 1, len(height)))
    angle = rng.uniform(0, 2 * np.pi, len(height))
    points_m = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height]) / 1000 + (0.02, 0.1, 0.03)
    for camera in tiny_cameras().values():
        mask = silhouette(camera, (heights_mm, radii_mm), (0.02, 0.1, 0.03))
        x, y = np.round(camera.project(points_m)).astype(int).T
        hit = np.zeros_like(mask)
        hit[y, x] = True
        border = cv2.dilate(mask.astype(np.uint8), np.ones((3, 3))).astype(bool)
        assert not (hit & ~border).any()
        assert not (mask & ~hit).any()


def test_videos_show_the_silhouettes_that_the_detections_hold(tiny_dataset_root: Path) -> None:
    recording = open_dataset(tiny_dataset_root)["000000"]
    for name, view in recording.views.items():
        with view.video() as video:
            assert video.frame_count == FRAMES
            for frame in (0, FRAMES - 1):
                mask = silhouette(view.camera(), CONTAINERS[0].profile, base_in_frame(CONTAINERS[0], frame))
                red, green, _ = np.moveaxis(video[frame].astype(int), -1, 0)
                is_red = red - green > 45
                assert (is_red & mask).sum() > 0.85 * (is_red | mask).sum(), name


@pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")  # pycocotools under NumPy 2
def test_detections_hold_a_container_a_decoy_and_sometimes_a_second_object() -> None:
    camera = tiny_cameras()["view3"]
    masks = [silhouette(camera, CONTAINERS[0].profile, base_in_frame(CONTAINERS[0], frame)) for frame in range(4)]
    results = detections_of(masks)
    assert [result["image_id"] for result in results] == [0, 0, 1, 1, 2, 2, 3, 3, 3]
    for frame, mask in enumerate(masks):
        np.testing.assert_array_equal(coco_mask.decode(results[2 * frame]["segmentation"]).astype(bool), mask)
