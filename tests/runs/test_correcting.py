"""Which recordings of a run to correct by hand first."""

from dataclasses import replace

import numpy as np
import pytest

from corsmal.by_hand import HandMask, MaskHistory
from corsmal.parameters import ShapeParameters
from corsmal.runs.correcting import masks_to_correct, recordings_to_correct, run_to_correct
from corsmal.runs.keeping import label_run
from corsmal.runs.run import save_run
from corsmal.stages.detections import load_detections
from corsmal.stages.hand_comparison import frames_to_correct

FEW = replace(ShapeParameters.paper(), circumferences=40)


@pytest.fixture
def unsure(first_run):
    """A run whose recordings have 90 % intervals: the second one's are the widest, the third has no detections."""
    rows = [dict(row) for row in first_run.rows]
    for row, width in zip(rows, (0.2, 0.6, 0.4), strict=True):
        row |= {"capacity_ml": 100.0, "capacity_ml_low": 100 - 50 * width, "capacity_ml_high": 100 + 50 * width}
    return replace(first_run, settings=replace(first_run.settings, shape=FEW), rows=tuple(rows))


def test_the_least_sure_recordings_come_first():
    rows = [
        {"recording_id": "000001", "capacity_ml": 100.0, "capacity_ml_low": 90.0, "capacity_ml_high": 110.0},
        {"recording_id": "000002", "capacity_ml": 100.0, "capacity_ml_low": 50.0, "capacity_ml_high": 150.0},
        {"recording_id": "000003", "capacity_ml": None},
    ]
    assert recordings_to_correct(rows) == [("000002", 1.0), ("000001", 0.2)]


def test_each_recording_is_named_with_the_frame_that_comes_first_in_it(unsure, dataset, store):
    found = list(masks_to_correct(unsure, dataset, store=store))
    assert [(each.recording_id, round(each.width, 6)) for each in found] == [("000001", 0.6), ("000000", 0.2)]
    for each in found:
        recording = dataset[each.recording_id]
        detections = load_detections(recording, store=store)
        [first, *_] = frames_to_correct(recording, detections, pair=FEW.pairs[0], shape=FEW, store=store)
        assert each.candidate == first
        assert f"{each.recording_id}: 90 % intervals of {100 * each.width:.0f} %" in str(each)


def test_recordings_that_are_left_out_corrected_or_gone_are_not_named(unsure, dataset, store):
    def named(run, **more):
        return [each.recording_id for each in masks_to_correct(run, dataset, store=store, **more)]

    assert named(unsure, without="000001") == ["000000"]
    gone = replace(unsure, rows=(*unsure.rows, {**unsure.rows[1], "recording_id": "999999"}))
    assert named(gone) == ["000001", "000000"]
    recording = dataset["000001"]
    for name in FEW.pairs[0]:
        history = MaskHistory("000001", recording.views[name], store=store)
        found = load_detections(recording, store=store).views[name]
        for frame in found:
            mask = np.zeros(found.size, dtype=bool)
            history.keep(HandMask.of(mask, frame=frame), after=0)
    assert named(unsure) == ["000000"]


def test_the_newest_run_with_intervals_that_is_not_archived_orders_them(unsure, first_run, dataset, store):
    assert run_to_correct(dataset, store=store) is None
    save_run(first_run, store=store)
    assert run_to_correct(dataset, store=store) is None
    older = replace(unsure, name="older", id="", created="2024-01-01T00:00:00")
    newer = replace(unsure, name="newer", id="", created="2025-01-01T00:00:00")
    for each in (older, newer):
        save_run(each, store=store)
    found = run_to_correct(dataset, store=store)
    assert found is not None
    assert found.name == "newer"
    label_run(found, is_archived=True, store=store)
    assert run_to_correct(dataset, store=store).name == "older"
