import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import trimesh
from streamlit.delta_generator import DeltaGenerator

from corsmal.dataset import open_dataset
from corsmal.estimation import (
    container_mask,
    estimate,
    file_detections,
    fit_frame,
    frame_intervals,
    read_view_detections,
)
from corsmal.figures.style import PRESET_COLOURS
from corsmal.parameters import PAIRS, HeightRange, SelectionParameters, ShapeParameters
from corsmal.shape import Hull, fit_hull, measure_hull
from corsmal.ui.controls import PARAMETERS, Number
from tests.app.driver import Visitor, amount, rings

BEST = 5
"""The best frame of the six: each shows the container nearer, and no second object is in the last."""


@pytest.fixture
def visitor(sound_root: Path) -> Visitor:
    return Visitor(sound_root, estimate="paper").open("shape")


def hull_by_hand(
    root: Path, parameters: ShapeParameters, *, pair: tuple[str, str] = PAIRS[0], frame: int = BEST
) -> Hull:
    """The hull as a program without the app would fit it."""
    views = [open_dataset(root)["000000"].views[name] for name in pair]
    masks = []
    for view in views:
        found = read_view_detections(view)
        assert found is not None
        masks.append(container_mask(found[frame], centre_rule="both thirds", parameters=SelectionParameters()))
    return fit_hull([view.camera() for view in views], masks, parameters)


def assert_shows(visitor: Visitor, hull: Hull, parameters: ShapeParameters) -> None:
    """The page's figures and measures are this hull's."""
    assert visitor.crashes == []
    dimensions = measure_hull(hull, parameters)
    assert rings(visitor.plots["hull"]) == hull.converged.sum()
    assert visitor.frame_measures["Capacity"] == f"{dimensions.capacity_ml:.0f} mL"
    assert visitor.frame_measures["Height"] == f"{dimensions.height_mm:.1f} mm"
    kept = next(trace for trace in visitor.plots["profile"]["figure"]["data"] if trace["name"] == "kept")
    np.testing.assert_allclose(kept["x"], hull.radii_mm[dimensions.kept])
    np.testing.assert_allclose(kept["y"], hull.heights_mm[dimensions.kept])


def slider_values(visitor: Visitor) -> dict[str, float]:
    return {slider["name"]: slider["value"] for slider in visitor.plots["hull"]["sliders"]}


def test_page_opens_with_the_papers_parameters_at_the_best_frame(visitor: Visitor, sound_root: Path) -> None:
    parameters = ShapeParameters.paper()
    assert_shows(visitor, hull_by_hand(sound_root, parameters), parameters)
    assert slider_values(visitor) == {"circumferences": 145, "max_difference_mm": 1.0}


def test_measures_stand_beside_the_annotation(visitor: Visitor) -> None:
    capacity = next(metric for metric in visitor.test.metric if metric.label == "Capacity")
    error = 100 * (amount(capacity.value) / 601.0 - 1)  # a frustum 61 to 98 mm wide and 119 mm high holds 601 mL
    assert capacity.delta == f"paper: frame {BEST}"
    [text] = [caption.value for caption in visitor.test.caption if caption.value.startswith("annotated 601 mL")]
    assert amount(text.split("error ")[1]) == pytest.approx(error, abs=0.2)


def test_headline_is_the_overviews_number_and_a_frames_error_is_that_of_its_number(sound_root: Path) -> None:
    visitor = Visitor(sound_root)
    overview = visitor.open("overview").metrics
    visitor.open("shape")
    assert visitor.metrics == {label: overview[label] for label in visitor.metrics}
    frame = amount(visitor.frame_measures["Capacity"])
    text = next(caption.value for caption in visitor.test.caption if "this frame" in caption.value)
    share = amount(text.split("mL**, ")[1])
    assert share == pytest.approx(100 * (frame / 601.0 - 1), abs=0.2)  # of the annotation, as the headline's error


def test_without_an_annotation_a_frame_stands_against_the_whole_recording(root: Path) -> None:
    (root / "ccm_tiny_annotation.json").unlink()
    visitor = Visitor(root).open("shape")
    whole, frame = amount(visitor.metrics["Capacity"]), amount(visitor.frame_measures["Capacity"])
    text = next(caption.value for caption in visitor.test.caption if "this frame" in caption.value)
    assert "no annotation" in text
    assert amount(text.split("mL**, ")[1]) == pytest.approx(100 * (frame / whole - 1), abs=0.3)
    assert "from the recording's" in text


