"""The built-in demo: opened ready-made, switched to its full version, which is made on request in the background."""

import shutil
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from corsmal import synthetic
from corsmal.demo.packing import IDS
from corsmal.errors import FileError
from corsmal.estimation import Fit
from corsmal.parameters import ShapeParameters
from corsmal.stages import fits
from corsmal.ui import demo, shared
from corsmal.ui.folders import demo_folder, full_demo_folder
from tests.app.conftest import small_demo
from tests.app.driver import PAGES, Visitor


class Making:
    """The making of the full demo, held at the gate until the test opens it."""

    def __init__(self) -> None:
        self.calls: list[dict[str, Any]] = []
        self.gate = threading.Event()

    def __call__(self, root: Path, **options: Any) -> tuple[str, ...]:
        self.calls.append(options)
        assert self.gate.wait(60)
        return small_demo(root, **options)


@pytest.fixture
def making(monkeypatch: pytest.MonkeyPatch) -> Iterator[Making]:
    made = Making()
    monkeypatch.setattr(synthetic, "write_demo", made)
    yield made
    made.gate.set()


def is_at_rest(_visitor: Visitor) -> bool:
    job = shared.jobs().get(demo.KEY)
    return job is not None and not job.active


@pytest.mark.parametrize("page", PAGES)
def test_every_page_shows_results_at_its_first_visit_and_nothing_red(page: str) -> None:
    visitor = Visitor().open(page)
    look = visitor.look()
    assert look.crashes == look.errors == look.warnings == []
    assert "synthetic" in look.sentences
    assert "No detections" not in look.sentences
    assert visitor.progress == []
    shown = {
        "overview": {"overview_hull", "overview_known_when"} <= look.plots and "mL" in look.metrics["Capacity"],
        "recordings": look.videos == 3 and look.sounds == 1 and len(visitor.test.dataframe[0].value) == len(IDS),
        "frames": "scores" in look.plots and look.pictures == 3,
        "shape": "hull" in look.plots and "mL" in look.metrics["Capacity"],
        "filling": "timeline" in look.plots and "%" in look.metrics["Filling type"],
        "mass": "restoration" in look.plots and "g" in look.metrics["Container mass"],
        "evaluation": len(visitor.test.dataframe) > 0,
    }
    assert shown[page]


@pytest.mark.parametrize(
    ("address", "plot"), [({"section": "Attribution"}, "attribution_average"), ({"view": "rules"}, "rules_effects")]
)
def test_what_takes_long_is_there_at_the_first_visit(address: dict[str, str], plot: str) -> None:
    visitor = Visitor(**address).open("evaluation")
    assert visitor.crashes == visitor.errors == visitor.progress == []
    assert plot in visitor.plots


