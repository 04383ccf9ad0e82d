"""Detectors of other packages, by name."""

from importlib.metadata import EntryPoint

import numpy as np
import pytest

from corsmal.detection import entry_points, open_own_detector, own_detectors
from corsmal.errors import ArgumentError, NotFoundError
from corsmal.stages.settings import DetectorSettings, find_detector
from tests.fakes import FakeDetector


def open_fake(weights=None, *, device=None):
    found = FakeDetector()
    found.opened_with = (weights, device)
    return found


def open_nothing(_weights=None, *, device=None):
    return device


@pytest.fixture(autouse=True)
def installed(monkeypatch):
    """Three entry points, as packages would have installed them."""
    names = {"fake": "open_fake", "nothing": "open_nothing", "gone": "open_gone"}
    found = [EntryPoint(name, f"{__name__}:{value}", entry_points.GROUP) for name, value in names.items()]
    monkeypatch.setattr(entry_points, "entry_points", lambda group: found if group == entry_points.GROUP else [])


def test_a_detector_is_opened_by_its_name(tmp_path):
    assert own_detectors() == ("fake", "gone", "nothing")
    detector = DetectorSettings("fake", tmp_path / "weights").open(device="cpu")
    assert detector.opened_with == (tmp_path / "weights", "cpu")
    assert find_detector("fake") == DetectorSettings("fake", None, find_detector("fake").every)
    frame = np.zeros((48, 64, 3), dtype=np.uint8)
    assert len(detector.detect([frame])) == 1


@pytest.mark.parametrize(
    ("name", "error", "message"),
    [
        ("other", NotFoundError, "there is no detector 'other': there are coco, demo, fake, gone, nothing"),
        ("nothing", ArgumentError, r"'nothing' \(.*:open_nothing\) has no name, digest, detect"),
        ("gone", ArgumentError, r"'gone' \(.*:open_gone\) could not be opened: .*open_gone"),
    ],
)
def test_what_is_no_detector_is_one_sentence(name, error, message):
    with pytest.raises(error, match=message):
        open_own_detector(name)
