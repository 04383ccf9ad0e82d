"""The Evaluation page sets the paper's method and its authors' program side by side."""

from pathlib import Path

import pandas as pd
import pytest

from corsmal.dataset import open_dataset
from corsmal.engines import local
from corsmal.runs.rules import RULES, comparable, compare_rules
from corsmal.ui import shared
from tests.app.driver import Visitor


@pytest.fixture(autouse=True)
def one_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(local, "default_workers", lambda: 1)


def opened(root: Path) -> Visitor:
    visitor = Visitor(root).open("evaluation")
    visitor.choose("evaluation_view", "rules")
    return visitor


def tables(visitor: Visitor) -> list[pd.DataFrame]:
    return [frame.value for frame in visitor.test.dataframe]


def test_the_button_compares_and_the_page_shows_what_came_of_it(tiny_dataset_root: Path) -> None:
    visitor = opened(tiny_dataset_root)
    assert visitor.address["view"] == "rules"
    assert "Estimate the 2 recordings with detections" in visitor.sentences
    visitor.press("Compare the rules")
    visitor.wait_for(lambda visitor: "rules_effects" in visitor.plots)
    assert visitor.crashes == visitor.errors == []
    assert "The published error of the height is 30.8 %" in visitor.sentences
    containers, in_turn = tables(visitor)
    assert list(containers.columns) == ["recordings", "published", "paper", "released", "lode", "tuned"]
    assert containers.index[-1] == "Average"
    assert containers.loc["Average", "published"] == 30.8
    assert list(in_turn.index) == ["paper", *(f"… and {rule}" for rule in RULES)]


def test_kept_rules_are_shown_at_once_for_any_quantity(tiny_dataset_root: Path) -> None:
    dataset = open_dataset(tiny_dataset_root)
    store = shared.store()
    compare_rules(comparable(dataset, store=store), store=store)
    visitor = opened(tiny_dataset_root)
    assert "Compare the rules" not in visitor.buttons
    visitor.choose("rules_metric", "capacity_mape")
    assert visitor.address["metric"] == "capacity_mape"
    assert tables(visitor)[0].loc["Average", "published"] == 77.1
    labels = visitor.plots["rules_effects"]["figure"]["layout"]["yaxis"]["ticktext"]
    assert list(labels) == list(RULES)


def test_without_detections_the_page_says_what_is_missing(tmp_path: Path, tiny_dataset_root: Path) -> None:
    root = tmp_path / "ROOT"
    root.mkdir()
    annotation = next(tiny_dataset_root.glob("*annotation.json"))
    (root / annotation.name).write_bytes(annotation.read_bytes())
    visitor = opened(root)
    assert "No recording has detections and calibrations of two views" in visitor.sentences
    assert visitor.crashes == []
