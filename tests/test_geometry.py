import cv2
import numpy as np
import pytest

from corsmal.errors import ArgumentError, CorsmalError
from corsmal.geometry import Camera, parallax_deg, triangulate

INTRINSIC = np.array([[900.0, 0, 640], [0, 905, 360], [0, 0, 1]])


def camera_at(centre_m, *, angle=0.3, size=(1280, 720)):
    rotation = cv2.Rodrigues(np.array([0.1, angle, -0.2]))[0]
    return Camera(INTRINSIC, rotation, -rotation @ np.array(centre_m), size)


def test_projection_by_hand():
    camera = Camera(INTRINSIC, np.eye(3), np.array([0, 0, 2.0]), (1280, 720))
    np.testing.assert_allclose(camera.project([[0.1, -0.2, 0.0]]), [[640 + 900 * 0.05, 360 - 905 * 0.1]])


def test_projection_is_opencv_s():
    camera = camera_at((0.3, -0.1, -2.0))
    points = np.random.default_rng(0).uniform(-0.3, 0.3, (20, 3))
    rotation = cv2.Rodrigues(camera.rotation)[0]
    expected = cv2.projectPoints(points, rotation, camera.translation, camera.intrinsic, None)[0][:, 0]
    np.testing.assert_allclose(camera.project(points), expected, atol=1e-9)


def test_points_behind_the_camera_have_no_pixel():
    camera = camera_at((0, 0, -2.0))
    behind = camera.centre_m - camera.rotation[2]
    assert np.isnan(camera.project([behind])).all()


def test_triangulation_undoes_projection():
    cameras = [camera_at((0.3, -0.1, -2.0)), camera_at((-0.5, 0.2, -1.8), angle=-0.1), camera_at((0, 0.4, -2.2))]
    point = np.array([0.05, -0.1, 0.2])
    for chosen in (cameras[:2], cameras):
        pixels = [camera.project(point[None])[0] for camera in chosen]
        np.testing.assert_allclose(triangulate(chosen, pixels), point, atol=1e-9)
        pair = cv2.triangulatePoints(
            cameras[0].projection, cameras[1].projection, pixels[0].reshape(2, 1), pixels[1].reshape(2, 1)
        )
        np.testing.assert_allclose(triangulate(chosen, pixels), (pair[:3] / pair[3])[:, 0], atol=1e-6)


def test_parallax_is_the_angle_between_the_rays():
    cameras = [Camera(INTRINSIC, np.eye(3), -np.array(centre), (1280, 720)) for centre in ([1.0, 0, 0], [0, 1.0, 0])]
    assert parallax_deg(cameras, np.zeros(3)) == pytest.approx(90)
    assert parallax_deg([cameras[0], cameras[0]], np.zeros(3)) == pytest.approx(0, abs=1e-5)
    assert parallax_deg(cameras, cameras[0].centre_m) == 0


def test_a_scaled_camera_sees_the_same_point_at_the_scaled_pixel():
    camera = camera_at((0.3, -0.1, -2.0))
    x, y = camera.project([[0.1, 0.1, 0.1]])[0]
    half = camera.scaled((640, 360))
    np.testing.assert_allclose(half.project([[0.1, 0.1, 0.1]])[0], ((x + 0.5) / 2 - 0.5, (y + 0.5) / 2 - 0.5))
    assert half.size == (640, 360)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"intrinsic": np.eye(4)}, "intrinsic must have shape (3, 3)"),
        ({"intrinsic": -np.eye(3)}, "positive focal lengths"),
        ({"rotation": 2 * np.eye(3)}, "rotation matrix"),
        ({"rotation": np.diag([1.0, 1.0, -1.0])}, "rotation matrix"),
        ({"rotation": np.full((3, 3), np.nan)}, "rotation must be finite"),
        ({"translation": [1, 2]}, "translation must have shape (3,)"),
        ({"translation": [1, 2, np.inf]}, "translation must be finite"),
        ({"size": (0, 720)}, "size"),
    ],
)
def test_impossible_cameras_are_refused(changes, message):
    values = {"intrinsic": INTRINSIC, "rotation": np.eye(3), "translation": np.zeros(3), "size": (1280, 720)}
    with pytest.raises(ArgumentError) as raised:
        Camera(**(values | changes))
    assert message in str(raised.value)
    assert isinstance(raised.value, CorsmalError)


def test_wrong_points_are_refused():
    camera = camera_at((0, 0, -2.0))
    with pytest.raises(ArgumentError, match=r"\(n, 3\)"):
        camera.project([1, 2, 3])
    with pytest.raises(ArgumentError, match="at least two cameras"):
        triangulate([camera], [[1, 2]])
    with pytest.raises(ArgumentError, match="finite"):
        triangulate([camera, camera], [[1, 2], [np.nan, 2]])
