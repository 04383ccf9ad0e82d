"""Detection from the page: offered while there is something to inspect, watched, stopped, and shown as it comes."""

import threading
import urllib.request
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from urllib.error import URLError

import numpy as np
import pytest

import corsmal.detection
from corsmal.dataset import open_dataset
from corsmal.detection import Detections
from corsmal.detection.coco_weights import COCO_WEIGHTS_URL
from corsmal.parameters import METHOD_VIEWS
from corsmal.stages.detections import POINTERS
from corsmal.stages.search import detect_recording
from corsmal.ui import shared
from corsmal.weights import bundled_path
from tests.app.driver import Visitor
from tests.tiny import CONTAINERS, CUP, FRAMES, base_in_frame, silhouette, tiny_cameras

WITHOUT_FILES = "000002"
OFFERS = {"Find the best frame", "Inspect all frames"}


class FakeDetector:
    """Finds the same cup in every frame, and waits at a gate from the frame on that a test names."""

    name, digest = "a test's detector", "1"
    seen, stops_at = 0, 10_000
    weights: tuple[object, ...] = ()
    gate = threading.Event()

    def __init__(self, *weights: object, device: str | None = None) -> None:
        del device
        type(self).weights = weights

    def detect(self, frames: Sequence[Any]) -> list[Detections]:
        kind = type(self)
        if kind.seen >= kind.stops_at:
            assert kind.gate.wait(60)
        kind.seen += len(frames)
        cup = CONTAINERS[0]
        mask = silhouette(tiny_cameras()["view3"], cup.profile, base_in_frame(cup, 0))
        rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
        box = [columns[0], rows[0], columns[-1] + 1, rows[-1] + 1]
        return [Detections([box], [0.9], [CUP], mask[None]) for _ in frames]


@pytest.fixture
def coco(monkeypatch: pytest.MonkeyPatch) -> Iterator[type[FakeDetector]]:
    class Coco(FakeDetector):
        gate = threading.Event()

    monkeypatch.setitem(vars(corsmal.detection), "MaskRCNNDetector", Coco)
    yield Coco
    Coco.gate.set()


@pytest.fixture
def visitor(request: pytest.FixtureRequest, tiny_dataset_root: Path) -> Visitor:
    """Looks at the frames of a recording without detections."""
    request.getfixturevalue("coco")
    return Visitor(tiny_dataset_root, recording=WITHOUT_FILES).open("frames")


def is_done(visitor: Visitor) -> bool:
    return not visitor.progress and not any(job.active for job in shared.jobs()._jobs.values())


def inspected(visitor: Visitor) -> int:
    """How many frames the page says were inspected in both views."""
    [note] = [metric.delta for metric in visitor.test.metric if metric.label.startswith("Best frame of")]
    _, _, counts = note.partition(" px, ")
    assert counts.endswith(f" of {FRAMES} frames inspected")
    return int(counts.split()[0])


def test_search_inspects_some_frames_and_then_the_others_on_request(visitor: Visitor, coco: type[FakeDetector]) -> None:
    assert set(visitor.buttons) >= OFFERS
    visitor.press("Find the best frame")
    visitor.wait_for(is_done)
    assert inspected(visitor) == 6  # 0 and 10, then 5, 3, 2 and 1 beside the best, which is the first of equals
    assert coco.seen == 6 * len(METHOD_VIEWS)
    assert "No detections yet" not in visitor.sentences
    assert "a test's detector" in visitor.sentences
    assert visitor.metrics["Best frame of view3 + view1"] == "0"
    assert set(visitor.buttons) >= OFFERS
    visitor.press("Inspect all frames")
    visitor.wait_for(is_done)
    assert inspected(visitor) == FRAMES
    assert coco.seen == FRAMES * len(METHOD_VIEWS)
    assert not OFFERS & set(visitor.buttons)
    assert "detector" not in [box.key for box in visitor.test.selectbox]
    assert visitor.crashes == visitor.errors == visitor.warnings == []


