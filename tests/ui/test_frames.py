import numpy as np

from corsmal.detection import Detections
from corsmal.parameters import CENTRE_RULES
from corsmal.ui.frames import RULES, detections_table


def test_every_rung_of_the_ladder_is_explained():
    assert set(RULES) == set(CENTRE_RULES)


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