def test_own_values_are_estimated_over_the_recording_and_kept_when_the_preset_changes(visitor: Visitor) -> None:
    visitor.report("hull", values={"circumferences": 30}, settled=True)
    assert visitor.metrics["Capacity"] != visitor.frame_measures["Capacity"]
    visitor.press("Estimate the recording with these values")
    assert visitor.address["estimate"] == "shown"
    assert visitor.metrics["Capacity"] == visitor.frame_measures["Capacity"]
    visitor.choose("preset_control", "lode")
    visitor.press("Back to my values")
    assert (visitor.address["L"], "preset" in visitor.address) == ("30", False)


def test_poor_fit_says_how_much_of_the_masks_it_explains(real_root: Path) -> None:
    visitor = Visitor(real_root, recording="000618", preset="tuned", estimate="paper", frame="0").open("shape")
    assert "A poor fit" not in visitor.sentences
    visitor.go_to(63)
    assert "A poor fit" in visitor.sentences
    assert "of view3's" in visitor.sentences


def test_a_frames_predicted_error_the_weights_of_its_views_and_its_intervals_are_shown(real_root: Path) -> None:
    visitor = Visitor(real_root, recording="000618", preset="tuned", estimate="paper", frame="0").open("shape")
    recording = open_dataset(real_root)["000618"]
    detections, _ = file_detections(recording)
    fit = fit_frame(recording, detections, pair=PAIRS[0], frame=0, centre_rule="none", shape=ShapeParameters.tuned())
    assert f"Predicted error of the fit: **{fit.hull.error_pct:.0f} %**" in visitor.sentences
    assert all(f"{view} {weight:.2f}" in visitor.sentences for view, weight in fit.view_weights.items())
    low, high = frame_intervals(fit)["capacity_ml"]
    assert f"90 % interval {low:.0f}–{high:.0f} mL" in visitor.sentences
    assert "explains the masks better than a box" in visitor.sentences
    visitor.choose("preset_control", "paper")
    assert "Predicted error" not in visitor.sentences


def test_page_says_which_parameters_the_preset_has(visitor: Visitor) -> None:
    visitor.choose("preset_control", "tuned")
    [text] = [line for line in visitor.sentences.splitlines() if line.startswith("Parameters of")]
    assert "expected tilt" in text.split(". Only of ")[0]
    assert "d_max" in text.split(". Only of ")[1]


def test_dragging_refits_and_only_letting_go_writes_the_address(visitor: Visitor, sound_root: Path) -> None:
    visitor.report("hull", values={"circumferences": 220}, settled=False)
    parameters = ShapeParameters(circumferences=220)
    assert_shows(visitor, hull_by_hand(sound_root, parameters), parameters)
    assert "L" not in visitor.address
    visitor.report("hull", values={"circumferences": 200}, settled=True)
    parameters = ShapeParameters(circumferences=200)
    assert_shows(visitor, hull_by_hand(sound_root, parameters), parameters)
    assert visitor.address["L"] == "200"
    assert slider_values(visitor)["circumferences"] == 200


def test_smoothing_is_dragged_like_the_circumferences(visitor: Visitor, sound_root: Path) -> None:
    visitor.report("hull", values={"max_difference_mm": 0.3}, settled=True)
    parameters = ShapeParameters(max_difference_mm=0.3)
    assert_shows(visitor, hull_by_hand(sound_root, parameters), parameters)
    assert visitor.address["dmax"] == "0.3"
    visitor.report("hull", values={"max_difference_mm": 1.0}, settled=True)
    assert "dmax" not in visitor.address


@pytest.mark.parametrize(("value", "used"), [(1e12, 500), (-3, 10), (99.9, 99)])
def test_slider_value_that_no_browser_sends_is_brought_within_the_limits(
    visitor: Visitor, value: float, used: int
) -> None:
    visitor.report("hull", values={"circumferences": value, "colour": 3.0}, settled=True)
    assert visitor.crashes == []
    assert visitor.address["L"] == str(used)


def test_dragging_keeps_the_view_of_the_figure(visitor: Visitor) -> None:
    before = visitor.plots["hull"]["revision"]
    visitor.report("hull", values={"circumferences": 60}, settled=False)
    assert visitor.plots["hull"]["revision"] == before


def test_preset_sets_all_parameters_and_can_be_returned_to(visitor: Visitor, sound_root: Path) -> None:
    lode = ShapeParameters.lode()
    visitor.choose("preset_control", "lode")
    assert_shows(visitor, hull_by_hand(sound_root, lode), lode)
    assert visitor.address["preset"] == "lode"
    assert slider_values(visitor)["circumferences"] == 500
    visitor.report("hull", values={"circumferences": 90}, settled=True)
    assert (visitor.address["preset"], visitor.address["L"]) == ("lode", "90")
    visitor.press("Back to lode")
    assert_shows(visitor, hull_by_hand(sound_root, lode), lode)
    assert visitor.address == {"recording": "000000", "estimate": "paper", "preset": "lode"}


