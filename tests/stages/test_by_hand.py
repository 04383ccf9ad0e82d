"""Masks by hand among detections, and what they change in an estimate."""

from dataclasses import replace

import numpy as np
import pytest

from corsmal.by_hand import HandMask, MaskHistory
from corsmal.dataset import open_dataset
from corsmal.dataset.layout import View
from corsmal.parameters import PAIRS, ShapeParameters
from corsmal.stages.by_hand import amodal_by_hand, has_masks_by_hand, views_by_hand
from corsmal.stages.detections import detections_origin, load_detections
from corsmal.stages.estimates import Predictors, load_estimate
from corsmal.stages.hand_comparison import (
    compare_masks,
    compare_outlines,
    frames_to_correct,
    mask_sentence,
)
from tests.tiny import SIZE, write_tiny_dataset

FEW = replace(ShapeParameters.paper(), circumferences=40)
SHAPES = {"few": FEW}


@pytest.fixture
def recording(dataset):
    return dataset["000000"]


def draw(recording, store, frame, *, views=("view3", "view1"), shrink=0, **facts):
    """Keep the detected container, less some pixels on its left, as a mask by hand."""
    found = load_detections(replace(recording, masks="detected"), store=store).views
    for name in views:
        mask = found[name][frame].mask(0)
        left = np.flatnonzero(mask.any(axis=0))[0]
        mask[:, : left + shrink] = False
        history = MaskHistory(recording.id, recording.views[name], store=store)
        history.keep(HandMask.of(mask, frame=frame, **facts), after=history.frame(frame).version)


def by_hand(recording):
    return replace(recording, masks="by-hand")


def test_masks_by_hand_take_the_place_of_detections_where_they_are_wanted(recording, store):
    before = load_detections(recording, store=store)
    draw(recording, store, 3, shrink=6)
    assert load_detections(recording, store=store).views["view1"][3].counts == before.views["view1"][3].counts
    found = load_detections(by_hand(recording), store=store)
    assert len(found.views["view1"][3]) == 1
    assert found.views["view1"][3].mask_areas[0] < before.views["view1"][3].mask_areas[0]
    assert found.views["view1"][4].counts == before.views["view1"][4].counts
    assert found.views["view1"].source.endswith("; 1 of 12 frames by hand")
    assert found.views["view2"].source == before.views["view2"].source
    assert "view1: masks by hand in frame 3" in found.notes


def test_a_view_without_detections_has_those_by_hand_only(dataset, store):
    recording = dataset["000002"]
    mask = np.zeros(SIZE[::-1], dtype=bool)
    mask[100:150, 300:350] = True
    MaskHistory(recording.id, recording.views["view1"], store=store).keep(HandMask.of(mask, frame=2), after=0)
    found = load_detections(by_hand(recording), store=store)
    assert list(found.views["view1"]) == [2]
    assert found.views["view1"].source == "by hand"
    assert "view1" not in load_detections(recording, store=store).views


def test_the_origin_changes_with_each_mask_by_hand_and_only_where_they_count(recording, store):
    detected, hand = (detections_origin(each, store=store) for each in (recording, by_hand(recording)))
    assert detected == hand  # there are none yet
    draw(recording, store, 3)
    first = detections_origin(by_hand(recording), store=store)
    draw(recording, store, 3, shrink=6)
    assert len({detected, first, detections_origin(by_hand(recording), store=store)}) == 3
    assert detections_origin(recording, store=store) == detected


def test_an_estimate_from_masks_by_hand_is_flagged_and_another_one(recording, store):
    predictors = Predictors(FEW)
    before = load_estimate(recording, predictors, store=store)
    for frame in range(12):
        draw(recording, store, frame, views=("view3", "view1", "view2"), shrink=12)
    after = load_estimate(by_hand(recording), predictors, store=store)
    assert after["flags"] == "by-hand"
    assert after["width_top_mm"] < before["width_top_mm"]
    assert load_estimate(recording, predictors, store=store) == before


def test_masks_that_nobody_accepted_are_not_used(recording, store):
    draw(recording, store, 3, shrink=6, is_accepted=False)
    assert load_detections(by_hand(recording), store=store).notes == load_detections(recording, store=store).notes


