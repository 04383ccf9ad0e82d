"""Detection that begins by itself: where, when it stops, and what a visitor sees of it."""

import shutil
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

import corsmal.detection
from corsmal.dataset import open_dataset
from corsmal.demo.opening import PACK
from corsmal.detection import Detections
from corsmal.parameters import METHOD_VIEWS, PAIRS
from corsmal.stages.settings import find_detector
from corsmal.ui import detecting, shared
from corsmal.ui.detecting import can_inspect_frame, inspect_frame
from corsmal.ui.opened import OpenedRecording
from tests.app.driver import Visitor
from tests.app.test_detecting import FakeDetector, is_done
from tests.tiny import FRAMES, write_tiny_dataset

SEARCHED = 6 * len(METHOD_VIEWS)
FIND = "Find the best frame"


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> Iterator[type[FakeDetector]]:
    """Stands for the demo's detector."""
    yield from stand_in(monkeypatch, "SmallDetector", name="small Mask R-CNN, a test's", digest="small")


@pytest.fixture
def coco(monkeypatch: pytest.MonkeyPatch) -> Iterator[type[FakeDetector]]:
    """Stands for Mask R-CNN with COCO weights."""
    yield from stand_in(monkeypatch, "MaskRCNNDetector", name="Mask R-CNN, a test's", digest="coco")


def stand_in(monkeypatch: pytest.MonkeyPatch, detector: str, **about: str) -> Iterator[type[FakeDetector]]:
    """A fake in the place of a detector, with a gate of its own that is open at the end."""
    fake: type[FakeDetector] = type("Fake", (FakeDetector,), {"gate": threading.Event(), **about})
    monkeypatch.setitem(vars(corsmal.detection), detector, fake)
    yield fake
    fake.gate.set()


