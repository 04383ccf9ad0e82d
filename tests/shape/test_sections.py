import itertools

import cv2
import numpy as np
import pytest

from corsmal.errors import ArgumentError
from corsmal.geometry import Camera
from corsmal.shape import Hull, agreement, circumference_points, silhouettes

LEVEL = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
"""Rotation of a camera that looks along the y axis."""


def test_agreement_counts_what_the_silhouette_covers_and_what_lies_beyond() -> None:
    mask, silhouette = np.zeros((20, 30), dtype=bool), np.zeros((20, 30), dtype=bool)
    mask[5:10, 10:20] = True  # 50 pixels
    silhouette[5:10, 12:24] = True  # 60, of which 40 lie in the mask
    found = agreement(silhouette, mask)
    assert (found.both, found.mask, found.silhouette) == (40, 50, 60)
    assert found.explained == 0.8
    assert found.beyond == 0.4
    assert found.overlap == 40 / 70
    assert agreement(mask, mask).overlap == 1
    assert agreement(np.zeros_like(mask), mask).explained == 0


def test_agreement_with_an_empty_mask_is_refused() -> None:
    with pytest.raises(ArgumentError, match="must have a pixel"):
        agreement(np.ones((4, 4), dtype=bool), np.zeros((4, 4), dtype=bool))


def test_hull_without_circumferences_has_empty_silhouettes() -> None:
    nothing = np.zeros(3, dtype=bool)
    hull = Hull(np.arange(3.0), np.ones(3), nothing, np.array([0.0, 0.0, 1.0]))
    camera = Camera(np.diag([500.0, 500.0, 1.0]), np.eye(3), np.zeros(3), (64, 48))
    [seen] = silhouettes(hull, [camera])
    assert seen.shape == (48, 64)
    assert not seen.any()


@pytest.mark.parametrize("x_m", [-0.32, -0.2, 0.0, 0.2, 0.31, 0.6])
@pytest.mark.parametrize("depth_mm", [None, 90.0])
def test_silhouettes_are_the_hulls_of_neighbouring_circumferences(x_m: float, depth_mm: float | None) -> None:
    """Also where they reach beyond the picture, painted in all of it."""
    heights, radii = np.linspace(400, 560, 30), np.linspace(50, 80, 30)
    if depth_mm is not None:
        radii = np.full(30, 70.0)
    hull = Hull(heights, radii, np.ones(30, dtype=bool), np.array([x_m, 0.02, 0.5]), depth_mm=depth_mm, yaw=0.4)
    camera = Camera(np.array([[500.0, 0, 160], [0, 500, 90], [0, 0, 1]]), LEVEL, np.array([0.0, 0.5, 0.9]), (320, 180))
    rings = circumference_points(hull, points=24)[[0, -1] if depth_mm else slice(None)]
    expected = np.zeros((180, 320), np.uint8)
    for pair in itertools.pairwise(rings):
        outline = cv2.convexHull(camera.project(np.concatenate(pair)).astype(np.float32))
        cv2.fillConvexPoly(expected, np.rint(outline * 16).astype(np.int32), 1, shift=4)
    [seen] = silhouettes(hull, [camera])
    assert expected.any() == (x_m < 0.6)
    np.testing.assert_array_equal(seen, expected.astype(bool))


def test_what_lies_behind_a_camera_is_not_seen() -> None:
    hull = Hull(np.linspace(400, 560, 30), np.full(30, 20.0), np.ones(30, dtype=bool), np.array([0.0, 0.0, 0.5]))
    upwards = Camera(
        np.array([[300.0, 0, 160], [0, 300, 90], [0, 0, 1]]), np.eye(3), np.array([0, 0, -0.45]), (320, 180)
    )
    [seen] = silhouettes(hull, [upwards])
    assert seen[90, 160]
    assert seen.all()  # the camera stands inside of it
    [seen] = silhouettes(hull, [Camera(upwards.intrinsic, np.eye(3), np.array([0, 0, -0.6]), (320, 180))])
    assert not seen.any()
