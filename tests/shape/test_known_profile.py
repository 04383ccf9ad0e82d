import numpy as np
import pytest

from corsmal.errors import ArgumentError
from corsmal.shape import Dimensions, Hull, KnownProfile


def hull(heights_mm, radii_mm):
    return Hull(np.array(heights_mm, float), np.array(radii_mm, float), np.ones(len(radii_mm), bool), np.zeros(3))


def test_an_error_is_the_difference_of_the_radii_and_beyond_the_ends_the_distance_to_them():
    known = KnownProfile([0, 100], [30, 50], "true profile", base_mm=10)
    found = known.errors_mm(hull([7, 10, 60, 110, 113, 113], [20, 31, 38, 50, 20, 54]), base_mm=10)
    assert found == pytest.approx([3, 1, -2, 0, 3, 5])


def test_a_profile_without_a_place_stands_on_the_lower_end():
    solid = hull([40, 50, 60, 70], [9, 30, 40, 50])
    ends = Dimensions(1.0, 1.0, 1.0, 1.0, bottom=1, top=3)
    assert KnownProfile.frustum(60, 100, 20).base_of(solid, ends) == 50
    assert KnownProfile.frustum(60, 100, 20).base_of(solid, Dimensions(reason="no")) is None
    assert KnownProfile([0, 9], [1, 1], "true profile", base_mm=44).base_of(solid, ends) == 44


def test_the_annotated_frustum_has_half_the_widths():
    known = KnownProfile.frustum(61, 98, 119)
    assert list(known.heights_mm) == [0, 119]
    assert list(known.radii_mm) == [30.5, 49]


@pytest.mark.parametrize(
    ("heights_mm", "radii_mm"), [([0], [1]), ([0, 1], [1, 2, 3]), ([0, 0], [1, 1]), ([1, 2], [1, 1]), ([0, 1], [1, -1])]
)
def test_what_is_no_profile_is_refused(heights_mm, radii_mm):
    with pytest.raises(ArgumentError, match="heights_mm"):
        KnownProfile(heights_mm, radii_mm, "true profile")