@pytest.fixture
def real(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Three recordings of real containers that nobody inspected, and a folder without weights."""
    monkeypatch.setenv("CORSMAL_WEIGHTS", str(tmp_path / "weights"))
    root = write_tiny_dataset(tmp_path / "data")
    for path in root.glob("view*/detections/*.json"):
        path.unlink()
    return root


@pytest.fixture
def synthetic(real: Path) -> Path:
    """The same, as if they were rendered."""
    (real / "truth").mkdir()
    for recording in ("000000", "000001", "000002"):
        shutil.copy(PACK / "recordings" / "truth" / "000000.json", real / "truth" / f"{recording}.json")
    return real


def inspected(root: Path, recording: str = "000000") -> int:
    """Frames of all views that are kept."""
    detections = OpenedRecording(open_dataset(root)[recording]).detections
    return sum(map(len, detections.views.values()))


@pytest.mark.parametrize("page", ["overview", "recordings", "frames", "shape", "filling", "mass"])
def test_every_page_of_a_synthetic_recording_begins_with_it(
    synthetic: Path, small: type[FakeDetector], page: str
) -> None:
    small.stops_at = 9
    visitor = Visitor(synthetic).open(page)
    visitor.wait_for(lambda _visitor: small.seen >= 9)
    visitor.test.run()
    assert visitor.progress[0].startswith("Detecting containers: ")
    assert "Stop" in visitor.buttons
    assert FIND not in visitor.buttons
    small.gate.set()
    visitor.wait_for(is_done)
    assert inspected(synthetic) == small.seen == SEARCHED
    assert visitor.crashes == visitor.errors == []


def test_the_overview_fills_while_it_is_found(synthetic: Path, small: type[FakeDetector]) -> None:
    small.stops_at = 6
    visitor = Visitor(synthetic, begins="overview")
    visitor.wait_for(lambda visitor: visitor.progress and "mL" in visitor.metrics["Capacity"])
    assert inspected(synthetic) == 6
    small.gate.set()
    visitor.wait_for(is_done)
    assert visitor.crashes == visitor.errors == []


def test_a_recording_that_was_searched_is_not_searched_again(synthetic: Path, small: type[FakeDetector]) -> None:
    Visitor(synthetic, begins="overview").wait_for(is_done)
    shared.jobs.cache_clear()  # as after a new start of the server
    Visitor(synthetic, begins="overview")
    assert shared.jobs().get(OpenedRecording(open_dataset(synthetic)["000000"]).job_key) is None
    assert small.seen == SEARCHED


def test_a_slow_detector_stops_after_its_first_batch_and_the_page_offers_it_with_its_time(
    synthetic: Path, small: type[FakeDetector], monkeypatch: pytest.MonkeyPatch
) -> None:
    inspector = shared.inspector(find_detector("demo"))
    monkeypatch.setattr(type(inspector), "frame_s", property(lambda _self: 4.0 if small.seen else None), raising=False)
    visitor = Visitor(synthetic, begins="overview")
    visitor.wait_for(is_done)
    assert inspected(synthetic) == small.seen == 1
    frames = 3 * (2 + 4 * 2 * len(PAIRS))
    [offer] = [label for label in visitor.buttons if label.startswith(FIND)]
    assert offer == f"{FIND} (about {round(4.0 * frames / 60)} min)"
    assert visitor.crashes == visitor.errors == visitor.warnings == []
    other = Visitor(synthetic, begins="overview", recording="000001")
    assert not any("Detecting" in text for text in other.progress)
    assert small.seen == 1
    assert any(label.startswith(FIND) for label in other.buttons)
    visitor.press(offer)
    visitor.wait_for(is_done)
    assert inspected(synthetic) == SEARCHED


def test_nothing_begins_by_itself_on_real_people_without_cocos_weights(
    real: Path, small: type[FakeDetector], coco: type[FakeDetector]
) -> None:
    visitor = Visitor(real, begins="overview").open("frames")
    assert visitor.progress == []
    assert small.seen == coco.seen == 0
    assert "None starts by itself, because the COCO weights" in visitor.sentences
    assert str(real.parent / "weights") in visitor.sentences
    visitor.choose("detector", "demo")
    visitor.press(FIND)
    visitor.wait_for(is_done)
    assert (small.seen, coco.seen) == (SEARCHED, 0)
    assert "This detector was trained on synthetic recordings only." in visitor.sentences


def test_mask_rcnn_begins_on_real_people_where_its_weights_are(real: Path, coco: type[FakeDetector]) -> None:
    (real.parent / "weights").mkdir()
    (real.parent / "weights" / "maskrcnn_resnet50_fpn_coco-bf2d0c1e.pth").touch()
    visitor = Visitor(real, begins="overview")
    visitor.wait_for(is_done)
    assert coco.seen == inspected(real) == SEARCHED
    assert visitor.crashes == visitor.errors == visitor.warnings == []


def test_stepping_through_recordings_leaves_no_queue_behind(synthetic: Path, small: type[FakeDetector]) -> None:
    small.stops_at = 0
    visitor = Visitor(synthetic, begins="overview")
    keys = [OpenedRecording(recording).job_key for recording in open_dataset(synthetic)]
    for recording in ("000001", "000002"):
        visitor.test.sidebar.selectbox(key="picker").set_value(recording).run()
    jobs = [shared.jobs().get(key) for key in keys]
    assert [job is not None and job.is_left for job in jobs] == [True, True, False]
    small.gate.set()
    visitor.wait_for(is_done)
    assert [job.state for job in jobs if job] == ["cancelled", "cancelled", "done"]
    assert inspected(synthetic, "000002") == SEARCHED
    assert inspected(synthetic, "000001") == 0
    visitor.test.sidebar.selectbox(key="picker").set_value("000000").run()
    visitor.wait_for(is_done)
    assert inspected(synthetic) == SEARCHED
    assert visitor.crashes == visitor.errors == []


def test_another_session_that_still_shows_the_recording_keeps_its_search(
    synthetic: Path, small: type[FakeDetector]
) -> None:
    small.stops_at = 1
    stays = Visitor(synthetic, begins="overview")
    leaves = Visitor(synthetic, begins="overview")
    leaves.test.sidebar.selectbox(key="picker").set_value("000001").run()
    small.gate.set()
    stays.wait_for(is_done)
    assert inspected(synthetic) == SEARCHED
    assert inspected(synthetic, "000001") == SEARCHED * 2 // 3  # it lacks a view
    assert stays.crashes == leaves.crashes == []


def test_a_search_that_was_stopped_does_not_begin_again_by_itself(synthetic: Path, small: type[FakeDetector]) -> None:
    small.stops_at = 1
    visitor = Visitor(synthetic, begins="overview")
    visitor.press("Stop")
    small.gate.set()
    visitor.wait_for(is_done)
    seen = small.seen
    visitor.open("shape").test.run()
    assert visitor.progress == []
    assert small.seen == seen < SEARCHED
    assert FIND in visitor.buttons


def test_a_detector_that_fails_is_one_sentence_and_nothing_red(
    synthetic: Path, small: type[FakeDetector], monkeypatch: pytest.MonkeyPatch
) -> None:
    def breaks(_detector: object, _frames: Sequence[Any]) -> list[Detections]:
        raise MemoryError

    monkeypatch.setattr(small, "detect", breaks)
    visitor = Visitor(synthetic, begins="overview")
    visitor.wait_for(is_done)
    assert visitor.crashes == visitor.errors == []
    assert ["stopped unexpectedly" in warning for warning in visitor.warnings] == [True]
    assert FIND in visitor.buttons


def test_a_video_that_cannot_be_opened_is_named_and_the_others_are_inspected(
    synthetic: Path, small: type[FakeDetector]
) -> None:
    video = synthetic / "view1" / "rgb" / "000000.mp4"
    video.write_bytes(b"no video")
    visitor = Visitor(synthetic, begins="overview")
    visitor.wait_for(is_done)
    assert visitor.crashes == []
    assert any(str(video) in warning for warning in visitor.warnings)
    assert inspected(synthetic) == small.seen == SEARCHED * 2 // 3


def test_one_frame_is_inspected_with_the_detector_that_is_used_here(
    synthetic: Path, small: type[FakeDetector], coco: type[FakeDetector]
) -> None:
    visitor = Visitor(synthetic, begins="overview")
    visitor.wait_for(is_done)
    opened = OpenedRecording(open_dataset(synthetic)["000000"])
    frame = 7
    assert can_inspect_frame(opened, frame)
    job = inspect_frame(opened, frame)
    visitor.wait_for(is_done)
    assert (job.state, job.done, job.total) == ("done", 3, 3)
    assert small.seen == SEARCHED + 3
    assert coco.seen == 0
    again = OpenedRecording(opened.recording)
    assert all(frame in view for view in again.detections.views.values())
    assert not can_inspect_frame(again, frame)
    assert not can_inspect_frame(again, FRAMES)


def test_a_view_with_a_file_is_not_to_be_inspected(tiny_dataset_root: Path) -> None:
    opened = OpenedRecording(open_dataset(tiny_dataset_root)["000000"])
    assert not can_inspect_frame(opened, 0)
    assert detecting.is_detecting(opened) is False
