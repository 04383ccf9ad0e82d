"""The demo's three cameras, placed much as in the real recordings."""

import numpy as np

from corsmal.geometry import Camera

CALIBRATED_SIZE = (1280, 720)
DEMO_SIZE = (640, 360)
"""Width and height of the demo's videos, in pixels."""

VIEWS = ("view1", "view2", "view3")

# centre (m), target (m)
_PLACES = {
    "view1": ((0.87, 1.36, 0.67), (0.40, 0.12, 0.42)),
    "view2": ((-0.35, 1.35, 0.64), (0.00, 0.07, 0.40)),
    "view3": ((0.30, 0.80, 0.275), (0.26, 0.00, 0.175)),
}
_PLACE_SPREAD_M, _TARGET_SPREAD_M, _ROLL_SPREAD_DEG = 0.022, 0.02, 0.7


def draw_cameras(rng: np.random.Generator, *, spread: float = 1.0) -> dict[str, Camera]:
    """Three cameras, by view, for images of 1280×720 pixels; ``spread`` times as far from their usual places."""
    return {view: _camera(*_PLACES[view], rng=rng, spread=spread) for view in VIEWS}


def _camera(
    centre: tuple[float, float, float], target: tuple[float, float, float], *, rng: np.random.Generator, spread: float
) -> Camera:
    centre_m = np.array(centre) + spread * np.clip(rng.normal(0, _PLACE_SPREAD_M, 3), -0.05, 0.05)
    target_m = np.array(target) + spread * np.clip(rng.normal(0, _TARGET_SPREAD_M, 3), -0.05, 0.05)
    forward = (target_m - centre_m) / np.linalg.norm(target_m - centre_m)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    roll = np.radians(spread * np.clip(rng.normal(0, _ROLL_SPREAD_DEG), -2, 2))
    right, down = np.cos(roll) * right + np.sin(roll) * down, np.cos(roll) * down - np.sin(roll) * right
    focal_px, x_px, y_px = rng.uniform(918, 929), rng.uniform(636, 652), rng.uniform(352, 364)
    intrinsic = np.array([[focal_px, 0, x_px], [0, focal_px + rng.uniform(-0.4, 0.4), y_px], [0, 0, 1]])
    rotation = np.array([right, down, forward])
    return Camera(intrinsic, rotation, -rotation @ centre_m, CALIBRATED_SIZE)
