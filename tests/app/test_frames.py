from pathlib import Path

import numpy as np
import pytest

from tests.app.driver import Visitor
from tests.tiny import CONTAINERS, FRAMES, base_in_frame, silhouette, tiny_cameras


@pytest.fixture
def visitor(tiny_dataset_root: Path) -> Visitor:
    return Visitor(tiny_dataset_root).open("frames")


def marked_frame(visitor: Visitor) -> int:
    """The frame that the page names above the pictures."""
    captions = [item.value for item in visitor.test.markdown if item.value.startswith("**view")]
    frames = {caption.split("frame ")[1].split()[0] for caption in captions}
    assert len(frames) == 1
    return int(frames.pop())


def test_best_frame_is_the_one_with_most_container_and_no_second_object(visitor: Visitor) -> None:
    cameras, cup = tiny_cameras(), CONTAINERS[0]
    pixels = {
        frame: [
            int(silhouette(cameras[view], cup.profile, base_in_frame(cup, frame)).sum()) for view in ("view3", "view1")
        ]
        for frame in range(FRAMES)
        if frame % 4 != 3  # in these a second object lies over the container's box
    }
    best = max(pixels, key=lambda frame: sum(pixels[frame]))
    metrics = {metric.label: (metric.value, metric.delta) for metric in visitor.test.metric}
    assert metrics["Best frame of view3 + view1"] == (
        str(best),
        f"score {sum(pixels[best]):,} px, {FRAMES} of {FRAMES} frames inspected",
    )
    first, second = pixels[best]
    assert metrics[f"Frame {best}"][1] == f"N {first:,} + N {second:,} − penalties 0"
    assert marked_frame(visitor) == best


def test_frame_with_a_second_object_shows_its_penalties(visitor: Visitor) -> None:
    visitor.report("scores", click={"x": 7, "y": 0.0, "curve": 0, "customdata": None, "point_index": 7})
    delta = next(metric.delta for metric in visitor.test.metric if metric.label == "Frame 7")
    assert not delta.endswith("− penalties 0")


def test_score_figure_has_a_point_for_every_frame(visitor: Visitor) -> None:
    traces = {trace["name"]: trace for trace in visitor.plots["scores"]["figure"]["data"]}
    for name in ("N, view3", "N, view1", "score of the pair"):
        np.testing.assert_array_equal(traces[name]["x"], np.arange(FRAMES))


def test_keys_step_and_stop_at_the_ends(visitor: Visitor) -> None:
    start = marked_frame(visitor)
    steps = [
        ("ArrowLeft", 3, start - 3),
        ("ArrowRight", 1, start - 2),
        ("Home", 1, 0),
        ("ArrowLeft", 1, 0),
        ("End", 1, FRAMES - 1),
        ("ArrowRight", 2, FRAMES - 1),
        ("PageUp", 1, FRAMES - 11),
    ]
    for key, count, expected in steps:
        visitor.report("scores", key={"key": key, "count": count})
        assert marked_frame(visitor) == expected
        assert visitor.address["frame"] == str(expected)
    assert visitor.crashes == []


def test_held_key_steps_and_only_its_release_writes_the_address(visitor: Visitor) -> None:
    start, address = marked_frame(visitor), visitor.address
    visitor.report("scores", key={"key": "ArrowLeft", "count": 3}, settled=False)
    assert marked_frame(visitor) == start - 3
    assert visitor.address == address
    visitor.report("scores", settled=True)
    assert marked_frame(visitor) == start - 3
    assert visitor.address == {**address, "frame": str(start - 3)}


def test_click_on_a_score_chooses_its_frame_once(visitor: Visitor) -> None:
    visitor.report("scores", click={"x": 5, "y": 3000.0, "curve": 0, "customdata": None, "point_index": 5})
    assert visitor.address["frame"] == "5"
    visitor.report("scores", key={"key": "ArrowRight", "count": 1})
    visitor.test.run()
    assert visitor.address["frame"] == "6"


def test_report_that_no_browser_sends_is_one_sentence(visitor: Visitor) -> None:
    visitor.report("scores", key={"nonsense": 1})
    assert visitor.crashes == []
    assert "reload the page" in visitor.errors[0]


def test_every_detection_is_listed_with_what_became_of_it(visitor: Visitor) -> None:
    visitor.report("scores", click={"x": 3, "y": 0.0, "curve": 0, "customdata": None, "point_index": 3})
    tables = [element.value for element in visitor.test.dataframe]
    assert len(tables) == 3
    for table in tables:
        assert list(table["class"]) == ["cup", "bottle", "book"]
        assert list(table["verdict"][:2]) == ["the container", "score 0.30 is below 0.50"]


def test_other_pair_is_chosen_for_the_page_and_the_address(visitor: Visitor) -> None:
    visitor.choose("pair_control", ("view3", "view2"))
    assert visitor.address["pair"] == "view3-view2"
    assert "Best frame of view3 + view2" in visitor.metrics
    assert "N, view2" in {trace["name"] for trace in visitor.plots["scores"]["figure"]["data"]}


def test_relaxed_centre_rule_is_said(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, recording="000001").open("frames")
    assert visitor.metrics["Centre rule"] == "horizontal third"


def test_recording_without_detections_offers_to_make_them(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, recording="000002").open("frames")
    assert visitor.crashes == visitor.errors == []
    assert "No detections yet in view3, view1, view2" in visitor.sentences
    assert {"Find the best frame", "Inspect all frames"} <= set(visitor.buttons)
    assert visitor.count("image", "imgs") == 3


def test_frames_without_detections_are_browsed_by_number_instead_of_by_score(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, recording="000002").open("frames")
    assert "scores" not in visitor.plots
    visitor.choose("frame_control", 7)
    assert marked_frame(visitor) == 7
    assert visitor.address == {"recording": "000002", "frame": "7"}
    assert "No best frame" in visitor.buttons


def test_pages_of_the_real_recording_step_through_its_frames(real_root: Path) -> None:
    visitor = Visitor(real_root).open("frames")
    visitor.report("scores", key={"key": "Home", "count": 1})
    visitor.report("scores", key={"key": "ArrowRight", "count": 28})
    assert marked_frame(visitor) == 28
    assert visitor.crashes == []
    assert visitor.errors == []
