from dataclasses import replace

import numpy as np
import pytest

from corsmal.dataset import Annotation
from corsmal.estimation import Estimate, Fit
from corsmal.filling import FillingPrediction
from corsmal.shape import Dimensions, Hull
from corsmal.ui.overview.numbers import PENDING, SEEN_IN_TRAINING, UNKNOWN_TRAINING, network_tiles, shape_tiles

FIT = Fit(("view3", "view1"), 25, Hull.failed("not looked at"), Dimensions(reason="not looked at"))
FOUND = Estimate(
    "000618",
    "fitted",
    capacity_ml=519.7,
    width_top_mm=92.04,
    width_bottom_mm=69.3,
    height_mm=116.1,
    best_frame=None,
    fit=FIT,
    notes=(),
    container_mass_g=11.5,
    filling=FillingPrediction(np.array([0.0, 0.0, 3.0, 0.0]), np.array([0.0, 2.0, 0.0])),
    intervals={"capacity_ml": (433.4, 605.9), "height_mm": (113.2, 118.9)},
)
TRUTH = Annotation(
    capacity_ml=520.0,
    width_top_mm=98.0,
    width_bottom_mm=61.0,
    height_mm=119.0,
    container_mass_g=10.0,
    filling_mass_g=0.0,
    filling_type=0,
    filling_level=0,
)


def by_label(tiles):
    return {tile.label: (tile.value, tile.interval, tile.verdict) for tile in tiles}


def shapes(found=FOUND, truth=TRUTH, *, is_inspected=True):
    return by_label(shape_tiles(found, truth, is_inspected=is_inspected))


def networks(found=FOUND, truth=TRUTH, *, row=None, left_out=None):
    weights = {"filling_weights": "" if found.filling is None else "filling network 1a"}
    return by_label(network_tiles(found.row() | weights | (row or {}), truth, left_out=left_out or {}))


def test_a_row_of_an_earlier_version_has_no_flags():
    row = {name: value for name, value in FOUND.row().items() if name != "flags"} | {"filling_weights": ""}
    assert by_label(network_tiles(row, TRUTH, left_out={})) == networks(row={"filling_weights": ""})


def test_every_tile_has_its_place_before_it_is_known():
    assert [tile.label for tile in PENDING] == [
        *("Filling", "Capacity", "Filling mass", "Object mass"),
        *("Top width", "Bottom width", "Height", "Container mass"),
    ]
    assert shapes().keys() | networks().keys() == {tile.label for tile in PENDING}


def test_numbers_have_interval_truth_and_error():
    tiles = shapes()
    assert tiles["Capacity"] == ("520 mL", "90 % interval 433–606 mL", "annotated 520 mL, error −0.1 %")
    assert tiles["Height"] == ("116.1 mm", "90 % interval 113–119 mm", "annotated 119 mm, error −2.4 %")
    assert tiles["Top width"] == ("92.0 mm", "one frame: no interval", "annotated 98 mm, error −6.1 %")


def test_without_annotation_the_tiles_say_so():
    assert {verdict for _, _, verdict in shapes(truth=None).values()} == {"no annotation"}
    assert {verdict for _, _, verdict in networks(truth=None).values()} == {"no annotation"}
    assert shapes(truth=Annotation(height_mm=119.0))["Capacity"][2] == "no annotation"


def test_what_was_not_measured_is_not_shown_as_a_measure():
    failed = replace(FOUND, status="failed", capacity_ml=None, fit=None, intervals={})
    assert shapes(failed)["Capacity"] == ("–", "not fitted", "annotated 520 mL")
    mean = replace(FOUND, status="fallback: training mean", capacity_ml=640.0, fit=None, intervals={})
    assert shapes(mean)["Capacity"][:2] == ("640 mL", "training mean: nothing was fitted")
    assert shapes(mean, is_inspected=False)["Capacity"][:2] == ("–", "no detections yet")


