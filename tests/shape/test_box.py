"""How far boxes reach in pictures, by their corners one by one."""

import numpy as np

from corsmal.shape import Hull, circumference_points
from corsmal.shape.box_kernels import reach_errors
from tests.tiny import tiny_cameras


def test_a_box_reaches_as_far_as_the_farthest_of_its_corners():
    cameras = [tiny_cameras((1280, 720))[view] for view in ("view3", "view1", "view2")]
    angles = np.arange(7) * (2 * np.pi / 7)
    directions = np.column_stack([np.cos(angles), np.sin(angles)])
    reach_px = np.random.default_rng(2).uniform(100, 900, (3, 7))
    boxes = np.array([[0.01, -0.02, 0.1, 0.12, 0.06, 0.2, 0.5, 0.1, -0.05], [0, 0, 0.08, 0.05, 0.09, 0.1, -1.2, 0, 0]])
    found = reach_errors(boxes, np.array([camera.projection for camera in cameras]), directions, reach_px)
    for box, errors in zip(boxes, found.reshape(2, 3, 7), strict=True):
        direction = np.array([box[7], box[8], 1.0])
        hull = Hull(
            1000 * box[2] + 1000 * np.array([-box[5] / 2, box[5] / 2]),
            np.full(2, 500 * box[3]),
            np.ones(2, dtype=bool),
            box[:3],
            direction=direction / np.linalg.norm(direction),
            depth_mm=1000 * box[4],
            yaw=box[6],
        )
        corners = circumference_points(hull, points=4).reshape(-1, 3)
        for camera, error, reach in zip(cameras, errors, reach_px, strict=True):
            farthest = [max(float(direction @ pixel) for pixel in camera.project(corners)) for direction in directions]
            np.testing.assert_allclose(error, np.array(farthest) - reach, atol=1e-6)
