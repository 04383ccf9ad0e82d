from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import streamlit as st

from corsmal.estimation.view_offsets import ViewOffset
from corsmal.stages.settings import DetectorSettings
from corsmal.ui import frame_clock
from tests.app.driver import Visitor
from tests.fakes import FakeDetector
from tests.tiny import CONTAINERS, FRAMES, base_in_frame, silhouette, tiny_cameras


@pytest.fixture
def visitor(tiny_dataset_root: Path) -> Visitor:
    return Visitor(tiny_dataset_root).open("frames")


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
    assert visitor.frame == best


def test_frame_with_a_second_object_shows_its_penalties(visitor: Visitor) -> None:
    visitor.go_to(7)
    delta = next(metric.delta for metric in visitor.test.metric if metric.label == "Frame 7")
    assert not delta.endswith("− penalties 0")


def test_score_figure_has_a_point_for_every_frame(visitor: Visitor) -> None:
    traces = {trace["name"]: trace for trace in visitor.plots["scores"]["figure"]["data"]}
    for name in ("N, view3", "N, view1", "score of the pair"):
        np.testing.assert_array_equal(traces[name]["x"], np.arange(FRAMES))


@pytest.mark.parametrize(("frame", "expected"), [(-3, 0), (0, 0), (4, 4), (FRAMES, FRAMES - 1), (1e300, FRAMES - 1)])
def test_the_playhead_stays_within_the_video(visitor: Visitor, frame: int, expected: int) -> None:
    visitor.go_to(frame)
    assert visitor.frame == expected
    assert visitor.address["frame"] == str(expected)
    assert visitor.crashes == visitor.errors == []


def test_back_to_the_best_frame_leaves_the_address_without_one(visitor: Visitor) -> None:
    start, address = visitor.frame, visitor.address
    visitor.go_to(start - 1)
    visitor.report("time_line", values={"best": 1}, settled=True)
    assert visitor.frame == visitor.time_line["best"] == start
    assert visitor.address == address


def test_report_that_no_browser_sends_is_one_sentence(visitor: Visitor) -> None:
    visitor.report("time_line", values={"frame": "nonsense"})
    assert visitor.crashes == []
    assert "reload the page" in visitor.errors[0]


def test_every_detection_is_listed_with_what_became_of_it(visitor: Visitor) -> None:
    visitor.go_to(3)
    tables = [element.value for element in visitor.test.dataframe if "class" in element.value]
    assert len(tables) == 3
    for table in tables:
        assert list(table["class"]) == ["cup", "bottle", "book"]
        assert list(table["verdict"][:2]) == ["the container", "score 0.30 is below 0.50"]


def test_other_pair_is_chosen_for_the_page_and_the_address(visitor: Visitor) -> None:
    visitor.choose("pair_control", ("view3", "view2"))
    assert visitor.address["pair"] == "view3-view2"
    assert "Best frame of view3 + view2" in visitor.metrics
    assert "N, view2" in {trace["name"] for trace in visitor.plots["scores"]["figure"]["data"]}


def test_any_two_views_are_a_pair(visitor: Visitor) -> None:
    visitor.choose("pair_control", ("view1", "view2"))
    assert visitor.address["pair"] == "view1-view2"
    assert "Best frame of view1 + view2" in visitor.metrics


def rules_of(visitor: Visitor) -> pd.DataFrame:
    return next(element.value for element in visitor.test.dataframe if "rule" in element.value)


def test_each_rule_of_the_paper_says_what_it_makes_of_the_frame(visitor: Visitor) -> None:
    table = rules_of(visitor).set_index("rule")
    assert table.loc["container (both thirds)", "verdict"] == "✓ passed"
    assert table.loc["score of the pair", "verdict"].endswith("the best frame")
    visitor.go_to(visitor.frame + 1)
    assert "less than frame" in rules_of(visitor).set_index("rule").loc["score of the pair", "verdict"]


def test_rules_of_the_released_program_are_chosen_and_explained(visitor: Visitor) -> None:
    visitor.choose("selection_control", "released")
    assert visitor.address["selection"] == "released"
    assert visitor.metrics["Centre rule"] == "middle half"
    assert "Best frame of view1 + view2" in visitor.metrics
    table = rules_of(visitor).set_index("rule")
    assert table.loc["one frame per 1 s, and the last", "verdict"] == "✓ counts"
    assert "→" in table.loc["container (middle half; score → by place)", "view1"]
    best = visitor.frame
    visitor.go_to(1 if best != 1 else 2)
    assert "does not count" in rules_of(visitor).set_index("rule").loc["one frame per 1 s, and the last", "verdict"]
    assert visitor.crashes == visitor.errors == []
    visitor.choose("selection_control", "paper")
    assert "selection" not in visitor.address


def test_relaxed_centre_rule_is_said(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, recording="000001").open("frames")
    assert visitor.metrics["Centre rule"] == "horizontal third"


