from dataclasses import replace

import pytest

from corsmal.dataset.clock import Matching
from corsmal.errors import ArgumentError
from corsmal.parameters import SHAPE_PRESETS, ShapeParameters
from corsmal.runs import make_run
from corsmal.runs.differences import parameter_differences
from corsmal.stages.settings import DetectorSettings
from corsmal.store import Store


@pytest.fixture(scope="module")
def run(dataset, settings, tmp_path_factory):
    return make_run("first", dataset, settings, store=Store(tmp_path_factory.mktemp("store")))


def with_shape(run, name, shape):
    return replace(run, name=name, id="", settings=replace(run.settings, shape=shape))


def test_only_what_differs_is_listed(run):
    other = with_shape(run, "other", ShapeParameters(circumferences=90, max_difference_mm=2.5))
    third = replace(other, name="third", id="", digests={**run.digests, "mass": f"mass network {'b' * 64}"})
    table = parameter_differences([run, other, third])
    assert list(table.columns) == [run.id, other.id, third.id]
    assert table.loc["shape.circumferences"].tolist() == ["145", "90", "90"]
    assert table.loc["shape.max_difference_mm"].tolist() == ["1", "2.5", "2.5"]
    assert table.loc["mass network"].tolist()[2] == "bbbbbbbb"
    assert len(table) == 3


def test_runs_with_the_same_parameters_differ_in_nothing(run):
    assert parameter_differences([run, replace(run, name="again", id="")]).empty


def test_what_a_method_does_not_look_at_is_said_to_be_unused(run):
    tuned = with_shape(run, "tuned", ShapeParameters.tuned())
    table = parameter_differences([run, tuned])
    assert table.loc["shape.method"].tolist() == ["circumferences", "outlines"]
    assert table.loc["shape.points"].tolist() == ["19", "not used"]
    assert table.loc["shape.tilt_deg"].tolist() == ["not used", "3"]
    assert table.loc["shape.boxes"].tolist() == ["not used", "yes"]


def test_a_detector_and_the_range_of_heights_are_told_in_words(run):
    lode = with_shape(run, "lode", ShapeParameters.lode())
    detecting = replace(
        lode,
        name="detecting",
        id="",
        settings=replace(lode.settings, detector=DetectorSettings(every=7)),
        digests={**run.digests, "detector": "mask r-cnn 1234"},
    )
    table = parameter_differences([run, detecting])
    assert table.loc["shape.height_range"].tolist() == ["masks −20 to +20 mm", "world −100 to +400 mm"]
    assert table.loc["detector"].tolist() == ["none", "mask r-cnn 1234, step 7"]


def test_how_views_are_matched_is_told(run):
    by_number = replace(run, name="b", id="", settings=replace(run.settings, matching=Matching(by="index")))
    assert parameter_differences([run, by_number]).loc["views matched"].tolist() == ["by time", "by frame number"]


def test_which_masks_are_used_is_told(run):
    by_hand = replace(run, name="b", id="", settings=replace(run.settings, masks="by-hand"))
    assert parameter_differences([run, by_hand]).loc["masks"].tolist() == ["detected", "by hand where present"]


def test_one_run_differs_from_nothing(run):
    with pytest.raises(ArgumentError, match="at least two, got 1"):
        parameter_differences([run])


def test_each_preset_varies_only_what_it_uses():
    assert {name: shape.varied for name, shape in SHAPE_PRESETS.items()} == {
        "paper": ("circumferences", "max_difference_mm", "points", "radii"),
        "released": ("circumferences", "max_difference_mm", "points", "radii"),
        "lode": ("circumferences", "points", "radii"),
        "tuned": ("tilt_deg", "wall_mm", "frames", "circumferences"),
    }
    assert "wall_mm" in ShapeParameters(wall_mm=1.0).varied