def test_pair_frame_and_best_button_choose_what_is_fitted(visitor: Visitor, sound_root: Path) -> None:
    paper = ShapeParameters.paper()
    visitor.choose("pair_control", ("view3", "view2"))
    assert_shows(visitor, hull_by_hand(sound_root, paper, pair=PAIRS[1]), paper)
    visitor.go_to(2)
    assert_shows(visitor, hull_by_hand(sound_root, paper, pair=PAIRS[1], frame=2), paper)
    assert visitor.address == {"recording": "000000", "estimate": "paper", "pair": "view3-view2", "frame": "2"}
    visitor.report("time_line", values={"best": 1}, settled=True)
    assert_shows(visitor, hull_by_hand(sound_root, paper, pair=PAIRS[1]), paper)
    assert "frame" not in visitor.address


def test_released_preset_fits_its_own_way_and_its_pairs_are_changed(visitor: Visitor, sound_root: Path) -> None:
    released = ShapeParameters.released()
    visitor.choose("preset_control", "released")
    assert_shows(visitor, hull_by_hand(sound_root, released), released)
    assert visitor.address["preset"] == "released"
    visitor.choose("shape_pairs", [("view2", "view3")])
    assert visitor.address["pairs"] == "view2-view3"
    visitor.choose("shape_height_rule", "ends")
    assert visitor.address["height"] == "ends"
    assert visitor.crashes == visitor.errors == []
    visitor.choose("shape_pairs", [])
    assert "Not possible: pairs must hold at least one pair" in visitor.test.toast[0].value


def test_released_estimate_uses_the_selection_of_its_name(visitor: Visitor) -> None:
    visitor.choose("estimate_control", "released")
    assert visitor.address["estimate"] == "released"
    assert visitor.widget("pair_control").value == ("view1", "view2")
    assert visitor.crashes == visitor.errors == []


def test_other_parameters_refit(visitor: Visitor, sound_root: Path) -> None:
    visitor.choose("shape_points", 40)
    visitor.choose("shape_radius_max_mm", 60.0)
    visitor.choose("shape_fit_rule", "all")
    visitor.choose("shape_reference", "centroid")
    visitor.choose("shape_low_mm", -150.0)
    visitor.choose("shape_high_mm", 150.0)
    assert visitor.address["z"] == "centroid:-150:150"
    heights = HeightRange("centroid", -150.0, 150.0)
    parameters = ShapeParameters(points=40, radius_max_mm=60.0, fit_rule="all", height_range=heights)
    assert_shows(visitor, hull_by_hand(sound_root, parameters), parameters)


def test_reversed_heights_are_refused_and_the_old_ones_kept(visitor: Visitor) -> None:
    capacity = visitor.frame_measures["Capacity"]
    visitor.choose("shape_low_mm", 30.0)
    assert [toast.value for toast in visitor.test.toast] == [
        "Not possible: low_mm must be below high_mm, both finite, got 30.0 and 20.0."
    ]
    assert visitor.crashes == []
    assert visitor.test.number_input(key="shape_low_mm").value == -20.0
    assert visitor.frame_measures["Capacity"] == capacity
    assert "z" not in visitor.address


def test_ranges_never_let_the_radii_cross() -> None:
    smallest, largest = PARAMETERS["radius_min_mm"], PARAMETERS["radius_max_mm"]
    assert isinstance(smallest, Number)
    assert isinstance(largest, Number)
    assert smallest.high < largest.low


def test_fit_that_fails_says_why_and_leaves_the_pictures(visitor: Visitor) -> None:
    visitor.choose("shape_reference", "world")
    visitor.choose("shape_high_mm", 2000.0)
    visitor.choose("shape_low_mm", 1900.0)
    assert visitor.crashes == []
    assert visitor.warnings[0].startswith(f"The fit of view3 + view1 in frame {BEST} failed: ")
    assert visitor.errors == []
    assert {"reprojection_view3", "reprojection_view1"} <= set(visitor.plots)


def test_every_circumference_is_reprojected_into_both_views(visitor: Visitor) -> None:
    for view in PAIRS[0]:
        traces = visitor.plots[f"reprojection_{view}"]["figure"]["data"]
        counted = sum(int(trace["name"].split(": ")[1].replace(",", "")) for trace in traces)
        assert counted == sum(len(trace["x"]) for trace in traces)
        assert counted == 19 * rings(visitor.plots["hull"])


