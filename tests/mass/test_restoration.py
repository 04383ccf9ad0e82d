import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from corsmal.errors import ArgumentError
from corsmal.mass import RestoredMask, restore_mask
from tests.mass.made import BOX, CUP, GLASS, container, gripped, iou

TILTS = [-25, -8, 0, 15, 30]


def slow_mirror_union(mask, crop, axis):
    """Pixel by pixel: what the restored mask should be."""
    x0, y0, x1, y1 = crop
    restored = mask.copy()
    across = np.array([-axis.direction[1], axis.direction[0]])
    for y in range(y0, y1):
        for x in range(x0, x1):
            distance = (np.array([x, y]) - axis.point) @ across
            column, row = np.rint(np.array([x, y]) - 2 * distance * across).astype(int)
            if x0 <= column < x1 and y0 <= row < y1 and mask[row, column]:
                restored[y, x] = True
    return restored


@pytest.mark.parametrize("axis", ["base", "whole"])
@pytest.mark.parametrize("tilt_deg", TILTS)
def test_restored_mask_is_the_slow_mirror_union(axis, tilt_deg):
    pose = {"base": (101.3, 90.6), "tilt_deg": tilt_deg}
    profile = tuple((width / 3, height / 3) for width, height in CUP)
    mask = gripped(container(profile, size=(130, 210), **pose), low=12, high=35, **pose)
    found = restore_mask(mask, axis=axis)
    expected = slow_mirror_union(mask, found.crop, found.axis)
    # float32 pixels: where a mirror image lies between two pixels either may be the nearest
    assert (found.mask ^ expected).sum() <= 2
    np.testing.assert_array_equal(found.added, found.mask & ~mask)


@given(st.integers(0, 2**32 - 1), st.sampled_from(["base", "whole"]))
@settings(max_examples=30)
def test_nothing_is_taken_away_or_added_outside_the_box_and_a_restored_mask_is_symmetric(seed, axis):
    rng = np.random.default_rng(seed)
    mask = np.zeros((60, 80), bool)
    x, y = rng.integers(5, 40, 2)
    mask[y : y + rng.integers(3, 20), x : x + rng.integers(3, 40)] = True
    mask &= rng.random(mask.shape) < 0.9
    found = restore_mask(mask, padding_px=4, axis=axis)
    if not found.ok:
        assert found.mask is mask
        return
    assert (found.mask & mask).sum() == mask.sum()
    x0, y0, x1, y1 = found.crop
    outside = np.ones_like(mask)
    outside[y0:y1, x0:x1] = False
    assert not found.added[outside].any()
    assert (found.mask ^ slow_mirror_union(mask, found.crop, found.axis)).sum() <= 2


@pytest.mark.parametrize("tilt_deg", TILTS)
@pytest.mark.parametrize("profile", [CUP, GLASS, BOX])
@pytest.mark.parametrize("axis", ["base", "whole"])
def test_what_a_hand_hides_on_one_side_comes_back(profile, tilt_deg, axis):
    whole = container(profile, tilt_deg=tilt_deg)
    seen = gripped(whole, low=60, high=120, tilt_deg=tilt_deg)
    found = restore_mask(seen, axis=axis)
    assert found.ok
    assert found.axis.tilt_deg == pytest.approx(tilt_deg, abs=2)
    assert iou(seen, whole) < 0.86
    assert iou(found.mask, whole) > 0.96


def test_a_symmetric_mask_gains_nothing():
    mask = np.zeros((60, 80), bool)
    mask[10:50, 20:45] = True
    found = restore_mask(mask)
    assert not found.added.any()
    assert found.notes == ()
    np.testing.assert_array_equal(found.mask, mask)


def test_the_axis_of_a_tilted_base_is_not_vertical():
    """The same mask under a vertical axis through its lowest pixels would be far from the truth."""
    whole = container(CUP, tilt_deg=20)
    found = restore_mask(gripped(whole, tilt_deg=20))
    assert found.axis.direction == pytest.approx((np.sin(np.radians(20)), -np.cos(np.radians(20))), abs=0.03)


def test_the_crop_is_the_padded_box_and_cropped_is_its_content():
    mask = np.zeros((200, 300), bool)
    mask[80:120, 100:150] = True
    found = restore_mask(mask)
    assert found.crop == (85, 65, 165, 135)
    assert found.cropped.shape == (70, 80)
    assert found.cropped.sum() == mask.sum()
    assert restore_mask(mask, padding_px=0).crop == (100, 80, 150, 120)


def test_the_crop_ends_at_the_border():
    mask = np.zeros((200, 300), bool)
    mask[5:40, 260:296] = True
    found = restore_mask(mask)
    assert found.crop == (245, 0, 300, 55)
    assert found.notes == ()


def test_nothing_is_restored_beyond_the_padded_box():
    mask = np.zeros((100, 200), bool)
    mask[60:70, 80:101] = True  # the base, and a long arm to the right
    mask[30:60, 90:160] = True
    crop = restore_mask(mask, padding_px=3).crop
    assert crop == (77, 27, 163, 73)
    added = np.argwhere(restore_mask(mask, padding_px=3).added)
    assert added.min(axis=0)[1] == 77


