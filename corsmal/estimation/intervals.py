"""Intervals that hold the truth with a probability of 90 %, of single fits and of a recording."""

from collections.abc import Mapping

import numpy as np

from corsmal.dataset import Recording
from corsmal.estimation.fit import Fit
from corsmal.geometry import Floats
from corsmal.quantities import DIMENSIONS, GEOMETRY

CAPACITY_SCALE, LENGTH_SCALE = 1.6, 1.2
"""From the spread of the fits and a pixel's size to half of a 90 % interval, as ninety synthetic recordings have it."""

ROUND_SCALES, BOX_SCALES = (6.7, 1.7, 3.1, 0.9), (6.5, 1.1, 1.1, 0.8)
"""From a fit's predicted error to half of a 90 % interval, for capacity, top width, bottom width and height, as the 467
fits of ``corsmal.shape.quality`` have it."""

Interval = tuple[float, float]


def frame_intervals(fit: Fit) -> dict[str, Interval]:
    """The intervals of one frame's fit, by quantity: as wide as its predicted error says; empty where none is known."""
    if not fit.ok or fit.hull.error_pct is None:
        return {}
    scales = ROUND_SCALES if fit.hull.depth_mm is None else BOX_SCALES
    halves = np.array(scales) * fit.hull.error_pct / 100
    values = {name: getattr(fit.dimensions, name) for name in GEOMETRY}
    return {
        name: _around(value, value * half)
        for (name, value), half in zip(values.items(), halves.tolist(), strict=True)
        if value is not None
    }


def recording_intervals(values: Mapping[str, float], spreads: Floats, *, pixel_mm: float) -> dict[str, Interval]:
    """The intervals of a recording: they hold the spread of its fits and what a pixel more or less of the masks does.

    Args:
        values: all of ``GEOMETRY``, mL and mm.
        spreads: (4,) half of the spread of the fits, in the same order and units.
        pixel_mm: what a pixel spans at the container, see ``pixel_size_mm``.
    """
    sizes = [values[name] for name in DIMENSIONS]
    pixels = [values["capacity_ml"] * sum(pixel_mm / size for size in sizes), *[pixel_mm] * 3]
    halves = np.array([CAPACITY_SCALE, *[LENGTH_SCALE] * 3]) * np.hypot(spreads, pixels)
    return {name: _around(values[name], half) for name, half in zip(GEOMETRY, halves.tolist(), strict=True)}


def pixel_size_mm(fit: Fit, recording: Recording) -> float:
    """What a pixel spans at the container, mean of the pair's views, mm."""
    cameras = [recording.views[name].camera() for name in fit.pair]
    centre = np.zeros(3) if fit.hull.centroid_m is None else fit.hull.centroid_m
    spans = [1000 * np.linalg.norm(camera.centre_m - centre) / camera.intrinsic[0, 0] for camera in cameras]
    return float(np.mean(spans))


def _around(value: float, half: float) -> Interval:
    return max(0.0, value - half), value + half
