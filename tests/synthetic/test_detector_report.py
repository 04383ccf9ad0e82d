import numpy as np
import pandas as pd
import pytest

from corsmal.detection import Detections
from corsmal.errors import ArgumentError
from corsmal.synthetic.render.frame import render_frame
from corsmal.synthetic.scene.scene import make_scene
from corsmal.synthetic.training.detector_report import detector_report, detector_table

FRAMES = 6


class Answers:
    """A detector that gives prepared answers, one per frame."""

    name = digest = "prepared"

    def __init__(self, masks):
        self._masks = iter(masks)

    def detect(self, frames):
        shape = frames[0].shape[:2]
        masks = np.array(next(self._masks), bool).reshape(-1, *shape)
        boxes = [[0.0, 0.0, 1.0, 1.0]] * len(masks)
        return [Detections(np.array(boxes).reshape(-1, 4), [0.9] * len(masks), [47] * len(masks), masks)]


@pytest.fixture(scope="module")
def nothing():
    return detector_report(Answers([()] * FRAMES), frames=FRAMES)


@pytest.fixture(scope="module")
def truths(nothing):
    return [
        render_frame(make_scene(row.seed, container=1 + index), row.view, row.frame)
        for index, row in enumerate(nothing.itertuples())
    ]


def test_containers_take_turns_and_nothing_is_found_where_nothing_is_detected(nothing):
    assert nothing["container"].nunique() == FRAMES
    assert not nothing["found"].any()
    assert nothing["iou"].isna().all()
    assert (nothing["false"] == 0).all()


def test_true_masks_are_found_in_every_frame_that_has_a_visible_one(truths):
    report = detector_report(Answers([(truth.visible,) for truth in truths]), frames=FRAMES)
    assert report["visible"].tolist() == [truth.visible.sum() > truth.amodal.sum() / 2 for truth in truths]
    assert (report["found"] == report["visible"]).all()
    assert (report["iou"].dropna() == 1).all()
    assert (report["false"] == 0).all()


def test_second_masks_and_masks_elsewhere_are_false(truths):
    elsewhere = [~truth.amodal for truth in truths]
    both = detector_report(
        Answers([(truth.visible, away) for truth, away in zip(truths, elsewhere, strict=True)]), frames=FRAMES
    )
    assert (both["false"] == 1).all()
    alone = detector_report(Answers([(away,) for away in elsewhere]), frames=FRAMES)
    assert (alone["false"] == 1).all()
    assert not alone["found"].any()


def test_table_is_by_container_and_over_all_frames():
    report = pd.DataFrame(
        {
            "container": ["cup", "cup", "box", "box"],
            "visible": [True, True, True, False],
            "found": [True, False, True, False],
            "iou": [0.8, np.nan, 0.6, np.nan],
            "false": [0, 2, 0, 0],
        }
    )
    table = detector_table(report)
    assert table.loc["cup"].to_dict() == {"frames": 2, "visible": 2, "recall": 0.5, "iou": 0.8, "false_per_frame": 1.0}
    assert table.loc["box", ["visible", "recall"]].tolist() == [1, 1]
    assert table.loc["all frames", ["frames", "visible"]].tolist() == [4, 3]
    assert table.loc["all frames", "recall"] == pytest.approx(2 / 3)
    assert table.loc["all frames", "iou"] == pytest.approx(0.7)
    assert table.loc["all frames", "false_per_frame"] == 0.5


def test_there_must_be_a_frame():
    with pytest.raises(ArgumentError, match="frames must be at least 1, got 0"):
        detector_report(Answers([]), frames=0)
