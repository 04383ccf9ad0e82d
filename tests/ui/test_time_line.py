from dataclasses import replace
from typing import Any

import pytest

from corsmal.selection import BestFrame, FrameScore
from corsmal.ui.time_line.marks import marks

PAIR = ("view3", "view1")


def best_at(frame: int | None, *, inspected: tuple[int, ...] = (0, 4, 8)) -> BestFrame:
    scores = tuple(FrameScore(one, (100, 100), (0, 0)) for one in inspected)
    return BestFrame(PAIR, frame, "both thirds", scores, "" if frame is not None else "no container")


def marked(best: BestFrame, **changes: Any) -> dict[str, Any]:
    return marks(best, **({"crop_s": None, "fps": 30.0, "frames": 10} | changes))


def test_the_best_and_the_inspected_frames_are_marked() -> None:
    assert marked(best_at(4)) == {"best": 4, "best_name": "Best", "inspected": [0, 4, 8], "crop": None}


def test_a_frame_that_fits_best_is_told_from_one_with_the_best_score() -> None:
    assert marked(replace(best_at(4), is_by_fit=True))["best_name"] == "Best fit"


def test_without_a_best_frame_the_inspected_ones_are_marked() -> None:
    for inspected in ([0, 4, 8], []):
        shown = marked(best_at(None, inspected=tuple(inspected)))
        assert (shown["best"], shown["inspected"], shown["crop"]) == (None, inspected, None)


def test_marks_beyond_the_end_are_left_out() -> None:
    shown = marked(best_at(8), frames=5)
    assert (shown["best"], shown["inspected"]) == (None, [0, 4])


@pytest.mark.parametrize(
    ("crop_s", "fps", "crop"),
    [
        ((0.1, 0.25), 30.0, [3, 7.5]),
        ((0.1, 99.0), 30.0, [3, 9]),
        ((5.0, 6.0), 30.0, None),
        ((0.1, 0.25), 0.0, None),
    ],
)
def test_a_crop_is_marked_as_far_as_there_are_frames(crop_s: tuple[float, float], fps: float, crop: object) -> None:
    found = marked(best_at(4), crop_s=crop_s, fps=fps)["crop"]
    assert found == (None if crop is None else pytest.approx(crop))
