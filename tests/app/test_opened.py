"""How often a recording is opened, and its masks and hulls are read, in one run of a page or of a part of it."""

import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from corsmal.detection import record
from corsmal.store import Store
from corsmal.ui import opened
from tests.app.driver import PAGES, Visitor

SLIDERS = {"shape": ("hull", "circumferences", 60.0), "mass": ("restoration", "padding_px", 20.0)}


def figure_text(visitor: Visitor, plot: str) -> str:
    """The figure as it was sent to the browser."""
    components: list[Any] = list(visitor.test.get("bidi_component"))
    [sent] = [component.proto.json for component in components if component.key == plot]
    return str(json.loads(sent)["figure"])


@pytest.fixture
def counts(monkeypatch: pytest.MonkeyPatch) -> Counter[object]:
    """How often a recording was fingerprinted, each mask decoded, and a hull read from the store."""
    counted: Counter[object] = Counter()

    def count(owner: Any, name: str, key: Callable[..., object]) -> None:
        plain = getattr(owner, name)

        def counting(*args: Any, **options: Any) -> Any:
            counted[key(*args)] += 1
            return plain(*args, **options)

        monkeypatch.setattr(owner, name, counting)

    count(opened, "fingerprint", lambda _recording: "fingerprint")
    count(record, "decode_mask", lambda counts, _size: counts)
    count(Store, "arrays", lambda _store, kind, _key: kind)
    return counted


@pytest.mark.parametrize("page", [page for page in PAGES if page != "evaluation"])
def test_a_page_opens_its_recording_once(sound_root: Path, counts: Counter[object], page: str) -> None:
    visitor = Visitor(sound_root).open(page)
    visitor.wait_for(lambda visitor: not visitor.progress)  # a job in the background reads, too
    counts.clear()
    visitor.test.run()
    assert visitor.crashes == visitor.errors == []
    assert counts == {"fingerprint": 1}


@pytest.mark.parametrize("page", SLIDERS)
def test_a_slider_step_opens_the_recording_once_and_reads_nothing_again(
    sound_root: Path, counts: Counter[object], page: str
) -> None:
    visitor = Visitor(sound_root).open(page)
    plot, slider, value = SLIDERS[page]
    before = figure_text(visitor, plot)
    counts.clear()
    visitor.drag(plot, **{slider: value})
    assert visitor.crashes == visitor.errors == []
    assert figure_text(visitor, plot) != before
    assert [each["value"] for each in visitor.plots[plot]["sliders"] if each["name"] == slider] == [value]
    assert counts == {"fingerprint": 1}


def test_another_frame_decodes_each_mask_once(sound_root: Path, counts: Counter[object]) -> None:
    visitor = Visitor(sound_root, estimate="paper").open("shape")
    counts.clear()
    visitor.go_to(2)
    assert visitor.crashes == visitor.errors == []
    assert counts.pop("fingerprint") == 1
    assert counts.pop("fits") == 2  # the paper's hull and the one beside it: both are new
    assert sorted(counts.values()) == [1, 1, 1]  # the pair's masks, and the third view's, which `tuned` uses


def test_a_recording_whose_files_changed_is_another_one(root: Path) -> None:
    visitor = Visitor(root).open("shape")
    capacity = visitor.frame_measures["Capacity"]
    path = root / "view1" / "calib" / "000000.pickle"
    path.write_bytes((root / "view2" / "calib" / "000000.pickle").read_bytes())
    visitor.drag("hull", circumferences=145.0)
    assert visitor.frame_measures.get("Capacity") != capacity