def test_filling_has_its_probabilities_and_the_truth():
    value, sure, verdict = networks()["Filling"]
    assert (value, verdict) == ("rice, half", "✗ annotated: empty")
    rice, half = (np.exp(logit) / (np.exp(logit) + others) for logit, others in ((3.0, 3), (2.0, 2)))
    assert sure == f"rice {100 * rice:.0f} %, half {100 * half:.0f} %"
    right = networks(truth=replace(TRUTH, filling_type=2, filling_level=1))
    assert right["Filling"][2] == "✓ annotated: rice, half"


def test_masses_have_truth_and_error():
    tiles = networks()
    filling_g = 0.5 * 519.7 * 0.82
    assert tiles["Container mass"] == ("12 g", "", "1.5 g too high (+15 %; true 10 g)")
    value, _, verdict = tiles["Filling mass"]
    assert (value, verdict) == (f"{filling_g:.0f} g", "213 g too high (true 0 g)")
    assert tiles["Object mass"][0] == f"{filling_g + 11.5:.0f} g"


def test_filling_mass_has_an_interval_where_capacity_and_probabilities_are_known():
    sure = replace(FOUND, filling=FillingPrediction(np.array([0.0, 0, 20, 0]), np.array([0.0, 20, 0])))
    shown = networks(sure)["Filling mass"][1].removeprefix("90 % interval ").removesuffix(" g").split("–")
    assert list(map(float, shown)) == pytest.approx([0.5 * 0.82 * 433.4, 0.5 * 0.82 * 605.9], rel=0.01)
    exact = 0.5 * 0.82 * 519.7
    assert networks(replace(sure, intervals={}))["Filling mass"][1] == f"90 % interval {exact:.0f}–{exact:.0f} g"
    nothing = FillingPrediction(np.array([3.0, 0, 0, 0]), np.array([3.0, 0, 0]))
    unmeasured = replace(FOUND, capacity_ml=None, filling=nothing, intervals={})
    assert networks(unmeasured)["Filling mass"][:2] == ("0 g", "level × capacity × density")


@pytest.mark.parametrize(
    ("kind", "labels"),
    [("filling", ["Filling", "Filling mass", "Object mass"]), ("mass", ["Object mass", "Container mass"])],
)
def test_where_a_network_is_left_out_the_reason_stands_in_the_numbers_place(kind, labels):
    changes = {"filling": None} if kind == "filling" else {"container_mass_g": None}
    tiles = networks(replace(FOUND, **changes), left_out={kind: "a reason"})
    assert [label for label, tile in tiles.items() if tile == ("left out", "", "a reason")] == labels


def test_a_prediction_that_failed_says_why():
    reason = "recording 000618 has no sound"
    silent = replace(FOUND, filling=FillingPrediction.failed(reason), notes=("view1: cut short", f"filling: {reason}"))
    tiles = networks(silent)
    assert tiles["Filling"] == ("–", "no prediction", "recording 000618 has no sound")
    assert tiles["Filling mass"] == ("–", "not estimated", "annotated 0 g")
    assert tiles["Container mass"][0] == "12 g"


def test_an_assumed_mass_says_so():
    for flag, words in (("mass-assumed", "the network had no answer"), ("dimensions-assumed", "mean dimensions")):
        assert words in networks(row={"flags": flag})["Container mass"][1]


def test_numbers_of_the_authors_networks_are_not_called_held_out():
    tiles = networks(row={"filling_weights": "released filling network 1", "filling_held_out": None})
    assert tiles["Filling"][2].endswith(UNKNOWN_TRAINING)
    assert UNKNOWN_TRAINING not in tiles["Container mass"][2]


def test_numbers_of_a_network_that_saw_the_recording_are_stamped():
    tiles = networks(row={"filling_held_out": False, "mass_held_out": True})
    assert tiles["Filling"][2].endswith(SEEN_IN_TRAINING)
    assert SEEN_IN_TRAINING not in tiles["Container mass"][2]
