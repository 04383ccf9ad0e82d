"""A mask carried on to pictures in which it was moved by a known way."""

import cv2
import numpy as np
import pytest

from corsmal.by_hand import follow_mask
from corsmal.by_hand.following import follow_on
from corsmal.errors import ArgumentError

SHAPE = (120, 160)


def scene(shift=(0, 0), *, has_cup=True):
    """A textured disc on a textured table; the disc alone is moved by (x, y)."""
    rng = np.random.default_rng(0)
    table = cv2.GaussianBlur(rng.uniform(0, 255, (*SHAPE, 3)).astype(np.float32), (0, 0), 2)
    table = (table - table.mean()) * 2 + 160
    patch = cv2.GaussianBlur(rng.uniform(0, 255, (*SHAPE, 3)).astype(np.float32), (0, 0), 2)
    patch = (patch - patch.mean()) * 2 + 70
    move = np.float32([[1, 0, shift[0]], [0, 1, shift[1]]])
    patch = cv2.warpAffine(patch, move, SHAPE[::-1], borderMode=cv2.BORDER_REFLECT)
    rows, columns = np.indices(SHAPE)
    mask = (columns - 70 - shift[0]) ** 2 + (rows - 60 - shift[1]) ** 2 <= 28**2
    image = np.where(mask[..., None] & has_cup, patch, table)
    return image.clip(0, 255).astype(np.uint8), mask


def overlap(first, second):
    return (first & second).sum() / (first | second).sum()


@pytest.mark.parametrize("shift", [(0, 0), (5, -3), (-8, 4)])
def test_a_mask_follows_what_it_is_on(shift):
    (before, mask), (after, moved) = scene(), scene(shift)
    found = follow_mask(mask, before, after)
    assert found.lost == ""
    assert overlap(found.mask, moved) > 0.93
    assert found.returns > 0.8
    assert found.matches > 0.8


def test_a_container_that_is_gone_is_lost():
    (before, mask), (after, _) = scene(), scene(has_cup=False)
    found = follow_mask(mask, before, after)
    assert found.lost


def test_a_picture_of_another_colour_does_not_agree():
    before, mask = scene()
    found = follow_mask(mask, before, 255 - before)
    assert found.lost


def test_an_empty_mask_and_pictures_of_two_sizes_are_refused():
    before, mask = scene()
    with pytest.raises(ArgumentError, match="must not be empty"):
        follow_mask(np.zeros_like(mask), before, before)
    with pytest.raises(ArgumentError, match="must have one size"):
        follow_mask(mask, before, before[:50])


class Shown:
    """Frames in place of a video."""

    def __init__(self, images):
        self.images = images
        self.frame_count = len(images)

    def __getitem__(self, frame):
        return self.images[frame]


def test_it_goes_on_until_it_is_lost_or_the_video_ends():
    shifts = [(2 * step, -step) for step in range(4)]
    images = [scene(shift)[0] for shift in shifts] + [scene(has_cup=False)[0]] * 2
    found = dict(follow_on(Shown(images), scene()[1], 0, frames=10))
    assert list(found) == [1, 2, 3, 4]
    assert [bool(each.lost) for each in found.values()] == [False, False, False, True]
    assert overlap(found[3].mask, scene(shifts[3])[1]) > 0.85
    assert list(dict(follow_on(Shown(images[:3]), scene()[1], 1, frames=10))) == [2]
    assert list(dict(follow_on(Shown(images), scene()[1], 0, frames=2))) == [1, 2]
