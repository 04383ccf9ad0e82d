"""The Overview page: the numbers of a run, what they come from, and what was known when."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from corsmal.dataset import open_dataset
from corsmal.errors import FileError
from corsmal.parameters import SHAPE_PRESETS
from corsmal.stages.detections import load_detections
from corsmal.stages.estimates import Predictors, load_estimate
from corsmal.stages.moments import known_when, moments_s
from corsmal.stages.settings import EstimateSettings, default_settings
from corsmal.store import Store
from corsmal.ui import drawing, sidebar
from corsmal.ui.amounts import grams
from corsmal.ui.overview import pictures
from corsmal.ui.overview.tiles import Tiles
from tests.app.driver import Visitor
from tests.networks import write_networks

PICTURES = {"overview_hull", "overview_mask", "overview_type", "overview_level"}
CURVES = "overview_known_when"


@pytest.fixture(scope="module")
def weights(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return write_networks(tmp_path_factory.mktemp("networks"))


@pytest.fixture
def networks(weights: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    """The app is started with networks of the user's own."""
    for name, path in weights.items():
        monkeypatch.setenv(f"CORSMAL_{name.upper()}_WEIGHTS", str(path))


def row_of(root: Path, store: Store, preset: str, recording: str = "000000") -> dict[str, Any]:
    """The row that a run of a preset has."""
    dataset = open_dataset(root)
    return load_estimate(dataset[recording], default_settings(dataset, shape=SHAPE_PRESETS[preset]).open(), store=store)


def wait_for_curves(visitor: Visitor) -> dict[str, Any]:
    visitor.wait_for(lambda visitor: CURVES in visitor.plots and not visitor.progress)
    figure: dict[str, Any] = visitor.plots[CURVES]["figure"]
    return figure


