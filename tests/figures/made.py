"""A hull made by hand, of which every number is known."""

import numpy as np

from corsmal.shape import Dimensions, Hull

CENTROID_M = np.array([0.02, -0.03, 0.08])
HEIGHTS_MM = np.array([30.0, 40, 50, 60, 70, 80, 90])
RADII_MM = np.array([2.5, 55, 40, 40.5, 41, 41.5, 60])
CONVERGED = np.array([False, True, True, True, True, True, True])
"""Smoothing with d_max = 1 drops 55 (its next differs by 15) and 41.5 (its next by 18.5)."""

KEPT = np.array([2, 3, 4, 6])


def made_hull() -> Hull:
    return Hull(HEIGHTS_MM, RADII_MM, CONVERGED, CENTROID_M)


def made_dimensions() -> Dimensions:
    return Dimensions(300.0, 82.0, 80.0, 20.0, kept=KEPT, bottom=2, top=4)


def traces(figure) -> dict:
    """A figure's traces by name."""
    return {trace.name: trace for trace in figure.data}
