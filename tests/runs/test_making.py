from dataclasses import replace

import numpy as np
import pytest

from corsmal.by_hand import HandMask, MaskHistory
from corsmal.errors import ArgumentError, FileError, NotFoundError
from corsmal.parameters import METHOD_VIEWS, ShapeParameters
from corsmal.runs import list_runs, load_run, make_run, making
from corsmal.runs.making import data_digest
from corsmal.runs.run import Run
from corsmal.stages.detections import load_detections
from corsmal.stages.estimates import load_estimate
from corsmal.stages.settings import DetectorSettings
from corsmal.stages.version import METHOD_VERSION
from corsmal.store import Store
from corsmal.weights import WeightsFile
from tests.fakes import FakeDetector, FakeMass

IDS = ("000000", "000001", "000002")
WITHOUT_DETECTIONS = "000002"


@pytest.fixture
def detector(monkeypatch):
    made = FakeDetector()
    monkeypatch.setattr(DetectorSettings, "open", lambda _, **_options: made)
    return made


def untimed(rows):
    """Rows without how long each took, which no two computations share."""
    return [{**row, "execution_time_ms": None} for row in rows]


def ids_of(run):
    return [row["recording_id"] for row in run.rows]


def stop_after(count):
    """Cancelled once so many recordings are done, and what counts them."""
    done = []
    return {"progress": lambda step, _: done.append(step), "cancelled": lambda: bool(done) and done[-1] >= count}


def test_a_run_holds_the_estimates_and_what_they_were_made_with(dataset, settings, store, tmp_path):
    run = make_run("first", dataset, settings, store=store)
    other = Store(tmp_path / "other")
    again = [load_estimate(recording, settings.open(), store=other) for recording in dataset]
    assert untimed(run.rows) == untimed(again)
    assert (run.is_complete, run.recordings, run.preset) == (True, IDS, "paper")
    assert run.digests == {"filling": "fake filling (2, 1)", "mass": "fake mass 20.0", "detector": None}
    assert (run.data_digest, run.method_version, run.engine) == (data_digest(dataset), METHOD_VERSION, "in turn")
    assert load_run("first", dataset=dataset.root, store=store).rows == run.rows


def test_a_run_with_masks_by_hand_is_another_one_and_follows_their_changes(dataset, settings, store):
    recording = dataset["000000"]

    def draw(shrink):
        for name in METHOD_VIEWS:
            view, found = recording.views[name], load_detections(recording, store=store).views[name]
            for frame, detections in found.items():
                mask = detections.mask(0)
                mask[:, : np.flatnonzero(mask.any(axis=0))[0] + shrink] = False
                MaskHistory(recording.id, view, store=store).keep(HandMask.of(mask, frame=frame), after=0)

    hand = replace(settings, masks="by-hand")
    detected = make_run("detected", dataset, settings, store=store)
    draw(8)
    first = make_run("hand", dataset, hand, store=store)
    with pytest.raises(ArgumentError, match="different: masks"):
        make_run("detected", dataset, hand, store=store)
    assert first.rows[0]["flags"] == "by-hand"
    assert first.rows[0]["width_top_mm"] < detected.rows[0]["width_top_mm"]
    assert untimed(make_run("detected", dataset, settings, store=store).rows) == untimed(detected.rows)
    draw(16)
    assert make_run("hand", dataset, hand, store=store).rows[0]["width_top_mm"] < first.rows[0]["width_top_mm"]


def test_a_stopped_run_is_resumed_where_it_was(dataset, settings, store):
    stopped = make_run("first", dataset, settings, store=store, **stop_after(1))
    assert ids_of(stopped) == ["000000"]
    whole = make_run("first", dataset, settings, store=store)
    assert whole.is_complete
    assert whole.created == stopped.created
    again = make_run("first", dataset, settings, store=store, cancelled=lambda: True)
    assert again.rows == whole.rows  # what was there is not lost when it is stopped at once


def test_rows_are_kept_when_the_work_is_interrupted_or_the_engine_fails(dataset, settings, store):
    class Lost(Exception):  # noqa: N818 - stands for any
        pass

    for name, fault in (("keyboard", KeyboardInterrupt), ("engine", Lost)):

        def fail(done, _total, fault=fault):
            if done == 2:
                raise fault

        with pytest.raises(fault):
            make_run(name, dataset, settings, store=store, progress=fail)
        assert ids_of(load_run(name, dataset=dataset.root, store=store)) == ["000000", "000001"]


def test_rows_are_kept_as_the_work_goes(dataset, settings, store, monkeypatch):
    monkeypatch.setattr(making, "SAVE_EVERY_S", -1.0)
    kept = []

    def note(_done, _total):
        kept.append(len(load_run("first", dataset=dataset.root, store=Store(store.root)).rows))

    make_run("first", dataset, settings, store=store, progress=note)
    assert kept == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("what", "change"),
    [
        ("parameters", {"shape": ShapeParameters.lode()}),
        ("means", {"means": {}}),
        ("detector", {"detector": DetectorSettings()}),
    ],
)
@pytest.mark.usefixtures("detector")
def test_a_name_that_other_settings_took_is_refused(dataset, settings, store, what, change):
    make_run("first", dataset, settings, store=store, recordings=IDS[:1])
    with pytest.raises(ArgumentError, match=f"'first' is taken by a run with other settings .different: {what}.;"):
        make_run("first", dataset, replace(settings, **change), store=store, recordings=IDS[:1])
    with pytest.raises(ArgumentError, match="different: recordings"):
        make_run("first", dataset, settings, store=store, recordings=IDS[:2])


