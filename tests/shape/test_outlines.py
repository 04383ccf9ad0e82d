"""Masks without the empty pixels around them, and what they would be without a hand."""

import cv2
import numpy as np
import pytest

from corsmal.shape.cropped import Cropped
from corsmal.shape.outline_kernels import ends_of_rows, middle_of_missing

CUP = np.array([[60, 20], [140, 20], [125, 120], [75, 120]], dtype=np.int32)


def painted(*polygons):
    mask = np.zeros((160, 200), np.uint8)
    for polygon in polygons:
        cv2.fillConvexPoly(mask, np.asarray(polygon, dtype=np.int32), 1)
    return mask.astype(bool)


def whole_mask(mask):
    return Cropped.of(mask).whole.in_picture()


def test_a_bite_in_a_side_is_filled_in():
    cup = painted(CUP)
    bitten = cup.copy()
    bitten[50:90, :95] = False
    assert (bitten ^ cup).sum() > 0.1 * cup.sum()
    assert (whole_mask(bitten) ^ cup).sum() < 0.06 * cup.sum()


def test_a_tongue_between_two_fingers_is_taken_off():
    cup = painted(CUP)
    tongued = cup.copy()
    tongued[70:78, 30:75] = True
    assert (whole_mask(tongued) ^ cup).sum() < 0.05 * cup.sum()


def test_a_glass_on_its_stem_stays_as_it_is():
    glass = painted([[60, 10], [140, 10], [100, 60]], [[97, 60], [103, 60], [103, 130], [97, 130]])
    glass |= painted([[70, 130], [130, 130], [130, 138], [70, 138]])
    np.testing.assert_array_equal(whole_mask(glass), glass)


def test_a_mask_at_the_border_keeps_its_place():
    mask = np.zeros((160, 200), bool)
    mask[100:, 150:] = True
    assert (whole_mask(mask) ^ mask).sum() < 0.05 * mask.sum()


@pytest.mark.parametrize("top", [0, 1, 30, 119, 120])
@pytest.mark.parametrize("left", [0, 1, 149, 150])
def test_whole_masks_are_cut_where_the_picture_ends(left, top):
    """An even square moves what it opens by a pixel, maybe out of the picture."""
    mask = np.zeros((160, 200), bool)
    mask[top : top + 40, left : left + 50] = True
    found, grown = Cropped.of(mask).whole, np.zeros((162, 202), bool)
    grown[top : top + 42, left : left + 52] = True
    assert found.size == (200, 160)
    assert not (found.in_picture() & ~grown[1:-1, 1:-1]).any()
    assert (found.in_picture() & mask).sum() > 0.9 * mask.sum()


def test_a_cropped_mask_has_all_of_its_pixels():
    cup = painted(CUP)
    found = Cropped.of(cup)
    assert (found.left, found.top, found.pixels.shape, found.count) == (60, 20, (101, 81), cup.sum())
    np.testing.assert_array_equal(found.in_picture(), cup)
    empty = Cropped.of(np.zeros_like(cup))
    assert (empty.count, empty.centroid) == (0, None)
    assert not empty.in_picture().any()
    window, left, top = found.window
    assert (left, top) == (57, 17)
    np.testing.assert_array_equal(window[3:-3, 3:-3], found.pixels)


def test_the_pixels_of_two_masks_are_counted_where_both_lie():
    first, second = painted(CUP), painted([[100, 70], [190, 70], [190, 150]])
    assert Cropped.of(first).pixels_in_both(Cropped.of(second)) == (first & second).sum() > 100
    apart = painted([[150, 20], [190, 20], [190, 40]])
    assert Cropped.of(first).pixels_in_both(Cropped.of(apart)) == 0


def test_specks_are_taken_off_and_parts_stay():
    cup, part, speck = painted(CUP), painted([[150, 20], [190, 20], [190, 60]]), painted([[5, 5], [15, 5], [5, 15]])
    np.testing.assert_array_equal(Cropped.of(cup | part | speck).without_specks.in_picture(), cup | part)
    clean = Cropped.of(cup)
    assert clean.without_specks is clean


def test_rows_end_between_the_columns_where_they_cross_one_half():
    plane = np.zeros((5, 12), np.float32)
    plane[0, 3:9] = 1.0
    plane[1, 3:9], plane[1, 2], plane[1, 9] = 1.0, 0.25, 0.4
    plane[2, 0:12] = 1.0  # reaches both ends of the plane
    plane[3, 3:9] = 1.0
    pixels_from_mm = np.array([[1.0, 0.0, 100.0], [0.0, 1.0, 50.0], [0.0, 0.0, 1.0]])
    low, high = ends_of_rows(plane, -6.0, 20.0, pixels_from_mm, 1.5, np.array([200.0, 72.5]))
    np.testing.assert_allclose(low[:3], [-6 + 2.5, -6 + 3 - 0.5 / 0.75, -6 - 0.5])
    np.testing.assert_allclose(high[:3], [-6 + 8.5, -6 + 8 + 0.5 / 0.6, -6 + 11.5])
    assert np.isnan([low[3:], high[3:]]).all()  # below the picture; nothing there


def test_the_lower_median_of_what_is_missing_counts():
    reach = np.array([10.0, np.nan, 12.0, 15.0, 11.0])
    heights, radii, overhangs = np.array([9.0, 0.0]), np.array([2.0, 40.0]), np.array([0.0, 0.0])
    shares = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
    upper = middle_of_missing(reach, -2.0, heights, radii, overhangs, shares, 1.0)
    assert upper[0] == 2.0  # of 1, 2, 3 and 6 mm
    assert upper[1] == 12.0  # only the middle lies in the plane
    assert middle_of_missing(reach, -2.0, heights, radii, overhangs, shares, -1.0)[0] == -3.0
    assert np.isnan(middle_of_missing(np.full(5, np.nan), -2.0, heights, radii, overhangs, shares, 1.0)).all()
