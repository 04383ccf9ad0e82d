"""Compiling ahead: what the first fit of an installation would wait for."""

from typing import Any

import numpy as np

from corsmal.geometry import Camera, Floats
from corsmal.parameters import ShapeParameters
from corsmal.shape.agreeing import fit_agreeing

SIZE = (160, 120)
AROUND_DEG = (0.0, 70.0, 140.0)


def compile_fits(_item: object = None) -> dict[str, Any]:
    """Fit a ball with ``paper`` and ``tuned``: their loops are compiled, and kept on disk for other processes.

    Returns:
        Why a fit failed, by preset and number of views; empty: it did not.
    """
    cameras = [_camera(np.radians(angle)) for angle in AROUND_DEG]
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]]
    ball = (columns - SIZE[0] / 2) ** 2 + (rows - SIZE[1] / 2) ** 2 < 20**2
    presets = {"paper": ShapeParameters.paper(), "tuned": ShapeParameters.tuned()}
    return {
        f"{name}, {views}": fit_agreeing(cameras[:views], [ball] * views, preset).reason
        for name, preset in presets.items()
        for views in (2, 3)
    }


def _camera(angle: float) -> Camera:
    """A camera a metre from the origin, which it sees in the middle, its rows level."""
    intrinsic = np.array([[160.0, 0.0, SIZE[0] / 2], [0.0, 160.0, SIZE[1] / 2], [0.0, 0.0, 1.0]])
    sideways: Floats = np.array([-np.sin(angle), np.cos(angle), 0.0])
    down: Floats = np.array([0.0, 0.0, -1.0])
    rotation = np.stack([sideways, down, np.cross(sideways, down)])
    return Camera(intrinsic, rotation, np.array([0.0, 0.0, 1.0]), SIZE)