def test_frames_that_were_not_inspected_say_so(visitor: Visitor) -> None:
    visitor.press("Find the best frame")
    visitor.wait_for(is_done)
    visitor.go_to(FRAMES - 1)
    assert f"frame {FRAMES - 1} was not inspected" in visitor.sentences
    notes = {metric.label: metric.delta for metric in visitor.test.metric}
    assert notes[f"Frame {FRAMES - 1}"] == "not inspected in both views"
    assert visitor.crashes == visitor.errors == []


@pytest.mark.parametrize("page", ["frames", "shape"])
def test_stopped_detection_keeps_what_was_done(visitor: Visitor, coco: type[FakeDetector], page: str) -> None:
    coco.stops_at = 9
    visitor.open(page)
    visitor.press("Inspect all frames")
    visitor.wait_for(lambda _visitor: coco.seen >= 9)
    visitor.test.run()
    assert visitor.progress[0].startswith(f"Detecting containers: 9 of {FRAMES * len(METHOD_VIEWS)} frames")
    assert not OFFERS & set(visitor.buttons)
    visitor.press("Stop")
    coco.gate.set()
    visitor.wait_for(is_done)
    visitor.open("frames")
    assert 3 <= inspected(visitor) < FRAMES
    assert coco.seen < FRAMES * len(METHOD_VIEWS)
    assert set(visitor.buttons) >= OFFERS
    assert visitor.crashes == visitor.errors == visitor.warnings == []


def test_results_appear_while_the_work_goes_on(visitor: Visitor, coco: type[FakeDetector]) -> None:
    coco.stops_at = 9
    visitor.press("Inspect all frames")
    visitor.wait_for(lambda visitor: visitor.progress and any("Best frame" in name for name in visitor.metrics))
    visitor.wait_for(lambda _visitor: coco.seen >= 9)
    visitor.test.run()
    assert inspected(visitor) == 3  # frames 0, 8 and 4
    assert visitor.time_line["most_per_s"] == 10  # the search needs the cores
    assert visitor.crashes == []


def test_results_are_there_for_who_looked_at_something_else_meanwhile(
    visitor: Visitor, coco: type[FakeDetector], tiny_dataset_root: Path
) -> None:
    coco.stops_at = 9
    visitor.press("Inspect all frames")
    visitor.wait_for(lambda _visitor: coco.seen >= 9)
    visitor.open("recordings")
    coco.gate.set()
    visitor.wait_for(is_done)
    visitor.open("frames")
    assert inspected(visitor) == FRAMES
    assert visitor.time_line["most_per_s"] is None
    other = Visitor(tiny_dataset_root, recording=WITHOUT_FILES).open("frames")
    assert inspected(other) == FRAMES


def test_two_visitors_start_one_job_and_both_watch_it(
    visitor: Visitor, coco: type[FakeDetector], tiny_dataset_root: Path
) -> None:
    coco.stops_at = 0
    second = Visitor(tiny_dataset_root, recording=WITHOUT_FILES).open("frames")
    visitor.press("Inspect all frames")
    second.press("Inspect all frames")
    assert len(visitor.progress) == len(second.progress) == 1
    coco.gate.set()
    for one in (visitor, second):
        one.wait_for(is_done)
        assert inspected(one) == FRAMES
    assert coco.seen == FRAMES * len(METHOD_VIEWS)


@pytest.mark.parametrize("page", ["frames", "shape"])
def test_views_with_a_file_are_not_to_be_inspected(tiny_dataset_root: Path, page: str) -> None:
    visitor = Visitor(tiny_dataset_root, recording="000000").open(page)
    assert not OFFERS & set(visitor.buttons)
    assert "No detections yet" not in visitor.sentences


def test_view_whose_file_is_missing_is_named_and_inspected_alone(coco: type[FakeDetector], root: Path) -> None:
    (root / "view2" / "detections" / "000000.json").unlink()
    visitor = Visitor(root).open("frames")
    assert "No detections yet in view2." in visitor.sentences
    assert "view2/detections/000000.json" in visitor.sentences
    visitor.press("Inspect all frames")
    visitor.wait_for(is_done)
    assert coco.seen == 6
    assert not OFFERS & set(visitor.buttons)


