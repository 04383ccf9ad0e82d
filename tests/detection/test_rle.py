import numpy as np
import pycocotools.mask as coco_mask
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from corsmal.detection import rle
from corsmal.detection.coco_entry import counts_from_segmentation
from corsmal.detection.rle import (
    decode_mask,
    encode_masks,
    mask_areas,
    mask_box,
    run_lengths,
    whole_counts,
)
from corsmal.errors import ArgumentError


def runs_of(mask):
    """Plain run lengths, column by column, beginning with background: the slow way."""
    runs, value = [0], False
    for pixel in mask.T.ravel().tolist():
        if pixel != value:
            runs.append(0)
            value = pixel
        runs[-1] += 1
    return runs


@given(arrays(np.bool_, st.tuples(st.integers(0, 3), st.integers(1, 9), st.integers(1, 40))))
def test_masks_survive_encoding_and_their_counts_are_their_runs(masks):
    counts = encode_masks(masks)
    assert len(counts) == len(masks)
    for item, mask in zip(counts, masks, strict=True):
        assert run_lengths(item, mask.shape).tolist() == runs_of(mask)
        np.testing.assert_array_equal(decode_mask(item, mask.shape), mask)
    np.testing.assert_array_equal(mask_areas(counts, masks.shape[1:]), masks.sum(axis=(1, 2)))


@given(arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 40))))
def test_plain_and_compressed_run_lengths_mean_the_same(mask):
    size = mask.shape
    plain = counts_from_segmentation({"size": list(size), "counts": runs_of(mask)}, size)
    assert plain == encode_masks(mask[None])[0]
    assert counts_from_segmentation({"size": list(size), "counts": plain.decode()}, size) == plain
    assert counts_from_segmentation({"size": list(size), "counts": plain}, size) == plain


def test_large_runs_survive():
    mask = np.zeros((1, 2000, 3000), dtype=bool)
    mask[0, 500:1500, 700:2900] = True
    [counts] = encode_masks(mask)
    np.testing.assert_array_equal(decode_mask(counts, (2000, 3000)), mask[0])


@pytest.mark.parametrize("length", range(1, 5))
def test_shortened_counts_are_rejected(length):
    mask = np.zeros((1, 20, 30), dtype=bool)
    mask[0, 5:15, 7:20] = True
    [counts] = encode_masks(mask)
    with pytest.raises(ArgumentError, match="broken"):
        run_lengths(counts[:-length], (20, 30))


@given(st.binary(max_size=12))
def test_random_counts_are_rejected_or_decode_to_the_pixels_they_name(counts):
    size = (4, 5)
    try:
        run_lengths(counts, size)
    except ArgumentError:
        return
    assert decode_mask(counts, size).sum() == mask_areas([counts], size)[0] <= 20


def is_whole(counts, size):
    try:
        run_lengths(counts, size)
    except ArgumentError:
        return False
    return True


@st.composite
def counts_good_and_broken(draw):
    """Counts of masks of 4x5, some with a character changed, lost or added, and some of random bytes."""
    counts = list(encode_masks(draw(arrays(np.bool_, st.tuples(st.integers(0, 6), st.just(4), st.just(5))))))
    for index in draw(st.sets(st.integers(0, len(counts)), max_size=3)) - {len(counts)}:
        place, more = draw(st.integers(0, len(counts[index]))), draw(st.binary(max_size=7))
        counts[index] = counts[index][:place] + more + counts[index][place + draw(st.integers(0, 1)) :]
    return draw(st.permutations(counts + draw(st.lists(st.binary(max_size=9), max_size=4))))


@pytest.mark.parametrize("characters_at_once", [1, 32_768])
@given(counts=counts_good_and_broken())
def test_many_counts_are_told_whole_or_broken_as_one_by_one(characters_at_once, counts):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rle, "CHARACTERS_AT_ONCE", characters_at_once)
        assert whole_counts(counts, (4, 5)) == {item for item in counts if is_whole(item, (4, 5))}


def test_counts_of_negative_runs_are_rejected():
    counts = coco_mask.frPyObjects({"size": [2, 2], "counts": [5, 2**32 - 1]}, 2, 2)["counts"]
    with pytest.raises(ArgumentError, match="broken"):
        run_lengths(counts, (2, 2))


def test_a_polygon_covers_its_inside():
    counts = counts_from_segmentation([[2, 1, 8, 1, 8, 5, 2, 5]], (10, 12))
    mask = decode_mask(counts, (10, 12))
    assert mask[2:5, 3:8].all()
    assert mask.sum() == 6 * 4


def test_several_polygons_are_joined():
    counts = counts_from_segmentation([[0, 0, 3, 0, 3, 3, 0, 3], [6, 6, 9, 6, 9, 9, 6, 9]], (10, 12))
    mask = decode_mask(counts, (10, 12))
    assert mask[1, 1]
    assert mask[7, 7]
    assert not mask[5, 5]


@pytest.mark.parametrize(
    ("segmentation", "message"),
    [
        (None, "missing"),
        ([], "missing"),
        (5, "missing"),
        ([[1, 2, 3, 4]], "three or more points"),
        ([[1, 2, 3, 4, 5, 6, 7]], "three or more points"),
        ([[1, 2, 3, 4, 5, "6"]], "three or more points"),
        ([[1, 2, 3, 4, 5, 10**400]], "three or more points"),
        ([1, 2, 3, 4, 5], "three or more points"),
        ([[1, 2, 3, 4, 5, 1e12]], "outside the image"),
        ([[1, 2, 3, 4, 5, float("nan")]], "outside the image"),
        ({"counts": "0"}, "no size"),
        ({"size": "10", "counts": "0"}, "no size"),
        ({"size": [12, 10], "counts": "0"}, "mask size 10x12, expected 12x10"),
        ({"size": [10, 12]}, "broken"),
        ({"size": [10, 12], "counts": ""}, "broken"),
        ({"size": [10, 12], "counts": "é"}, "broken"),
        ({"size": [10, 12], "counts": "oooooooooo"}, "broken"),
        ({"size": [10, 12], "counts": [100, 19]}, "broken"),
        ({"size": [10, 12], "counts": [121, -1]}, "broken"),
        ({"size": [10, 12], "counts": [120.0]}, "broken"),
    ],
)
def test_a_broken_segmentation_is_named(segmentation, message):
    with pytest.raises(ArgumentError, match=message):
        counts_from_segmentation(segmentation, (10, 12))


def test_the_box_around_a_mask_covers_whole_pixels():
    mask = np.zeros((2, 10, 12), dtype=bool)
    mask[0, 3:5, 4:9] = True
    filled, empty = encode_masks(mask)
    assert mask_box(filled, (10, 12)) == (4, 3, 5, 2)
    assert mask_box(empty, (10, 12)) is None