def test_recording_without_detections_offers_to_make_them(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, recording="000002").open("frames")
    assert visitor.crashes == visitor.errors == []
    assert "No detections yet in view3, view1, view2" in visitor.sentences
    assert {"Find the best frame", "Inspect all frames"} <= set(visitor.buttons)
    assert visitor.look().pictures == 3


def test_frames_without_detections_are_browsed_by_number_instead_of_by_score(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, recording="000002").open("frames")
    assert "scores" not in visitor.plots
    assert (visitor.time_line["best"], visitor.time_line["inspected"]) == (None, [])
    visitor.go_to(7)
    assert visitor.frame == 7
    assert visitor.address == {"recording": "000002", "frame": "7"}


def test_one_frame_is_inspected_on_request_and_marked(tiny_dataset_root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(DetectorSettings, "open", lambda _settings: FakeDetector())
    visitor = Visitor(tiny_dataset_root, recording="000002").open("frames")
    assert visitor.time_line["can_inspect"]
    visitor.report("time_line", values={"frame": 7, "inspect": 7}, settled=True)
    visitor.wait_for(lambda visitor: visitor.time_line["inspected"] == [7])
    assert visitor.crashes == visitor.errors == []
    assert visitor.frame == 7


def test_frames_that_a_view_does_not_have_are_not_offered_to_a_detector(
    tiny_dataset_root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(DetectorSettings, "open", lambda _settings: FakeDetector())
    visitor = Visitor(tiny_dataset_root, recording="000002", offset="view1:0.1").open("frames")
    visitor.press("Inspect all frames")
    visitor.wait_for(lambda visitor: "Centre rule" in visitor.metrics and not visitor.progress)
    assert not {"Find the best frame", "Inspect all frames"} & set(visitor.buttons)
    assert visitor.crashes == visitor.errors == []


def test_files_with_detections_leave_nothing_to_inspect(visitor: Visitor) -> None:
    assert not visitor.time_line["can_inspect"]
    assert visitor.time_line["inspected"] == list(range(FRAMES))


def test_views_are_matched_as_is_chosen_on_all_pages_and_in_the_address(visitor: Visitor) -> None:
    first, before = visitor.time_line["recording"], visitor.metrics
    assert visitor.test.table[0].value["frames"].tolist() == [FRAMES] * 3
    visitor.choose("offset view1", 0.1)
    assert visitor.address == {"recording": "000000", "offset": "view1:0.1"}
    assert visitor.time_line["recording"] != first
    assert visitor.test.table[0].value["matched"].tolist() == [FRAMES - 3, FRAMES, FRAMES]
    assert "frames are matched by time, view1 +0.1 s" in visitor.sentences
    assert visitor.metrics != before
    visitor.open("shape")
    assert visitor.address["offset"] == "view1:0.1"
    assert "view1 +0.1 s" in visitor.sentences
    visitor.open("frames").choose("match_control", "index")
    assert (visitor.address["match"], visitor.metrics) == ("index", before)
    assert visitor.widget("offset view1").disabled
    visitor.choose("match_control", "time")
    assert visitor.address == {"recording": "000000", "offset": "view1:0.1"}
    visitor.choose("offset view1", None)
    assert (visitor.address, visitor.metrics) == ({"recording": "000000"}, before)
    assert visitor.crashes == visitor.errors == []


def test_offsets_are_looked_for_on_request_and_only_suggested(
    visitor: Visitor, monkeypatch: pytest.MonkeyPatch
) -> None:
    visitor.press("Look for offsets")
    assert "None of more than a frame was found" in visitor.sentences  # twelve frames are too few
    st.cache_data.clear()
    st.cache_resource.clear()
    found = (ViewOffset("view1", "view3", 0.1),)
    monkeypatch.setattr(frame_clock, "find_offsets", lambda *_: found)
    visitor.test.run()
    assert (
        "view1 seems to have been filmed 0.10 s (3.0 frames) later than it is matched with view3" in visitor.sentences
    )
    assert "offset" not in visitor.address
    visitor.press("Use what was found")
    assert visitor.address["offset"] == "view1:0.1"
    assert "seems to have been filmed" not in visitor.sentences  # of the frames as they are matched now
    assert visitor.crashes == visitor.errors == []


def test_another_recording_is_matched_as_its_files_say(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, recording="000000", offset="view1:0.1").open("frames")
    assert "view1 +0.1 s" in visitor.sentences
    visitor.press("Next")
    assert visitor.address == {"recording": "000001"}
    assert "+0.1 s" not in visitor.sentences


def test_pages_of_the_real_recording_step_through_its_frames(real_root: Path) -> None:
    visitor = Visitor(real_root).open("frames")
    visitor.go_to(28)
    assert visitor.frame == 28
    assert [view["frames"] for view in visitor.time_line["views"]] == [77, 77, 77]
    assert visitor.crashes == []
    assert visitor.errors == []