@pytest.mark.usefixtures("networks")
def test_numbers_that_are_kept_are_drawn_once_and_before_the_rest(
    sound_root: Path, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[str] = []
    monkeypatch.setattr(Tiles, "show_pending", lambda _tiles: drawn.append("being computed"))
    monkeypatch.setitem(drawing.AT_MOST_S, "numbers", 0.01)
    monkeypatch.setattr(sidebar, "_draw", _noted(drawn, "the sidebar", sidebar._draw))
    monkeypatch.setattr(pictures, "views", _noted(drawn, "the views", pictures.views))
    monkeypatch.setattr(Tiles, "show", _noted(drawn, "numbers", Tiles.show))
    Visitor(sound_root, begins="overview")
    assert drawn == ["being computed", "the sidebar", "numbers", "the views", "numbers"]

    drawn.clear()
    row_of(sound_root, store, "tuned")
    visitor = Visitor(sound_root, begins="overview", recording="000000")
    assert visitor.metrics["Filling"] not in ("–", "…", "left out")
    assert drawn == ["numbers", "the sidebar", "the views"]
    drawn.clear()
    visitor.test.run()
    assert drawn == ["the sidebar", "numbers", "the views"]  # later runs change what stands there
    assert visitor.crashes == []


def _noted(drawn: list[str], name: str, draw: Callable[..., object]) -> Callable[..., object]:
    """A function that notes that it was called."""

    def noted(*args: Any, **options: Any) -> object:
        drawn.append(name)
        return draw(*args, **options)

    return noted


@pytest.mark.usefixtures("networks")
def test_numbers_of_a_run_need_no_network(sound_root: Path, store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    row = row_of(sound_root, store, "tuned")

    def refuse(_settings: EstimateSettings) -> Predictors:
        raise FileError(Path("filling.safetensors"), "is not opened here")

    monkeypatch.setattr(EstimateSettings, "open", refuse)
    visitor = Visitor(sound_root, begins="overview")
    assert visitor.errors == ["filling.safetensors: is not opened here"]
    for label, name in (("Container", "container"), ("Filling", "filling"), ("Object", "object")):
        assert visitor.metrics[f"{label} mass"] == grams(row[f"{name}_mass_g"])
    assert visitor.metrics["Filling"] not in ("–", "…", "left out")


@pytest.mark.usefixtures("networks")
def test_the_app_opens_on_the_numbers_of_a_run(sound_root: Path, store: Store) -> None:
    visitor = Visitor(sound_root, begins="overview")
    row = row_of(sound_root, store, "tuned")
    look = visitor.look()
    assert look.title == "Overview"
    assert look.crashes == look.errors == look.warnings == []
    assert look.metrics["Capacity"] == f"{row['capacity_ml']:.0f} mL"
    assert look.metrics["Height"] == f"{row['height_mm']:.1f} mm"
    for label, name in (("Container", "container"), ("Filling", "filling"), ("Object", "object")):
        assert look.metrics[f"{label} mass"] == grams(row[f"{name}_mass_g"])
    interval = f"90 % interval {row['capacity_ml_low']:.0f}–{row['capacity_ml_high']:.0f} mL"
    assert visitor.tiles["Capacity"]["interval"] == interval
    assert look.plots >= PICTURES
    assert (look.pictures, look.sounds) == (3, 1)
    assert visitor.address == {"recording": "000000"}


@pytest.mark.usefixtures("networks")
def test_curves_come_in_and_end_at_the_numbers(sound_root: Path, store: Store) -> None:
    visitor = Visitor(sound_root, begins="overview")
    figure = wait_for_curves(visitor)
    dataset = open_dataset(sound_root)
    recording, predictors = dataset["000000"], default_settings(dataset, shape=SHAPE_PRESETS["tuned"]).open()
    detections = load_detections(recording, store=store)
    moments = list(known_when(recording, detections, predictors, moments_s(recording), store=store))
    [line] = [trace for trace in figure["data"] if trace.get("name") == "capacity"]
    assert list(line["x"]) == [moment.time_s for moment in moments]
    assert list(line["y"]) == [moment.row["capacity_ml"] if moment.is_fitted else None for moment in moments]
    assert visitor.metrics["Capacity"] == f"{line['y'][-1]:.0f} mL"
    assert "Being computed" not in visitor.sentences
    assert visitor.crashes == visitor.errors == visitor.warnings == []


@pytest.mark.usefixtures("networks")
def test_another_preset_gives_its_own_numbers_and_stands_in_the_address(sound_root: Path, store: Store) -> None:
    visitor = Visitor(sound_root, begins="overview")
    visitor.choose("estimate_control", "paper")
    assert visitor.address == {"recording": "000000", "estimate": "paper"}
    assert visitor.metrics["Capacity"] == f"{row_of(sound_root, store, 'paper')['capacity_ml']:.0f} mL"
    assert "one frame: no interval" in [tile["interval"] for tile in visitor.tiles.values()]
    again = Visitor(sound_root, begins="overview", recording="000000", estimate="paper")
    assert again.metrics == visitor.metrics


@pytest.mark.usefixtures("networks")
@pytest.mark.parametrize(
    ("label", "title"), [("Capacity", "Shape"), ("Hull", "Shape"), ("Filling", "Filling"), ("Object mass", "Mass")]
)
def test_parts_lead_to_the_page_that_explains_them(sound_root: Path, store: Store, label: str, title: str) -> None:
    visitor = Visitor(sound_root, begins="overview")
    visitor.press(label)
    row = row_of(sound_root, store, "tuned")
    assert visitor.test.title[0].value == title
    assert visitor.address == {
        "recording": "000000",
        "frame": str(row["best_frame"]),
        "pair": row["pair"].replace(" + ", "-"),
        "preset": "tuned",
    }
    assert visitor.crashes == visitor.errors == []


def test_networks_that_are_left_out_are_named_in_the_numbers_place(sound_root: Path) -> None:
    visitor = Visitor(sound_root, begins="overview")
    for label in ("Filling", "Filling mass", "Object mass", "Container mass"):
        assert visitor.metrics[label] == "left out"
        assert visitor.tiles[label]["verdict"] == "the bundled network was trained on synthetic recordings only"
    assert "No filling and mass estimates" in visitor.sentences
    assert visitor.metrics["Capacity"].endswith("mL")
    names = {trace.get("name") for trace in wait_for_curves(visitor)["data"]}
    assert "capacity" in names
    assert "container" not in names
    assert visitor.crashes == visitor.errors == visitor.warnings == []


@pytest.mark.usefixtures("networks")
def test_a_recording_that_nobody_inspected_is_heard_and_can_be_inspected(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, begins="overview", recording="000002")
    assert visitor.crashes == visitor.errors == visitor.warnings == []
    assert visitor.metrics["Capacity"] == "–"
    assert "no detections yet" in [tile["interval"] for tile in visitor.tiles.values()]
    assert visitor.metrics["Filling"] not in ("–", "…", "left out")
    assert "Find the best frame" in visitor.buttons
    assert not {"overview_hull", "overview_mask"} & visitor.plots.keys()


@pytest.mark.usefixtures("networks")
def test_a_recording_without_sound_has_a_shape(tiny_dataset_root: Path) -> None:
    visitor = Visitor(tiny_dataset_root, begins="overview", recording="000001")
    assert visitor.crashes == visitor.errors == visitor.warnings == []
    assert visitor.metrics["Filling"] == "–"
    assert "has no sound" in visitor.tiles["Filling"]["verdict"]
    assert visitor.metrics["Capacity"].endswith("mL")


def test_weights_that_cannot_be_read_leave_the_shape(
    sound_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "own.safetensors"
    path.write_bytes(b"no weights")
    monkeypatch.setenv("CORSMAL_MASS_WEIGHTS", str(path))
    visitor = Visitor(sound_root, begins="overview")
    assert visitor.crashes == []
    assert len(visitor.errors) == 1
    assert str(path) in visitor.errors[0]
    assert visitor.metrics["Capacity"].endswith("mL")


def test_the_folder_that_was_typed_on_the_first_page_stays_on_all(sound_root: Path) -> None:
    visitor = Visitor(begins="overview")  # the page that shows its numbers before the sidebar
    visitor.test.sidebar.text_input[0].set_value(str(sound_root)).run()
    for page in ("overview", "recordings", "mass", "overview"):
        visitor.open(page)
        assert visitor.test.sidebar.text_input[0].value == str(sound_root)
        assert visitor.crashes == []
