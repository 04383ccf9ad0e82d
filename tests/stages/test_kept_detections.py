"""Kept detections whose files, or the pointers to them, were damaged."""

import pytest

from corsmal.parameters import METHOD_VIEWS
from corsmal.stages.detections import POINTERS, detections_origin, load_detections, needs_detection
from corsmal.stages.estimates import Predictors, load_estimate
from corsmal.stages.search import detect_recording
from corsmal.store import Store
from tests.fakes import FakeDetector
from tests.test_store import DAMAGES
from tests.tiny import FRAMES

LOST = "the detections that were kept cannot be read; run the detector again"


@pytest.fixture
def recording(dataset):
    return dataset["000002"]


@pytest.fixture
def kept(recording, store):
    """A store with what a detector found in the recording."""
    detect_recording(recording, FakeDetector(), store=store)
    return store


def damage(store, kind, how, *, suffix="json"):
    paths = sorted((store.root / kind).glob(f"*/*.{suffix}"))
    assert len(paths) == len(METHOD_VIEWS)
    for path in paths:
        DAMAGES[how](path)


def frames(found):
    return {name: len(view) for name, view in found.views.items()}


@pytest.mark.parametrize("how", DAMAGES)
@pytest.mark.parametrize("kind", POINTERS)
def test_what_is_kept_is_found_again_where_one_pointer_was_damaged(recording, kept, kind, how):
    before = load_detections(recording, store=kept)
    damage(kept, kind, how)
    after = load_detections(recording, store=Store(kept.root))
    assert frames(after) == dict.fromkeys(METHOD_VIEWS, FRAMES)
    assert (after.key, after.notes, after.lost) == (before.key, (), ())
    other = Store(kept.root)
    assert load_detections(recording, store=other).key == before.key
    if kind == POINTERS[0]:  # the other one is not read where the first is whole
        assert len(list((kept.root / kind).glob("*/*.json"))) == len(METHOD_VIEWS)
        assert other.problems == ()


def test_a_pointer_that_is_gone_is_made_anew(recording, kept):
    for path in (kept.root / POINTERS[0]).glob("*/*.json"):
        path.unlink()
    assert frames(load_detections(recording, store=kept)) == dict.fromkeys(METHOD_VIEWS, FRAMES)
    assert kept.problems == ()
    assert len(list((kept.root / POINTERS[0]).glob("*/*.json"))) == len(METHOD_VIEWS)


@pytest.mark.parametrize("how", ["random", "link to nowhere", "folder", "pipe"])
def test_what_cannot_be_found_again_is_not_the_same_as_what_nobody_looked_for(recording, kept, how, tmp_path):
    never = load_detections(recording, store=Store(tmp_path / "never"))
    for kind in POINTERS:
        damage(kept, kind, how)
    first = load_detections(recording, store=kept)
    again = load_detections(recording, store=Store(kept.root))  # when everything was set aside
    for found in (first, again):
        assert (dict(found.views), found.lost) == ({}, tuple(recording.views))
        assert found.notes == tuple(f"{name}: {LOST}" for name in recording.views)
    assert first.key == again.key == detections_origin(recording, store=kept) != never.key
    assert (never.notes, never.lost) == ((), ())
    row = load_estimate(recording, Predictors(), store=kept)
    assert LOST in row["notes"]
    assert row["flags"] == "detections-incomplete"
    assert needs_detection(recording, FakeDetector.digest, store=kept)


def test_the_detector_run_again_finds_everything_inspected_before(recording, kept):
    for kind in POINTERS:
        damage(kept, kind, "random")
    detector = FakeDetector()
    detect_recording(recording, detector, store=kept)
    assert detector.seen == 0
    found = load_detections(recording, store=kept)
    assert (frames(found), found.lost, found.notes) == (dict.fromkeys(METHOD_VIEWS, FRAMES), (), ())


@pytest.mark.parametrize("how", DAMAGES)
def test_damaged_detections_are_said_and_detected_anew(recording, kept, how):
    damage(kept, "detections", how, suffix="parquet")
    for store in (kept, Store(kept.root)):
        found = load_detections(recording, store=store)
        assert found.lost == tuple(recording.views)
        assert len(found.notes) == len(METHOD_VIEWS)
    detector = FakeDetector()
    detect_recording(recording, detector, store=kept)
    assert detector.seen == FRAMES * len(METHOD_VIEWS)
    assert load_detections(recording, store=kept).notes == ()


def test_a_cache_that_was_deleted_is_one_in_which_nobody_looked(recording, kept):
    for path in kept.root.rglob("*"):
        if path.is_file():
            path.unlink()
    assert load_detections(recording, store=kept).lost == ()
