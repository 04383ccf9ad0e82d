import numpy as np
import pytest

from corsmal.detection import Detections
from corsmal.parameters import CENTRE_RULES
from corsmal.ui.frames import KEYS, RULES, detections_table, stepped
from corsmal.ui.linked_plot import Click, PlotEvent


def pressed(key, count=1):
    return PlotEvent(key=(key, count))


def clicked(x):
    return PlotEvent(click=Click(x=x, y=100.0, curve=0))


@pytest.mark.parametrize(
    ("event", "frame"),
    [
        (PlotEvent(), 20),
        (pressed("ArrowRight"), 21),
        (pressed("ArrowLeft"), 19),
        (pressed("ArrowRight", 3), 23),
        (pressed("PageDown"), 30),
        (pressed("PageUp", 2), 0),
        (pressed("Home"), 0),
        (pressed("Home", 5), 0),
        (pressed("End"), 49),
        (pressed("x"), 20),
        (clicked(7), 7),
        (clicked(7.0), 7),
        (clicked("7"), 20),
        (clicked(None), 20),
    ],
)
def test_clicks_and_keys_move_to_a_frame(event, frame):
    assert stepped(20, event, frames=50) == frame


@pytest.mark.parametrize(
    ("frame", "event", "expected"),
    [
        (0, pressed("ArrowLeft"), 0),
        (49, pressed("ArrowRight"), 49),
        (45, pressed("PageDown", 1000), 49),
        (20, clicked(-3), 0),
        (20, clicked(1e9), 49),
        (200, PlotEvent(), 49),
        (0, pressed("End"), 49),
    ],
)
def test_a_frame_stays_within_the_video(frame, event, expected):
    assert stepped(frame, event, frames=50) == expected


def test_a_video_of_one_frame_has_nowhere_to_go():
    for key in KEYS:
        assert stepped(0, pressed(key), frames=1) == 0


def test_every_rung_of_the_ladder_is_explained():
    assert set(RULES) == set(CENTRE_RULES)


@pytest.mark.parametrize("x", [float("nan"), float("inf"), -float("inf")])
def test_a_click_at_no_number_goes_nowhere(x):
    assert stepped(20, clicked(x), frames=50) == 20


def test_every_detection_has_its_verdict():
    masks = np.zeros((4, 90, 90), dtype=bool)
    masks[:, 40:50, 40:50] = True
    masks[3, 0, 0] = True
    boxes = [[40, 40, 50, 50], [40, 40, 50, 50], [40, 70, 50, 80], [40, 40, 50, 50]]
    found = Detections(boxes, [0.8, 0.9, 0.95, 0.4], [86, 47, 44, 1], masks)
    table = detections_table(found, centre_rule="both thirds")
    assert list(table.index) == [1, 2, 3, 4]
    assert list(table["class"]) == ["vase", "cup", "bottle", "class 1"]
    assert list(table["score"]) == [0.8, 0.9, 0.95, 0.4]
    assert list(table["mask (px)"]) == [100, 100, 100, 101]
    assert list(table["verdict"][:2]) == ["kept", "the container"]
    assert "83 % of the height" in table["verdict"][3]
    assert table["verdict"][4] == "class 1 is no container"
    assert detections_table(found, centre_rule="horizontal third")["verdict"][3] == "the container"


def test_no_detections_are_an_empty_table():
    table = detections_table(Detections([], [], [], np.zeros((0, 90, 90), dtype=bool)), centre_rule="none")
    assert table.shape == (0, 4)