def test_downloads_hold_the_hull(sound_root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    offered: dict[str, Callable[[], bytes]] = {}

    def remember(_self: DeltaGenerator, _label: str, data: Any, file_name: str, **_more: Any) -> bool:
        offered[file_name] = data
        return False

    monkeypatch.setattr(DeltaGenerator, "download_button", remember)
    visitor = Visitor(sound_root, L="50", estimate="paper").open("shape")
    name = f"000000_view3-view1_frame{BEST}"
    assert list(offered) == [f"{name}.obj", f"{name}.ply", f"{name}.stl", f"{name}_profile.csv"]
    capacity_ml = amount(visitor.frame_measures["Capacity"])
    for file_format in ("obj", "ply", "stl"):
        mesh = trimesh.load(io.BytesIO(offered[f"{name}.{file_format}"]()), file_type=file_format)
        assert isinstance(mesh, trimesh.Trimesh)
        assert mesh.is_watertight
        assert mesh.volume / 1000 == pytest.approx(capacity_ml, rel=0.003)
    table = pd.read_csv(io.BytesIO(offered[f"{name}_profile.csv"]()))
    hull = hull_by_hand(sound_root, ShapeParameters(circumferences=50))
    np.testing.assert_allclose(table["radius_mm"], hull.radii_mm)
    np.testing.assert_array_equal(table["converged"], hull.converged)


@pytest.mark.parametrize(("rule", "capacity_ml"), [("any", 540), ("all", 410)])
def test_real_recording_measures_what_was_measured_before(real_root: Path, rule: str, capacity_ml: float) -> None:
    address = {"recording": "000618", "pair": "view3-view1", "frame": "0", "z": "centroid:-150:150", "fit": rule}
    visitor = Visitor(real_root, estimate="paper", **address).open("shape")
    assert visitor.errors == visitor.warnings == visitor.crashes == []
    assert amount(visitor.frame_measures["Capacity"]) == pytest.approx(capacity_ml, rel=0.04)


@pytest.mark.parametrize("pair", ["view3-view1", "view3-view2"])
def test_real_recording_is_measured_at_the_best_frame_of_both_pairs(real_root: Path, pair: str) -> None:
    visitor = Visitor(real_root, recording="000618", pair=pair, estimate="paper").open("shape")
    visitor.report("hull", values={"circumferences": 300}, settled=True)
    assert visitor.errors == visitor.warnings == visitor.crashes == []
    assert amount(visitor.frame_measures["Capacity"]) == pytest.approx(520, rel=0.25)
    assert 200 < rings(visitor.plots["hull"]) <= 300


def test_tuned_is_fitted_and_the_paper_stands_beside_it(sound_root: Path) -> None:
    visitor = Visitor(sound_root, preset="tuned").open("shape")
    assert visitor.errors == visitor.crashes == []
    assert set(slider_values(visitor)) == {"tilt_deg", "wall_mm"}
    assert amount(visitor.frame_measures["Height"]) == pytest.approx(119, rel=0.05)
    names = {trace["name"] for trace in visitor.plots["hull"]["figure"]["data"]}
    assert {"tuned", "paper"} <= names
    visitor.report("hull", values={"wall_mm": 3.0}, settled=True)
    assert visitor.address["wall"] == "3"
    visitor.choose("beside_paper", "nothing")
    assert "paper" not in {trace["name"] for trace in visitor.plots["profile"]["figure"]["data"]}


def test_page_opens_at_the_frame_that_the_recordings_estimate_explains_best(sound_root: Path) -> None:
    visitor = Visitor(sound_root).open("shape")
    found = estimate(open_dataset(sound_root)["000000"], shape=ShapeParameters.tuned())
    assert found.fit is not None
    assert visitor.crashes == []
    assert visitor.frame == found.fit.frame
    assert "frame" not in visitor.address


def test_errors_are_coloured_on_request_and_axes_drawn(visitor: Visitor) -> None:
    def shown() -> tuple[bool, bool]:
        figure = visitor.plots["hull"]["figure"]
        surface = next(trace for trace in figure["data"] if trace["name"] == "paper")
        return "intensity" in surface, figure["layout"]["scene"]["xaxis"]["visible"]

    assert shown() == (False, False)
    visitor.choose("hull_errors", True)
    visitor.choose("hull_axes", True)
    assert shown() == (True, True)


def test_without_a_known_profile_errors_cannot_be_coloured(root: Path) -> None:
    (root / "ccm_tiny_annotation.json").unlink()
    visitor = Visitor(root).open("shape")
    assert visitor.crashes == visitor.errors == []
    assert visitor.widget("hull_errors").disabled


def test_hulls_have_the_colours_of_their_presets(visitor: Visitor) -> None:
    for preset, other in (("paper", "tuned"), ("tuned", "paper")):
        visitor.choose("preset_control", preset)
        traces = {trace["name"]: trace for trace in visitor.plots["hull"]["figure"]["data"]}
        assert traces[preset]["color"] == PRESET_COLOURS[preset]
        assert traces[other]["line"]["color"] == PRESET_COLOURS[other]