@pytest.mark.parametrize(
    ("rows", "columns", "sides"),
    [
        (slice(0, 50), slice(20, 60), "upper"),
        (slice(60, 100), slice(20, 60), "lower"),
        (slice(20, 60), slice(0, 40), "left"),
        (slice(60, 100), slice(110, 150), "right and lower"),
    ],
)
def test_a_mask_cut_by_the_border_is_restored_and_says_so(rows, columns, sides):
    mask = np.zeros((100, 150), bool)
    mask[rows, columns] = True
    found = restore_mask(mask)
    assert found.ok
    assert found.notes == (f"the image's {sides} border cuts the mask: nothing is restored beyond it",)


def test_an_empty_mask_is_a_failed_record():
    mask = np.zeros((40, 50), bool)
    found = restore_mask(mask)
    assert (found.ok, found.reason, found.axis, found.crop) == (False, "the mask is empty", None, (0, 0, 0, 0))
    assert found.cropped.size == 0
    assert not found.added.any()


@pytest.mark.parametrize("axis", ["base", "whole"])
@pytest.mark.parametrize(
    ("rows", "columns", "kind"), [(slice(9, 10), slice(5, 30), "row"), (slice(9, 30), slice(5, 6), "column")]
)
def test_a_mask_of_one_row_or_column_is_a_failed_record(rows, columns, kind, axis):
    mask = np.zeros((40, 50), bool)
    mask[rows, columns] = True
    found = restore_mask(mask, axis=axis)
    assert (found.ok, found.reason) == (False, f"the mask is a single {kind} of pixels")
    np.testing.assert_array_equal(found.mask, mask)


@pytest.mark.parametrize("axis", ["base", "whole"])
@pytest.mark.parametrize("shape", [(2, 2), (2, 9), (9, 2), (3, 3)])
def test_a_mask_of_a_few_pixels_is_restored_as_it_is(shape, axis):
    mask = np.zeros((40, 50), bool)
    mask[9 : 9 + shape[0], 5 : 5 + shape[1]] = True
    found = restore_mask(mask, axis=axis)
    assert found.ok
    assert not found.added.any()


def test_a_mask_that_ends_below_in_a_point_has_no_base():
    mask = np.zeros((100, 100), bool)
    for row in range(10, 81):
        mask[row, 50 - (80 - row) // 2 : 51 + (80 - row) // 2] = True
    mask[80] = mask[79] = False
    mask[79:81, 50] = True
    found = restore_mask(mask)
    assert (found.ok, found.reason) == (False, "the mask has no base: no lower edge rises by less than 40 degrees")
    assert restore_mask(mask, axis="whole").ok


def test_a_hidden_base_is_doubted():
    seen = container(CUP)
    y, x = np.mgrid[: seen.shape[0], : seen.shape[1]]
    seen &= y < 215 + 0.5 * (x - 320)
    found = restore_mask(seen)
    assert found.ok
    assert found.notes == ("another axis fits the outline much better: the base may be hidden",)
    whole = container(CUP) & (y < 260)
    better = restore_mask(seen, axis="whole")
    assert better.notes == ()
    assert iou(better.mask, whole) > max(iou(found.mask, whole), iou(seen, whole))


def test_two_parts_are_both_taken_for_the_container():
    whole = container(CUP)
    seen = whole.copy()
    seen[180:200] = False  # a finger across all of it
    seen = gripped(seen, low=80, high=120)
    found = restore_mask(seen)
    assert found.notes == ("the mask has 2 separate parts; all are used as the container",)
    assert iou(found.mask, whole) > iou(seen, whole) + 0.1
    assert not found.added[180:200].any()


def test_a_hole_is_filled_where_the_mask_faces_it():
    mask = np.zeros((100, 100), bool)
    mask[20:80, 20:81] = True
    mask[40:50, 25:35] = False
    found = restore_mask(mask)
    assert found.notes == ("the mask has a hole; only pixels mirrored from the mask are filled",)
    assert found.mask[20:80, 20:81].all()
    mask[40:50, 66:76] = False
    found = restore_mask(mask)
    assert found.notes == ("the mask has 2 holes; only pixels mirrored from the mask are filled",)
    assert not found.added.any()


@pytest.mark.parametrize(
    ("mask", "message"),
    [
        (np.zeros((4, 5)), r"mask must be an image \(H, W\) of bool, got float64 \(4, 5\)"),
        (np.zeros((4, 5, 3), bool), r"got bool \(4, 5, 3\)"),
        (np.zeros((0, 5), bool), r"got bool \(0, 5\)"),
        ([[True]], "got list"),
    ],
)
def test_what_is_no_mask_is_an_error(mask, message):
    with pytest.raises(ArgumentError, match=message):
        restore_mask(mask)


@pytest.mark.parametrize("padding_px", [-1, 1.5, True, None])
def test_padding_is_a_number_of_pixels(padding_px):
    with pytest.raises(ArgumentError, match="padding_px must be a whole number of pixels, 0 or more"):
        restore_mask(np.zeros((4, 5), bool), padding_px=padding_px)


def test_there_are_three_rules_for_the_axis():
    with pytest.raises(ArgumentError, match="axis must be one of base, whole, top, got 'left'"):
        restore_mask(np.zeros((4, 5), bool), axis="left")


def test_a_restored_mask_has_an_axis_or_a_reason():
    mask = np.zeros((4, 5), bool)
    with pytest.raises(ArgumentError, match="without an axis must give a reason"):
        RestoredMask(mask, (0, 0, 5, 4), None, mask)
    with pytest.raises(ArgumentError, match="same shape"):
        RestoredMask(mask, (0, 0, 5, 4), None, mask[:2], "no axis")