def test_masks_of_a_video_that_changed_are_said_and_not_used(tmp_path, store):
    root = write_tiny_dataset(tmp_path / "set", recordings=1, frames=2, size=(128, 72))
    recording = open_dataset(root)["000000"]
    draw(recording, store, 1, views=("view1",))
    path = recording.views["view1"].video_path
    path.write_bytes(path.read_bytes() + b" and more")
    found = load_detections(by_hand(recording), store=store)
    assert len(found.views["view1"][1]) > 1
    assert any("were drawn before 000000.mp4 changed" in note for note in found.notes)


def test_views_by_hand_hold_nothing_else(recording, store):
    draw(recording, store, 3)
    draw(recording, store, 5, views=("view1",))
    found = views_by_hand(recording, store=store)
    assert {name: list(view) for name, view in found.items()} == {"view1": [3, 5], "view3": [3]}


def test_two_views_of_a_frame_make_a_recording_comparable(recording, store):
    assert not has_masks_by_hand(recording, store=store)
    draw(recording, store, 3, views=("view3",))
    draw(recording, store, 4, views=("view1",))
    assert not has_masks_by_hand(recording, store=store)
    draw(recording, store, 4, views=("view3",))
    assert has_masks_by_hand(recording, store=store)


def test_the_whole_outline_is_found_by_the_recordings_frame(recording, store):
    assert amodal_by_hand(recording, "view3", 3, store=store) is None
    whole = np.zeros(SIZE[::-1], dtype=bool)
    whole[10:90, 20:60] = True
    history = MaskHistory(recording.id, recording.views["view3"], store=store)
    history.keep(HandMask.of(whole, frame=3, amodal=whole), after=0)
    np.testing.assert_array_equal(amodal_by_hand(recording, "view3", 3, store=store), whole)


def test_the_same_frames_are_compared_and_the_annotation_says_whose_fault_it_is(recording, store):
    assert compare_masks(recording, shapes=SHAPES, store=store).empty
    draw(recording, store, 3, shrink=14)
    table = compare_masks(recording, shapes=SHAPES, store=store)
    assert list(table.index) == [("few", "detected"), ("few", "by hand")]
    assert set(table["frame"]) == {3}
    detected, hand = (table.loc[("few", masks)] for masks in ("detected", "by hand"))
    assert hand["width_top_mm"] < detected["width_top_mm"]
    truth = {name: float(hand[name]) for name in ("capacity_ml", "width_top_mm", "height_mm")}
    assert "to 0.0 %; 100 % of it is due to the masks" in mask_sentence(table, truth, preset="few")
    truth = {name: float(detected[name]) for name in truth}
    assert "from 0.0 to" in mask_sentence(table, truth, preset="few")
    assert "masks are not to blame" in mask_sentence(table, truth, preset="few")
    assert "nothing to compare" in mask_sentence(table, {}, preset="few")


def test_outlines_are_compared_pixel_by_pixel(recording, store):
    draw(recording, store, 3, views=("view1",), shrink=5)
    [row] = compare_outlines(recording, store=store).to_dict("records")
    detected = load_detections(recording, store=store).views["view1"][3].mask(0)
    drawn = views_by_hand(recording, store=store)["view1"][3].mask(0)
    assert row["overlap"] == drawn.sum() / detected.sum()
    assert (row["missing"], row["beyond"]) == (0, detected.sum() - drawn.sum())


def test_the_frame_that_the_estimate_uses_is_proposed_first_then_where_the_views_disagree(recording, store):
    found = load_detections(recording, store=store)
    candidates = frames_to_correct(recording, found, pair=PAIRS[0], shape=FEW, store=store)
    row = load_estimate(recording, Predictors(FEW), store=store)
    assert candidates[0].is_used
    assert candidates[0].frame == row["best_frame"]
    others = [each.overlap for each in candidates[1:]]
    assert others == sorted(others)
    draw(recording, store, candidates[0].frame)
    left = frames_to_correct(recording, found, pair=PAIRS[0], shape=FEW, store=store)
    assert candidates[0].frame not in [each.frame for each in left]


def test_a_history_that_cannot_be_read_costs_only_the_masks_by_hand(recording, store):
    history = MaskHistory(recording.id, View("view1", recording.views["view1"].video_path), store=store)
    history._log.path.mkdir(parents=True)
    found = load_detections(by_hand(recording), store=store)
    assert len(found.views["view1"]) == 12
    assert any("is no file" in note for note in found.notes)