@pytest.mark.parametrize("is_earlier", [True, False])
def test_a_condition_that_only_one_of_two_runs_has_is_a_difference(dataset, settings, store, monkeypatch, is_earlier):
    make_run("first", dataset, settings, store=store, recordings=IDS[:1])
    plain = Run.conditions.fget

    def with_sight(run):
        return plain(run) | ({"sight": "clips"} if bool(run.rows) == is_earlier else {})

    monkeypatch.setattr(Run, "conditions", property(with_sight))
    with pytest.raises(ArgumentError, match="different: sight"):
        make_run("first", dataset, settings, store=store, recordings=IDS[:1])


def test_other_networks_and_another_version_are_other_settings(dataset, settings, store, monkeypatch, fake_networks):
    make_run("first", dataset, settings, store=store, recordings=IDS[:1])
    monkeypatch.setitem(fake_networks, "mass", FakeMass(7.0))
    with pytest.raises(ArgumentError, match="different: mass network"):
        make_run("first", dataset, settings, store=store, recordings=IDS[:1])
    monkeypatch.undo()
    monkeypatch.setattr(making, "METHOD_VERSION", METHOD_VERSION + 1)
    with pytest.raises(ArgumentError, match="different: version of the method"):
        make_run("first", dataset, settings, store=store, recordings=IDS[:1])


def test_the_same_network_from_elsewhere_is_the_same_setting(dataset, settings, store, tmp_path):
    first = make_run("first", dataset, settings, store=store, recordings=IDS[:1])
    moved = replace(settings, mass=WeightsFile("mass", tmp_path / "moved.safetensors", "named"))
    assert make_run("first", dataset, moved, store=store, recordings=IDS[:1]).created == first.created


def test_without_a_name_it_gets_a_free_one_or_that_of_an_equal_run(dataset, settings, store):
    names = [
        make_run(None, dataset, replace(settings, **change), store=store, recordings=IDS[:1]).name
        for change in ({}, {"means": {}}, {}, {"shape": ShapeParameters.lode()}, {"shape": ShapeParameters(points=9)})
    ]
    assert names == ["paper", "paper 2", "paper", "lode", "own parameters"]


def test_recordings_must_be_there_and_are_made_once(dataset, settings, store):
    with pytest.raises(ArgumentError, match="at least one"):
        make_run("a", dataset, settings, store=store, recordings=[])
    with pytest.raises(NotFoundError, match="no recording '000009'"):
        make_run("a", dataset, settings, store=store, recordings=["000009"])
    assert list_runs(store=store) == []
    assert make_run("a", dataset, settings, store=store, recordings=["0", "000000"]).recordings == ("000000",)


def test_a_store_that_cannot_be_written(dataset, settings, blocked):
    with pytest.raises(FileError, match="the run could not be kept"):
        make_run("a", dataset, settings, store=blocked, recordings=IDS[:1])
    run = make_run("a", dataset, settings, store=blocked, recordings=IDS[:1], is_kept=False)
    assert run.rows[0]["status"] == "fitted"


def test_a_resumed_run_detects_with_its_detector(dataset, settings, store, detector):
    detecting = replace(settings, detector=DetectorSettings(every=6))
    stopped = make_run("first", dataset, detecting, store=store, **stop_after(2))
    assert len(stopped.rows) == 2
    assert detector.seen == 0  # they have detections
    kept = load_run("first", dataset=dataset.root, store=store)
    whole = make_run(kept.name, dataset, kept.settings, store=store, recordings=kept.recordings)
    assert detector.seen > 0
    assert whole.digests["detector"] == detector.digest
    assert whole.rows[2]["status"] == "fitted"
    assert set(load_detections(dataset[WITHOUT_DETECTIONS], store=store).views) == set(METHOD_VIEWS)


def test_a_search_that_was_cut_short_is_finished(dataset, settings, store, detector, tmp_path):
    detecting = replace(settings, detector=DetectorSettings(every=4))
    whole = make_run("whole", dataset, detecting, store=Store(tmp_path / "other"), recordings=[WITHOUT_DETECTIONS])
    seen, detector.seen = detector.seen, 0
    cut = make_run(
        "cut", dataset, detecting, store=store, recordings=[WITHOUT_DETECTIONS], cancelled=lambda: detector.seen > 4
    )
    assert cut.rows == ()
    assert 4 < detector.seen < seen
    resumed = make_run("cut", dataset, detecting, store=store, recordings=[WITHOUT_DETECTIONS])
    assert detector.seen == seen
    assert untimed(resumed.rows) == untimed(whole.rows)


def test_what_another_detector_found_is_left_alone(dataset, settings, store, detector):
    make_run("a", dataset, replace(settings, detector=DetectorSettings(every=6)), store=store)
    seen, detector.digest = detector.seen, "2"
    make_run("b", dataset, replace(settings, detector=DetectorSettings(every=6)), store=store)
    assert detector.seen == seen


def test_a_recording_that_cannot_be_detected_in_says_why(dataset, settings, store, detector, tmp_path):
    broken = tmp_path / "000002.mp4"
    broken.write_bytes(b"no video")
    recording = dataset[WITHOUT_DETECTIONS]
    views = {name: replace(view, video_path=broken) for name, view in recording.views.items()}
    changed = type(dataset)(dataset.root, {WITHOUT_DETECTIONS: replace(recording, views=views)})
    detecting = replace(settings, detector=DetectorSettings(), means=None)
    [row] = make_run("a", changed, detecting, store=store).rows
    assert row["status"] == "failed"
    assert "000002.mp4" in row["notes"]
    assert detector.seen == 0
