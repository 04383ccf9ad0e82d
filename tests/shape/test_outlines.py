"""What a mask would be without a hand, on masks painted by hand."""

import cv2
import numpy as np

from corsmal.shape.outlines import whole_mask

CUP = np.array([[60, 20], [140, 20], [125, 120], [75, 120]], dtype=np.int32)


def painted(*polygons):
    mask = np.zeros((160, 200), np.uint8)
    for polygon in polygons:
        cv2.fillConvexPoly(mask, np.asarray(polygon, dtype=np.int32), 1)
    return mask.astype(bool)


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
