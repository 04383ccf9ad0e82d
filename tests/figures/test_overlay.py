import cv2
import numpy as np
import pytest

from corsmal.detection import Detections, filter_detections
from corsmal.errors import ArgumentError
from corsmal.figures import draw_detections, jpeg
from corsmal.figures.overlay import FILL, FILL_DROPPED, class_name
from corsmal.figures.style import CONTAINER, TRUTH, VIEW_COLOURS, rgb

SIZE = (360, 640)
GREY = 100
BOXES = np.array([[230.0, 130, 270, 230], [300, 130, 340, 230], [370, 130, 410, 230]])
MIDDLES = [(180, 250), (180, 320), (180, 390)]
"""Row and column of the middle of each box."""


@pytest.fixture
def grey():
    return np.full((*SIZE, 3), GREY, dtype=np.uint8)


def three():
    """The second is the container, the first is kept beside it, the third scores too low."""
    masks = np.zeros((3, *SIZE), dtype=bool)
    for mask, (left, top, right, bottom) in zip(masks, BOXES.astype(int), strict=True):
        mask[top:bottom, left:right] = True
    return Detections(BOXES, [0.8, 0.9, 0.3], [47, 47, 47], masks)


def mixed(colour, opacity):
    return [(1 - opacity) * GREY + opacity * value for value in rgb(colour)]


def test_the_container_is_strong_others_plain_and_rejected_ones_dimmed(grey):
    detections = three()
    picture = draw_detections(grey, detections, filter_detections(detections))
    expected = [mixed(VIEW_COLOURS["view1"], FILL), mixed(CONTAINER, FILL), mixed(TRUTH, FILL_DROPPED)]
    for place, colour in zip(MIDDLES, expected, strict=True):
        np.testing.assert_allclose(picture[place], colour, atol=1)
    changes = [np.abs(picture[place].astype(int) - GREY).max() for place in MIDDLES]
    assert changes[2] < min(changes[:2])
    assert (picture[300, :] == GREY).all()


def test_the_containers_box_is_drawn_thicker(grey):
    detections = three()
    row = draw_detections(grey, detections, filter_detections(detections))[200].max(axis=1)
    changed = [(row[left - 10 : left] != GREY).sum() for left in (230, 300)]
    assert changed[1] > changed[0]


def test_the_container_is_painted_over_the_others(grey):
    masks = np.zeros((2, *SIZE), dtype=bool)
    masks[:, 130:230, 280:360] = True
    detections = Detections([[280, 130, 360, 230]] * 2, [0.9, 0.8], [47, 86], masks)
    picture = draw_detections(grey, detections, filter_detections(detections))
    under = np.array(mixed(VIEW_COLOURS["view1"], FILL))
    np.testing.assert_allclose(picture[180, 320], (1 - FILL) * under + FILL * np.array(rgb(CONTAINER)), atol=2)


def test_the_picture_that_was_given_stays_as_it_was(grey):
    detections = three()
    assert draw_detections(grey, detections, filter_detections(detections)) is not grey
    assert (grey == GREY).all()


def test_nothing_detected_changes_nothing(grey):
    nothing = Detections([], [], [], np.zeros((0, *SIZE), dtype=bool))
    np.testing.assert_array_equal(draw_detections(grey, nothing, filter_detections(nothing)), grey)


@pytest.mark.parametrize("box", [(-40, -30, 20, 20), (600, 340, 700, 400), (0, 0, 640, 360), (320, 180, 320, 180)])
def test_boxes_that_leave_the_image_and_empty_masks_are_drawn(grey, box):
    detections = Detections([box], [0.9], [47], np.zeros((1, *SIZE), dtype=bool))
    picture = draw_detections(grey, detections, filter_detections(detections, centre_rule="none"))
    assert (picture != GREY).any()


def test_another_size_than_the_masks_is_refused(grey):
    detections = three()
    with pytest.raises(ArgumentError, match=r"\(360, 640\).*\(359, 640\)"):
        draw_detections(grey[:-1], detections, filter_detections(detections))


def decoded(content):
    return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR_RGB)


def test_jpeg_keeps_size_and_colours():
    image = np.zeros((40, 60, 3), dtype=np.uint8)
    image[:] = (200, 60, 20)
    shown = decoded(jpeg(image))
    assert shown.shape == image.shape
    np.testing.assert_allclose(shown.reshape(-1, 3).mean(axis=0), (200, 60, 20), atol=4)


@pytest.mark.parametrize(("width", "shape"), [(30, (20, 30, 3)), (60, (40, 60, 3)), (90, (40, 60, 3))])
def test_jpeg_is_made_smaller_but_never_larger(width, shape):
    assert decoded(jpeg(np.zeros((40, 60, 3), dtype=np.uint8), width=width)).shape == shape


def test_jpeg_takes_a_part_of_an_image():
    image = np.zeros((40, 60, 3), dtype=np.uint8)
    assert decoded(jpeg(image[10:20, 5:40])).shape == (10, 35, 3)


def test_classes_have_names():
    assert class_name(47) == "cup"
    assert class_name(1) == "class 1"
