import numpy as np
import pytest

from corsmal.by_hand import HandMask, mask_sentences
from corsmal.errors import ArgumentError

SHAPE = (20, 30)


def rectangle(top, bottom, left, right):
    mask = np.zeros(SHAPE, dtype=bool)
    mask[top:bottom, left:right] = True
    return mask


def test_masks_come_back_as_they_were():
    visible, whole = rectangle(2, 10, 3, 9), rectangle(2, 15, 3, 9)
    found = HandMask.of(visible, frame=4, amodal=whole)
    np.testing.assert_array_equal(found.mask, visible)
    np.testing.assert_array_equal(found.amodal_mask, whole)
    assert HandMask.of(visible, frame=4).amodal_mask is None
    assert found.area == 8 * 6


def test_a_mask_is_the_only_detection_of_its_frame():
    detections = HandMask.of(rectangle(2, 10, 3, 9), frame=4, label=44).detections()
    np.testing.assert_array_equal(detections.boxes, [[3, 2, 9, 10]])
    assert (detections.scores.tolist(), detections.labels.tolist()) == ([1.0], [44])
    np.testing.assert_array_equal(detections.mask(0), rectangle(2, 10, 3, 9))


def test_an_empty_mask_says_that_nothing_is_there():
    empty = np.zeros(SHAPE, dtype=bool)
    assert len(HandMask.of(empty, frame=0).detections()) == 0
    assert "no container is visible" in mask_sentences(empty)[0]


def test_two_parts_are_kept_with_a_sentence():
    mask = rectangle(2, 10, 3, 9) | rectangle(15, 17, 20, 23)
    [sentence] = mask_sentences(mask)
    assert "2 parts (48, 6 px)" in sentence
    assert mask_sentences(rectangle(2, 10, 3, 9)) == ()


def test_visible_pixels_outside_the_whole_outline_are_counted():
    [sentence] = mask_sentences(rectangle(2, 10, 3, 9), rectangle(2, 9, 3, 9))
    assert sentence.startswith("6 visible pixels lie outside")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"frame": -1}, "frame must be"),
        ({"label": 1}, "container's class"),
        ({"counts": b"abc"}, "broken"),
        ({"size": (np.inf, 60)}, "size must"),
    ],
)
def test_what_can_be_no_mask_is_refused(change, said):
    good = HandMask.of(rectangle(2, 10, 3, 9), frame=4)
    with pytest.raises(ArgumentError, match=said):
        HandMask(**{"frame": 4, "size": SHAPE, "counts": good.counts, **change})
