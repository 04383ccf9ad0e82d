"""Proposals by GrabCut on a picture whose answer is known."""

import cv2
import numpy as np
import pytest

from corsmal.by_hand import Prompt, open_segmenter, propose_mask
from corsmal.errors import ArgumentError

SHAPE = (120, 160)
BOX = (50, 30, 110, 100)


def cup():
    """A red ellipse on a grey table, both with noise, and the ellipse."""
    rng = np.random.default_rng(0)
    rows, columns = np.indices(SHAPE)
    mask = ((columns - 80) / 26) ** 2 + ((rows - 65) / 31) ** 2 <= 1
    image = rng.normal(150, 6, (*SHAPE, 3))
    image[mask] = rng.normal((190, 50, 40), 6, (mask.sum(), 3))
    return image.clip(0, 255).astype(np.uint8), mask


def overlap(first, second):
    return (first & second).sum() / (first | second).sum()


def test_a_box_is_enough_where_the_colours_differ():
    image, mask = cup()
    assert overlap(propose_mask(image, Prompt(BOX)).mask, mask) > 0.95


def test_the_same_prompt_gives_the_same_mask():
    image, _ = cup()
    first, second = (propose_mask(image, Prompt(BOX)).mask for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_a_stroke_outside_takes_away_what_has_the_same_colour():
    image, mask = cup()
    image[36:60, 52:60] = (190, 50, 40)  # a second red thing within the box
    with_both = propose_mask(image, Prompt(BOX)).mask
    told = propose_mask(image, Prompt(BOX, inside=[[(80, 65)]], outside=[[(55, 38), (55, 58)]])).mask
    assert with_both[40:56, 53:58].mean() > 0.9 or overlap(with_both, mask) > 0.9
    assert not told[40:56, 54:57].any()
    assert overlap(told, mask) > 0.85


def test_where_colours_tell_nothing_the_usual_place_in_the_box_counts():
    image = np.random.default_rng(0).normal(150, 6, (*SHAPE, 3)).clip(0, 255).astype(np.uint8)
    found = propose_mask(image, Prompt(BOX)).mask
    left, top = BOX[:2]
    assert found[top + 8 : top + 14, 74:86].all()  # below the middle of the rim, which hands hide least
    assert not found[: top - 1].any()
    assert not found[:, : left - 1].any()


def grown(mask, pixels):
    return cv2.dilate(mask.astype(np.uint8), np.ones((2 * pixels + 1,) * 2)).view(np.bool_)


def test_the_mask_so_far_is_drawn_to_the_edges_of_the_picture():
    image, mask = cup()
    start = grown(mask, 1)
    found = propose_mask(image, Prompt(BOX, start=start)).mask
    assert overlap(found, mask) > 0.98 > overlap(start, mask)


def test_what_is_far_from_the_edge_of_the_mask_so_far_stays():
    image, mask = cup()
    image[30:100, 80:84] = 150  # a stripe that looks like the table
    found = propose_mask(image, Prompt(BOX, start=mask)).mask
    assert found[42:90, 80:84].all()
    assert overlap(found, mask) > 0.95


def test_a_stroke_that_contradicts_the_mask_so_far_takes_its_place():
    image, mask = cup()
    image[36:60, 52:58] = (190, 50, 40)
    start = mask.copy()
    start[36:60, 52:58] = True
    kept = propose_mask(image, Prompt(BOX, start=start)).mask
    told = propose_mask(image, Prompt(BOX, start=start, outside=[[(54, 38), (54, 58)]])).mask
    assert kept[40:56, 53:56].mean() > 0.5
    assert not told[40:56, 53:56].any()
    assert overlap(told, mask) > 0.9
    smaller = mask.copy()
    smaller[:50] = False
    added = propose_mask(image, Prompt((54, 34, 107, 97), start=smaller, inside=[[(80, 40), (80, 48)]])).mask
    assert added[40:48, 78:83].all()
    assert (added & mask).sum() > smaller.sum() + 200


def test_a_mask_somewhere_else_is_not_begun_with():
    image, mask = cup()
    elsewhere = np.zeros(SHAPE, dtype=bool)
    elsewhere[5:20, 5:20] = True
    plain = propose_mask(image, Prompt(BOX)).mask
    for start in (elsewhere, np.zeros(SHAPE, dtype=bool), np.ones(SHAPE, dtype=bool)):
        np.testing.assert_array_equal(propose_mask(image, Prompt(BOX, start=start)).mask, plain)
    with pytest.raises(ArgumentError, match="start must be"):
        propose_mask(image, Prompt(BOX, start=mask[:50]))


def test_a_large_picture_is_made_smaller_first():
    image, mask = cup()
    large, true = image.repeat(8, axis=0).repeat(8, axis=1), mask.repeat(8, axis=0).repeat(8, axis=1)
    found = propose_mask(large, Prompt(tuple(8 * side for side in BOX))).mask
    assert found.shape == true.shape
    assert overlap(found, true) > 0.95


def test_a_box_over_the_whole_picture_leaves_no_background_to_learn():
    image, _ = cup()
    assert propose_mask(image, Prompt((0, 0, 160, 120))).mask.all()


def test_where_all_is_background_nothing_is_found_and_that_is_said():
    image, _ = cup()
    inked = [[(x, y) for x in range(48, 113, 2)] for y in range(26, 104, 3)]
    found = propose_mask(image, Prompt(BOX, outside=inked))
    assert not found.mask.any()
    assert "Nothing was found" in found.said


@pytest.mark.parametrize("box", [(5, 5, 5, 20), (9, 9, 3, 20), (0, 0, np.nan, 5), (0, 0, 10**400, 5), (0, 0, 5), 7])
def test_a_box_that_is_none_is_refused(box):
    with pytest.raises(ArgumentError, match="box must be"):
        Prompt(box)


def test_a_box_outside_the_picture_and_a_stroke_without_points_are_refused():
    image, _ = cup()
    with pytest.raises(ArgumentError, match="must lie in the picture"):
        propose_mask(image, Prompt((500, 500, 600, 600)))
    for stroke in ([], [(1, np.inf)], [(1, 10**400)], [(1, 1e308)], [(1, 2, 3)], "text"):
        with pytest.raises(ArgumentError, match="strokes must be"):
            Prompt(BOX, inside=[stroke])


def test_without_a_file_grabcut_proposes(monkeypatch):
    monkeypatch.delenv("CORSMAL_SEGMENTER", raising=False)
    segmenter = open_segmenter()
    image, mask = cup()
    assert segmenter.name == "GrabCut"
    assert overlap(segmenter.propose(image, Prompt(BOX)).mask, mask) > 0.95