@pytest.mark.parametrize("name", IDS)
def test_no_outline_is_fitted_for_what_pages_show_first(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The paper's circumferences take a few hundredths of a second, outlines far longer. Failed fits are not kept."""
    fit_masks = fits.fit_masks

    def fitted(*arguments: Any, shape: ShapeParameters, **options: Any) -> Fit:
        fit = fit_masks(*arguments, shape=shape, **options)
        assert shape.method == "circumferences" or not fit.ok, options
        return fit

    monkeypatch.setattr(fits, "fit_masks", fitted)
    visitor = Visitor(recording=name)
    for page in ("frames", "shape", "mass"):
        assert visitor.open(page).crashes == []


def test_the_two_runs_are_listed() -> None:
    visitor = Visitor().open("evaluation")
    names = [option.split(" · ")[0] for option in visitor.widget("run_picker").options]
    assert sorted(names) == ["paper", "tuned"]


def test_nothing_is_made_before_somebody_asks(making: Making) -> None:
    visitor = Visitor()
    assert visitor.test.text_input(key="data_folder").value == str(demo_folder())
    assert shared.jobs().get(demo.KEY) is None
    assert making.calls == []
    assert not full_demo_folder().exists()


def test_the_full_demo_is_made_on_request_in_one_process_and_opened(making: Making) -> None:
    visitor = Visitor()
    visitor.press(demo.MAKE)
    assert visitor.progress == ["Making the demo …"]
    assert demo.MAKE not in visitor.buttons
    assert making.calls[0]["workers"] == 1
    making.gate.set()
    visitor.wait_for(is_at_rest)
    visitor.test.run()
    visitor.press("Open the full demo")
    assert visitor.test.text_input(key="data_folder").value == str(full_demo_folder())
    assert visitor.address == {"recording": "000000"}
    assert (visitor.count("video"), visitor.count("audio")) == (3, 1)
    assert "synthetic" in visitor.sentences
    assert visitor.progress[0].startswith("Detecting containers")
    visitor.press("Open the ready-made six")
    assert visitor.test.text_input(key="data_folder").value == str(demo_folder())
    assert visitor.crashes == visitor.errors == []


def test_progress_counts_recordings_and_work_and_says_how_long(monkeypatch: pytest.MonkeyPatch) -> None:
    steps, gates = [None, 125.0], [threading.Event(), threading.Event()]

    def half(_root: Path, *, progress: Any, **_options: Any) -> tuple[str, ...]:
        for left_s, gate in zip(steps, gates, strict=True):
            progress(synthetic.DemoProgress(done=7, total=30, fraction=0.254, left_s=left_s))
            assert gate.wait(60)
        return ()

    monkeypatch.setattr(synthetic, "write_demo", half)
    visitor = Visitor()
    visitor.press(demo.MAKE)
    visitor.wait_for(lambda visitor: "%" in "".join(visitor.progress))
    assert visitor.progress == ["Making the demo, 7 of 30 recordings: 25 %"]
    gates[0].set()
    visitor.wait_for(lambda visitor: "left" in "".join(visitor.progress))
    assert visitor.progress == ["Making the demo, 7 of 30 recordings: 25 %, about 2 min left"]
    gates[1].set()


def test_two_visitors_start_one_job_and_both_watch_it(making: Making) -> None:
    first, second = Visitor(), Visitor()
    first.press(demo.MAKE)
    second.press(demo.MAKE)
    assert first.progress == second.progress == ["Making the demo …"]
    assert len(making.calls) == 1


def test_failed_making_is_tried_again_on_request(monkeypatch: pytest.MonkeyPatch) -> None:
    outcomes = [FileError("/full/disk", "cannot be written (No space left on device); free the disk")]

    def failing(root: Path, **options: Any) -> tuple[str, ...]:
        if outcomes:
            raise outcomes.pop()
        return small_demo(root, **options)

    monkeypatch.setattr(synthetic, "write_demo", failing)
    visitor = Visitor()
    visitor.press(demo.MAKE)
    visitor.wait_for(lambda visitor: visitor.errors)
    assert visitor.errors == ["/full/disk: cannot be written (No space left on device); free the disk"]
    visitor.press(demo.MAKE)
    visitor.wait_for(is_at_rest)
    visitor.test.run()
    assert "Open the full demo" in visitor.buttons
    assert visitor.errors == visitor.crashes == []


def test_second_start_uses_what_is_there() -> None:
    Visitor()
    video = demo_folder() / "view3" / "rgb" / f"{IDS[0]}.mp4"
    inode = video.stat().st_ino
    shared.store.cache_clear()
    Visitor()
    assert video.stat().st_ino == inode


def test_cache_that_cannot_be_written_is_one_sentence_and_another_folder_still_opens(
    tmp_path: Path, sound_root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_bytes(b"")
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path / "file" / "cache"))
    visitor = Visitor()
    assert visitor.crashes == []
    assert len(set(visitor.errors)) == 1
    assert str(tmp_path / "file" / "cache") in visitor.errors[0]
    assert "cannot be written" in visitor.errors[0]
    assert "set CORSMAL_CACHE to a folder that can be written" in visitor.errors[0]
    for page in ("frames", "shape"):
        assert visitor.open(page).crashes == []
    visitor.test.text_input(key="data_folder").set_value(str(sound_root)).run()
    assert "Capacity" in visitor.metrics


def test_deleted_cache_is_filled_anew() -> None:
    visitor = Visitor()
    shutil.rmtree(shared.store().root)
    visitor.test.run()
    assert any(item.value == f"Recording {IDS[0]}" for item in visitor.test.subheader)
    assert visitor.crashes == visitor.errors == []


def test_demo_is_returned_to_from_another_folder(sound_root: Path) -> None:
    visitor = Visitor(sound_root, recording="000000", frame="2")
    assert "synthetic" not in visitor.sentences
    assert not demo_folder().exists()
    visitor.press("Open the demo")
    assert visitor.test.text_input(key="data_folder").value == str(demo_folder())
    assert "synthetic" in visitor.sentences
    assert "Open the demo" not in visitor.buttons


def test_clearing_the_folder_ends_the_demo() -> None:
    visitor = Visitor()
    visitor.test.text_input(key="data_folder").set_value("").run()
    assert visitor.crashes == visitor.errors == []
    assert "Name a dataset folder in the sidebar" in visitor.sentences
    assert "synthetic" not in visitor.sentences
    assert "Open the demo" in visitor.buttons
