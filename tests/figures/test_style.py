import itertools

import numpy as np
import pytest

from corsmal.figures.style import PRESET_COLOURS, VIEW_COLOURS, rgb
from corsmal.parameters import SHAPE_PRESETS

PAPERS = ("#FBFCFD", "#11171C")
"""The background of the light and of the dark theme."""


def linear(colour: str) -> np.ndarray:
    shares = np.array(rgb(colour)) / 255
    return np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)


def lab(colour: str) -> np.ndarray:
    """CIE L*a*b* of an sRGB colour under D65."""
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    shares = np.cbrt(to_xyz @ linear(colour) / [0.9505, 1.0, 1.089])  # none of the colours is nearly black
    return np.array([116 * shares[1] - 16, 500 * (shares[0] - shares[1]), 200 * (shares[1] - shares[2])])


def contrast(*colours: str) -> float:
    low, high = sorted(float(linear(colour) @ [0.2126, 0.7152, 0.0722]) for colour in colours)
    return (high + 0.05) / (low + 0.05)


def test_every_preset_has_a_colour_of_its_own_that_is_no_views():
    assert set(PRESET_COLOURS) == set(SHAPE_PRESETS)
    for preset, view in itertools.product(PRESET_COLOURS.values(), VIEW_COLOURS.values()):
        assert np.linalg.norm(lab(preset) - lab(view)) > 30
    for first, second in itertools.combinations(PRESET_COLOURS.values(), 2):
        assert np.linalg.norm(lab(first) - lab(second)) > 30


@pytest.mark.parametrize("colour", PRESET_COLOURS.values())
def test_presets_stand_out_from_the_background_of_both_themes(colour):
    assert min(contrast(colour, paper) for paper in PAPERS) > 3
