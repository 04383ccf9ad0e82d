import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from streamlit.delta_generator import DeltaGenerator

from corsmal.dataset import open_dataset
from corsmal.detection import Detections, ViewDetections
from corsmal.detection.parquet import write_parquet
from corsmal.estimation import container_mask, fit_frame
from corsmal.filling import FillingPredictor
from corsmal.filling.features import recording_features
from corsmal.mass import AxisRule, MassConfig, MassModel, MassPredictor, mm_per_pixel, restore_mask, save_mass
from corsmal.mass.inputs import square_image
from corsmal.mass.restoration import PADDING_PX
from corsmal.parameters import SelectionParameters
from corsmal.stages.detections import load_detections
from corsmal.store import Store
from corsmal.ui.amounts import filling_text, grams
from corsmal.weights import bundled_path
from tests.app.driver import Visitor, amount
from tests.released import write_released
from tests.tiny import CUP, SIZE, coco_result, write_json

BEST = 5
"""The best frame of the six: each shows the container nearer, and no second object is in the last."""

NUMBERS = ("width_top_mm", "width_bottom_mm", "height_mm")


@pytest.fixture(scope="module")
def weights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An untrained network: its masses are near the mean of two, and depend on all that it is given."""
    torch.manual_seed(3)
    model = MassModel(MassConfig(channels=(4, 4, 4, 4), hidden=(8, 4)))
    numbers = torch.tensor([[98.0, 61.0, 119.0], [60.0, 40.0, 200.0]])
    model.learn_statistics(numbers, torch.tensor([134.0, 60.0]))
    path = tmp_path_factory.mktemp("mass") / "mass.safetensors"
    save_mass(path, model)
    return path


@pytest.fixture(autouse=True)
def page(weights: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CORSMAL_MASS_WEIGHTS", str(weights))


@pytest.fixture
def visitor(sound_root: Path) -> Visitor:
    return Visitor(sound_root, estimate="paper").open("mass")


@pytest.fixture
def fitted(sound_root: Path, tmp_path: Path) -> dict[str, Any]:
    """The mask and the numbers in the best frame, as a program without the app would find them."""
    recording = open_dataset(sound_root)["000000"]
    views = load_detections(recording, store=Store(tmp_path / "by hand")).views
    fit = fit_frame(recording, views, pair=("view3", "view1"), frame=BEST, centre_rule="both thirds")
    mask = container_mask(views["view3"][BEST], centre_rule="both thirds", parameters=SelectionParameters())
    assert fit.hull.centroid_m is not None
    scale = mm_per_pixel(recording.views["view3"].camera(), fit.hull.centroid_m)
    return {"mask": mask, "mm_per_px": scale} | {name: getattr(fit.dimensions, name) for name in NUMBERS}


def predicted_g(weights: Path, fitted: dict[str, Any], *, padding_px: int = PADDING_PX, **changes: Any) -> float:
    predictor = MassPredictor(weights)
    predictor.model.config = replace(predictor.config, padding_px=padding_px)
    mass_g = predictor.predict(**(fitted | changes)).mass_g
    assert mass_g is not None
    return mass_g


def network_input(visitor: Visitor) -> NDArray[np.uint8]:
    traces = visitor.plots["restoration"]["figure"]["data"]
    image: NDArray[np.uint8] = next(trace["z"] for trace in traces if trace["type"] == "heatmap")
    return image.reshape(112, 112)


def panels(visitor: Visitor) -> dict[str, str]:
    """What stands over each picture, by its title."""
    notes = visitor.plots["restoration"]["figure"]["layout"]["annotations"]
    return dict(note["text"].removeprefix("<b>").split("</b><br>") for note in notes)


def test_page_opens_with_the_networks_answer_at_the_best_frame(
    visitor: Visitor, weights: Path, fitted: dict[str, Any]
) -> None:
    look = visitor.look()
    assert look.crashes == look.errors == look.warnings == []
    assert look.metrics["Container mass"] == grams(predicted_g(weights, fitted))
    assert look.metrics["Filling mass"] == "0 g"
    assert look.metrics["Object mass"] == look.metrics["Container mass"]
    assert look.plots == {"restoration", "mass_sensitivity"}
    assert list(visitor.address) == ["recording", "estimate"]


def test_masses_are_the_overviews_until_another_frame_is_shown(sound_root: Path) -> None:
    visitor = Visitor(sound_root)
    overview = visitor.open("overview").metrics
    visitor.open("mass")
    assert visitor.metrics["Container mass"] == overview["Container mass"]
    before = visitor.test.number_input(key="mass_capacity_ml").value
    visitor.go_to(0)
    assert visitor.test.number_input(key="mass_capacity_ml").value != before


def test_masses_stand_beside_the_truth(visitor: Visitor) -> None:
    container, filling, both = visitor.test.metric
    assert container.delta.endswith("true 10 g)")
    assert filling.delta == "exact (true 0 g)"
    assert both.delta == container.delta


def test_filling_depends_on_the_fits_capacity(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, recording="000001").open("mass")
    capacity_ml = visitor.test.number_input(key="mass_capacity_ml").value
    assert visitor.metrics["Filling mass"] == grams(0.5 * 0.82 * capacity_ml)
    assert f"rice, half, from the annotation; capacity {capacity_ml:.0f} mL" in visitor.sentences
    visitor.choose("mass_capacity_ml", 100.0)
    assert visitor.metrics["Filling mass"] == "41 g"
    total = amount(visitor.metrics["Container mass"]) + 41
    assert amount(visitor.metrics["Object mass"]) == pytest.approx(total, abs=1)


def test_padding_is_dragged(visitor: Visitor, weights: Path, fitted: dict[str, Any]) -> None:
    before = network_input(visitor)
    visitor.report("restoration", values={"padding_px": 40.0}, settled=False)
    assert visitor.crashes == []
    assert visitor.metrics["Container mass"] == grams(predicted_g(weights, fitted, padding_px=40))
    assert visitor.plots["restoration"]["sliders"][0]["value"] == 40
    assert network_input(visitor).mean() < before.mean()
    assert "was trained with a padding of 15 px: with other choices" in visitor.sentences


@pytest.mark.parametrize(("value", "used"), [(1e12, 80), (-3, 0), (7.6, 8)])
def test_padding_that_no_browser_sends_is_brought_within_the_limits(visitor: Visitor, value: float, used: int) -> None:
    visitor.report("restoration", values={"padding_px": value, "colour": 1.0}, settled=True)
    assert visitor.crashes == []
    assert visitor.plots["restoration"]["sliders"][0]["value"] == used


def test_typed_number_changes_the_mass_until_it_is_given_back(
    visitor: Visitor, weights: Path, fitted: dict[str, Any]
) -> None:
    first = visitor.metrics
    visitor.choose("mass_height_mm", 300.0)
    assert visitor.metrics["Container mass"] == grams(predicted_g(weights, fitted, height_mm=300.0))
    assert visitor.metrics != first
    visitor.press("Back to what was measured")
    assert visitor.metrics == first
    assert visitor.test.number_input(key="mass_height_mm").value == fitted["height_mm"]


def test_typed_numbers_are_in_the_link_and_forgotten_in_another_frame(visitor: Visitor, sound_root: Path) -> None:
    visitor.choose("mass_height_mm", 300.0)
    assert visitor.address["typed"] == "h:300"
    other = Visitor(sound_root, **visitor.link).open("mass")
    assert other.metrics == visitor.metrics
    for each in (visitor, other):
        each.go_to(2)
        assert each.test.number_input(key="mass_height_mm").value < 200
        assert "typed" not in each.address


def test_emptied_number_leaves_no_mass(visitor: Visitor) -> None:
    visitor.choose("mass_width_top_mm", None)
    assert visitor.crashes == []
    assert visitor.metrics == {"Container mass": "unknown", "Filling mass": "0 g", "Object mass": "unknown"}
    assert visitor.errors == visitor.warnings == []
    assert "Empty: top width. What depends on it is unknown: type a number" in visitor.sentences
    assert "width_top_mm" not in visitor.sentences
    assert "mass_sensitivity" not in visitor.plots


@pytest.mark.parametrize("value", [-5.0, 0.0, 1e6])
def test_number_that_cannot_be_is_refused_in_words(visitor: Visitor, value: float) -> None:
    before = visitor.metrics
    visitor.choose("mass_height_mm", value)
    assert visitor.metrics == before
    assert visitor.errors == []
    assert visitor.warnings == [f"{value:g} is not used for the height: it must lie between 0.01 and 20,000."]
    assert visitor.test.number_input(key="mass_height_mm").value > 0
    visitor.test.run()
    assert visitor.warnings == []


def test_typed_number_is_said_to_be_no_longer_the_fits(visitor: Visitor, fitted: dict[str, Any]) -> None:
    assert "Typed instead" not in visitor.sentences
    visitor.choose("mass_height_mm", 300.0)
    assert f"Typed instead of the fit's: height 300 (fit {fitted['height_mm']:.4g})." in visitor.sentences


def test_sensitivity_goes_through_the_mass(visitor: Visitor, weights: Path, fitted: dict[str, Any]) -> None:
    *lines, now, truth = visitor.plots["mass_sensitivity"]["figure"]["data"]
    assert [line["name"].split()[0] for line in lines] == ["w_t", "w_b", "h"]
    assert truth["name"] == "true mass: 10 g"
    assert now["y"] == pytest.approx([predicted_g(weights, fitted)], rel=1e-5)
    for line, name in zip(lines, NUMBERS, strict=True):
        for end, factor in ((0, 0.7), (-1, 1.3)):
            assert line["customdata"][end] == pytest.approx(factor * fitted[name])
            changed_g = predicted_g(weights, fitted, **{name: factor * fitted[name]})
            assert line["y"][end] == pytest.approx(changed_g, rel=1e-4)


@pytest.mark.parametrize("rule", ["base", "whole"])
def test_axis_is_found_by_the_chosen_rule(visitor: Visitor, fitted: dict[str, Any], rule: AxisRule) -> None:
    visitor.choose("mass_axis", rule)
    restored = restore_mask(fitted["mask"], axis=rule)
    assert panels(visitor)["Restored"].startswith(f"{restored.added.sum():,} px added")


def test_frame_without_a_container_says_so(root: Path) -> None:
    path = root / "view3" / "detections" / "000000.json"
    entries = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps([entry for entry in entries if entry["image_id"] != 2]), encoding="utf-8")
    visitor = Visitor(root, frame="2", estimate="paper").open("mass")
    assert visitor.crashes == visitor.errors == visitor.warnings == []
    assert "view3 has no container in frame 2: there is no mask to predict from." in visitor.sentences
    assert visitor.metrics == visitor.plots == {}


def test_recording_without_detections_offers_to_detect(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, recording="000002").open("mass")
    assert visitor.crashes == visitor.errors == []
    assert "Find the best frame" in visitor.buttons
    assert "view3 has no detections: there is no mask to predict from." in visitor.sentences


def test_failed_fit_lets_the_numbers_be_typed(root: Path, weights: Path, fitted: dict[str, Any]) -> None:
    (root / "view1" / "calib" / "000000.pickle").unlink()
    visitor = Visitor(root, pair="view3-view1", estimate="paper").open("mass")
    assert visitor.crashes == visitor.errors == []
    assert "failed" in visitor.warnings[0]
    assert "Type the dimensions below" in visitor.warnings[0]
    assert visitor.metrics["Container mass"] == "unknown"
    for name, value in zip(NUMBERS, (98.0, 61.0, 119.0), strict=True):
        assert visitor.test.number_input(key=f"mass_{name}").value is None
        visitor.choose(f"mass_{name}", value)
    mass_g = predicted_g(weights, fitted, width_top_mm=98.0, width_bottom_mm=61.0, height_mm=119.0)
    assert visitor.metrics["Container mass"] == grams(mass_g)


def test_mask_that_cannot_be_restored_is_shown_as_it_is(root: Path) -> None:
    line = np.zeros(SIZE[::-1], dtype=bool)
    line[180, 300:340] = True
    write_json(root / "view3" / "detections" / "000000.json", [coco_result(2, line, category=CUP, score=0.9)])
    visitor = Visitor(root, frame="2", estimate="paper").open("mass")
    assert visitor.crashes == visitor.errors == []
    assert visitor.warnings[-1] == "Nothing was restored: the mask is a single row of pixels."
    assert panels(visitor)["Restored"] == "no axis: nothing added"


@pytest.mark.parametrize("content", [None, b"", b"no weights"])
def test_weights_that_cannot_be_used_leave_the_pictures(
    sound_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, content: bytes | None
) -> None:
    path = tmp_path / "own.safetensors"
    if content is not None:
        path.write_bytes(content)
    monkeypatch.setenv("CORSMAL_MASS_WEIGHTS", str(path))
    visitor = Visitor(sound_root, estimate="paper").open("mass")
    assert visitor.crashes == visitor.warnings == []
    assert len(visitor.errors) == 1
    assert visitor.errors[0].startswith(f"{path}: is not a file of the mass network's weights; train one")
    assert visitor.metrics["Container mass"] == "unknown"
    assert list(panels(visitor)) == ["Seen", "Restored", "Network input"]


def test_authors_network_weighs_with_its_own_restoration_and_is_named(
    sound_root: Path, fitted: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_released(tmp_path)["mass"]
    monkeypatch.setenv("CORSMAL_MASS_WEIGHTS", str(path))
    visitor = Visitor(sound_root, estimate="paper").open("mass")
    assert visitor.crashes == visitor.errors == visitor.warnings == []
    assert visitor.metrics["Container mass"] == grams(predicted_g(path, fitted))
    image, _ = square_image(restore_mask(fitted["mask"], axis="top").cropped, resize="stretch", interpolation="linear")
    np.testing.assert_array_equal(network_input(visitor), np.rint(100 * image))
    assert "task4.pt" in visitor.sentences
    assert "no answer to a recording of that set is held out" in visitor.sentences


def test_demos_weights_are_called_a_guess_on_recordings_without_a_truth(
    root: Path, weights: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "synthetic" not in Visitor(root, estimate="paper").open("mass").sentences
    monkeypatch.setattr("corsmal.weights.bundled_path", lambda _kind: weights)
    assert "trained on **synthetic** containers only" in Visitor(root, estimate="paper").open("mass").sentences
    write_truth(root, np.ones((6, 2, 2), dtype=bool))
    assert "synthetic" not in Visitor(root, estimate="paper").open("mass").sentences


def write_truth(root: Path, amodal: NDArray[np.bool_]) -> None:
    """The truth of six frames as the demo writes it, as far as the page reads it."""
    folder = root / "truth" / "amodal" / "view3"
    folder.mkdir(parents=True)
    frames = {index: Detections([[0, 0, 1, 1]], [1.0], [47], mask[None]) for index, mask in enumerate(amodal)}
    write_parquet(ViewDetections(frames, size=amodal.shape[1:], source="truth"), folder / "000000.parquet")
    pose = {"base_m": [[0, 0, 0]] * 6, "rotation": np.eye(3)[None].repeat(6, axis=0).tolist(), "fill": [0] * 6}
    content = {"container_id": 1, "seed": 0, "action": "handle", "events_s": {}, **pose}
    (root / "truth" / "000000.json").write_text(json.dumps(content), encoding="utf-8")


def test_restoration_is_judged_where_there_is_a_truth(root: Path, fitted: dict[str, Any]) -> None:
    seen = fitted["mask"]
    amodal = seen | np.roll(seen, 4, axis=1)
    write_truth(root, np.repeat(amodal[None], 6, axis=0))
    visitor = Visitor(root, estimate="paper").open("mass")
    assert visitor.crashes == visitor.errors == []
    before = (seen & amodal).sum() / (seen | amodal).sum()
    assert panels(visitor)["Against the truth"].startswith(f"IoU {before:.3f} before, ")


def test_broken_truth_is_named_and_left_out(root: Path) -> None:
    write_truth(root, np.ones((6, 2, 2), dtype=bool))
    path = root / "truth" / "amodal" / "view3" / "000000.parquet"
    path.write_bytes(b"no table")
    visitor = Visitor(root, estimate="paper").open("mass")
    assert visitor.crashes == []
    assert visitor.errors == [f"{path}: is broken; delete it and make the recording again"]
    assert "Against the truth" not in panels(visitor)


def test_downloads_hold_the_pictures(sound_root: Path, fitted: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    offered: dict[str, Callable[[], bytes]] = {}

    def remember(_self: DeltaGenerator, _label: str, data: Any, file_name: str, **_more: Any) -> bool:
        offered[file_name] = data
        return False

    monkeypatch.setattr(DeltaGenerator, "download_button", remember)
    visitor = Visitor(sound_root, estimate="paper").open("mass")
    name = f"000000_view3_frame{BEST}"
    assert list(offered) == [f"{name}_restored.png", f"{name}_input.png"]
    read = [cv2.imdecode(np.frombuffer(make(), np.uint8), cv2.IMREAD_UNCHANGED) for make in offered.values()]
    np.testing.assert_array_equal(read[0] == 255, restore_mask(fitted["mask"]).mask)
    np.testing.assert_allclose(read[1] / 2.55, network_input(visitor), atol=1)


def test_network_that_wants_the_scale_is_given_it(
    sound_root: Path, tmp_path: Path, fitted: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    model = MassModel(replace(MassConfig.tuned(), channels=(4, 4, 4, 4), hidden=(8, 4)))
    numbers = torch.tensor([[98.0, 61.0, 119.0, 1.0], [60.0, 40.0, 200.0, 2.0]])
    model.learn_statistics(numbers, torch.tensor([134.0, 60.0]))
    path = tmp_path / "tuned.safetensors"
    save_mass(path, model)
    monkeypatch.setenv("CORSMAL_MASS_WEIGHTS", str(path))
    visitor = Visitor(sound_root, estimate="paper").open("mass")
    assert visitor.metrics["Container mass"] == grams(predicted_g(path, fitted))
    assert visitor.test.number_input(key="mass_mm_per_px").value == pytest.approx(fitted["mm_per_px"])
    assert panels(visitor)["Network input"] == "112 × 112 px, to scale"
    assert len(visitor.plots["mass_sensitivity"]["figure"]["data"]) == 6


def test_filling_is_what_the_sound_says(visitor: Visitor, sound_root: Path) -> None:
    recording = open_dataset(sound_root)["000000"]
    pair = FillingPredictor(bundled_path("filling")).predict(recording_features(recording).values).pair
    assert pair is not None
    assert f"{filling_text(*pair)}, from the sound" in visitor.sentences
