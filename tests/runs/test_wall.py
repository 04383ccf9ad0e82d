from dataclasses import replace

import numpy as np
import pytest

from corsmal.errors import ArgumentError
from corsmal.estimation import estimate
from corsmal.parameters import ShapeParameters
from corsmal.runs.wall import learn_wall
from corsmal.shape import capacity_ml
from corsmal.stages.detections import load_detections

SHAPE = replace(ShapeParameters.tuned(), boxes=False, frames=3)


def holding(recording, *, store, wall_mm):
    """The recording, annotated with what its hull holds when the wall is so thick."""
    views = load_detections(recording, store=store).views
    hull = estimate(recording, detections=views, shape=SHAPE).fit.hull
    true = capacity_ml(hull, wall_mm=wall_mm)
    return replace(recording, annotation=replace(recording.annotation, capacity_ml=true))


def test_the_wall_comes_from_annotated_capacities_and_each_container_is_judged_by_the_others(dataset, store):
    recordings = [holding(dataset[name], store=store, wall_mm=2.3) for name in ("000000", "000001")]
    steps = []
    learnt = learn_wall(recordings, store=store, shape=SHAPE, progress=lambda done, total: steps.append((done, total)))
    assert learnt.wall_mm == 2.3
    assert learnt.table["container"].tolist() == [recording.annotation.container for recording in recordings]
    assert learnt.table["recordings"].tolist() == [1, 1]
    assert learnt.table["wall_mm"].tolist() == [2.3, 2.3]
    np.testing.assert_allclose(learnt.table["others_pct"], 0, atol=1e-9)
    assert (learnt.table["no_wall_pct"] > learnt.table["preset_pct"]).all()
    assert (learnt.table["preset_pct"] > 1).all()
    assert steps == [(1, 2), (2, 2)]


def test_one_container_is_judged_by_nobody(dataset, store):
    learnt = learn_wall([holding(dataset["000000"], store=store, wall_mm=0.0)], store=store, shape=SHAPE)
    assert learnt.wall_mm == 0
    assert learnt.table["others_pct"].isna().all()


def test_without_capacities_or_detections_there_is_nothing_to_learn(dataset, store):
    unknown = replace(dataset["000000"], annotation=None)
    with pytest.raises(ArgumentError, match="run detect first"):
        learn_wall([unknown, dataset["000002"]], store=store, shape=SHAPE)