def test_coco_is_the_first_choice_and_the_demos_network_can_be_chosen(
    visitor: Visitor, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Small(FakeDetector):
        pass

    monkeypatch.setitem(vars(corsmal.detection), "SmallDetector", Small)
    box = visitor.test.selectbox(key="detector")
    assert box.value == "coco"
    box.set_value("demo").run()
    visitor.press("Find the best frame")
    visitor.wait_for(is_done)
    assert Small.weights == (bundled_path("detector"),)
    assert inspected(visitor) == 6


def test_coco_weights_that_cannot_be_fetched_are_one_sentence(
    tiny_dataset_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def offline(*_arguments: object, **_options: object) -> None:
        raise URLError("[Errno -3] Temporary failure in name resolution")

    monkeypatch.setattr(urllib.request, "urlopen", offline)
    monkeypatch.setenv("CORSMAL_WEIGHTS", str(tmp_path / "weights"))
    visitor = Visitor(tiny_dataset_root, recording=WITHOUT_FILES).open("frames")
    visitor.press("Find the best frame")
    visitor.wait_for(is_done)
    assert visitor.crashes == []
    [error] = visitor.errors
    assert error.startswith(str(tmp_path / "weights" / "maskrcnn_resnet50_fpn_coco-bf2d0c1e.pth"))
    assert COCO_WEIGHTS_URL in error
    assert set(visitor.buttons) >= OFFERS


def test_detector_that_breaks_is_one_sentence_and_can_be_started_again(
    visitor: Visitor, coco: type[FakeDetector], monkeypatch: pytest.MonkeyPatch
) -> None:
    def breaks(_detector: object, _frames: object) -> list[Detections]:
        raise MemoryError

    with monkeypatch.context() as patched:
        patched.setattr(coco, "detect", breaks)
        visitor.press("Inspect all frames")
        visitor.wait_for(is_done)
    assert visitor.crashes == []
    [error] = visitor.errors
    assert "stopped unexpectedly" in error
    visitor.press("Inspect all frames")
    visitor.wait_for(is_done)
    assert visitor.errors == []
    assert inspected(visitor) == FRAMES


@pytest.mark.usefixtures("coco")
def test_video_that_cannot_be_opened_leaves_the_other_views(root: Path) -> None:
    for view in METHOD_VIEWS:
        (root / view / "detections" / "000000.json").unlink()
    video = root / "view1" / "rgb" / "000000.mp4"
    video.write_bytes(b"no video")
    visitor = Visitor(root).open("frames")
    visitor.press("Inspect all frames")
    visitor.wait_for(is_done)
    assert visitor.crashes == []
    assert any(str(video) in error for error in visitor.errors)
    assert "Best frame of view3 + view2" in visitor.metrics


@pytest.mark.parametrize("kinds", [POINTERS[:1], POINTERS])
def test_what_is_lost_of_kept_detections_is_said_and_not_taken_for_a_recording_nobody_inspected(
    tiny_dataset_root: Path, coco: type[FakeDetector], kinds: tuple[str, ...]
) -> None:
    recording = open_dataset(tiny_dataset_root)[WITHOUT_FILES]
    detect_recording(recording, coco(), store=shared.store())
    for kind in kinds:
        for path in (shared.store().root / kind).glob("*/*.json"):
            path.write_bytes(b"damaged")
    visitor = Visitor(tiny_dataset_root, recording=WITHOUT_FILES).open("frames")
    lost = [f"{name}: the detections that were kept cannot be read; run the detector again" for name in METHOD_VIEWS]
    assert sorted(visitor.warnings) == (sorted(lost) if kinds == POINTERS else [])
    assert "No detections yet" not in visitor.sentences
    assert "it was set aside, and what can be computed is computed again" in visitor.sentences
    assert set(visitor.buttons) >= OFFERS or kinds != POINTERS
    assert visitor.crashes == visitor.errors == []
