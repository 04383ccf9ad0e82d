"""The first start: without a folder the app makes its demo in the background, and shows it."""

import shutil
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from corsmal.errors import FileError
from corsmal.ui import demo, shared
from corsmal.ui.folders import demo_folder
from tests.app.conftest import small_demo
from tests.app.driver import Visitor


class Making:
    """The making of the demo, held at the gate until the test opens it."""

    def __init__(self) -> None:
        self.calls, self.gate = 0, threading.Event()

    def __call__(self, root: Path, **options: Any) -> tuple[str, ...]:
        self.calls += 1
        assert self.gate.wait(60)
        return small_demo(root, **options)


@pytest.fixture
def making(monkeypatch: pytest.MonkeyPatch) -> Iterator[Making]:
    made = Making()
    monkeypatch.setattr(demo, "write_demo", made)
    yield made
    made.gate.set()


def is_shown(visitor: Visitor) -> bool:
    return any(item.value == "Recording 000000" for item in visitor.test.subheader)


def is_at_rest(_visitor: Visitor) -> bool:
    job = shared.jobs().get(demo.KEY)
    return job is not None and not job.active


def test_first_start_says_what_it_does_and_then_shows_the_first_recording(making: Making) -> None:
    visitor = Visitor()
    assert visitor.crashes == visitor.errors == []
    assert "synthetic" in visitor.sentences
    assert "The first recording of the demo is being made" in visitor.sentences
    assert visitor.progress == ["Making the demo …"]
    assert visitor.test.text_input(key="data_folder").value == str(demo_folder())
    making.gate.set()
    visitor.wait_for(is_shown)
    visitor.wait_for(is_at_rest)
    visitor.test.run()
    assert visitor.progress == visitor.errors == visitor.crashes == []
    assert "synthetic" in visitor.sentences
    assert "is being made" not in visitor.sentences
    assert visitor.address == {"recording": "000000"}
    assert (visitor.count("video"), visitor.count("audio")) == (3, 1)
    for page in ("frames", "shape"):
        assert visitor.open(page).crashes == []
        assert visitor.test.selectbox(key="detector").value == "demo"


def test_progress_counts_recordings_and_work(monkeypatch: pytest.MonkeyPatch) -> None:
    gate = threading.Event()

    def half(_root: Path, *, progress: Any, **_options: Any) -> tuple[str, ...]:
        progress(demo.DemoProgress(done=0, total=30, fraction=0.254))
        assert gate.wait(60)
        return ()

    monkeypatch.setattr(demo, "write_demo", half)
    visitor = Visitor()
    visitor.wait_for(lambda visitor: "%" in "".join(visitor.progress))
    [text] = visitor.progress
    assert text.startswith("Making the demo, 0 of 30 recordings: 25 of 100 %, about ")
    gate.set()


def test_second_start_uses_what_is_there(making: Making) -> None:
    making.gate.set()
    Visitor().wait_for(is_at_rest)
    video = demo_folder() / "view3" / "rgb" / "000000.mp4"
    made_ns = video.stat().st_mtime_ns
    shared.jobs.cache_clear()
    shared.store.cache_clear()
    visitor = Visitor()
    assert is_shown(visitor)
    visitor.wait_for(is_at_rest)
    assert video.stat().st_mtime_ns == made_ns


def test_demo_begun_ahead_of_the_first_visitor_is_the_one_that_visitors_see(making: Making) -> None:
    demo.begin()
    visitor = Visitor()
    assert visitor.progress
    making.gate.set()
    visitor.wait_for(is_shown)
    visitor.wait_for(is_at_rest)
    assert making.calls == 1


def test_two_visitors_start_one_job_and_both_watch_it(making: Making) -> None:
    first, second = Visitor(), Visitor()
    assert first.progress == second.progress == ["Making the demo …"]
    making.gate.set()
    for visitor in (first, second):
        visitor.wait_for(is_shown)
    assert making.calls == 1


def test_cache_that_cannot_be_written_is_one_sentence_and_another_folder_still_opens(
    tmp_path: Path, sound_root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_bytes(b"")
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path / "file" / "cache"))
    visitor = Visitor()
    visitor.wait_for(is_at_rest)
    visitor.test.run()
    assert visitor.crashes == []
    [error] = visitor.errors
    assert str(tmp_path / "file" / "cache" / "demo") in error
    assert "cannot be written" in error
    assert "is being made" not in visitor.sentences
    assert "Try again" in visitor.buttons
    for page in ("frames", "shape"):
        assert visitor.open(page).crashes == []
    visitor.test.text_input(key="data_folder").set_value(str(sound_root)).run()
    assert "Capacity" in visitor.metrics


def test_failed_making_is_tried_again_on_request_and_then_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    outcomes = [FileError("/full/disk", "cannot be written (No space left on device); free the disk")] * 2

    def failing(root: Path, **options: Any) -> tuple[str, ...]:
        if outcomes:
            raise outcomes.pop()
        return small_demo(root, **options)

    monkeypatch.setattr(demo, "write_demo", failing)
    visitor = Visitor()
    visitor.wait_for(lambda visitor: visitor.errors)
    assert visitor.errors == ["/full/disk: cannot be written (No space left on device); free the disk"]
    visitor.test.run()
    assert len(outcomes) == 1  # not before the visitor asks for it
    visitor.press("Try again")
    visitor.wait_for(lambda visitor: visitor.errors)
    visitor.press("Try again")
    visitor.wait_for(is_shown)
    assert visitor.errors == visitor.crashes == []


def test_deleted_cache_is_made_anew() -> None:
    visitor = Visitor()
    visitor.wait_for(is_shown)
    visitor.wait_for(is_at_rest)
    shutil.rmtree(shared.store().root)
    visitor.test.run()
    visitor.wait_for(is_shown)
    assert visitor.crashes == visitor.errors == []


def test_demo_is_returned_to_from_another_folder(sound_root: Path) -> None:
    visitor = Visitor(sound_root, recording="000000", frame="2")
    assert "synthetic" not in visitor.sentences
    assert shared.jobs().get(demo.KEY) is None
    visitor.press("Open the demo")
    assert visitor.test.text_input(key="data_folder").value == str(demo_folder())
    assert "synthetic" in visitor.sentences
    assert "Open the demo" not in visitor.buttons
    visitor.wait_for(is_shown)


def test_clearing_the_folder_ends_the_demo() -> None:
    visitor = Visitor()
    visitor.wait_for(is_shown)
    visitor.test.text_input(key="data_folder").set_value("").run()
    assert visitor.crashes == visitor.errors == []
    assert "Name a dataset folder in the sidebar" in visitor.sentences
    assert "synthetic" not in visitor.sentences
    assert "Open the demo" in visitor.buttons
