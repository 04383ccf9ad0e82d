"""The Evaluation page sets the paper's method and its authors' program side by side."""

import json
import shutil
from pathlib import Path

import pandas as pd
import pytest

from corsmal.dataset import open_dataset
from corsmal.engines import local
from corsmal.evaluation import rules as evaluation_rules
from corsmal.runs.rules import RULES, comparable, compare_rules
from corsmal.ui import shared
from corsmal.ui.evaluation import rules
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


def test_errors_are_computed_once_for_all_quantities_and_anew_when_the_annotation_changes(
    tiny_dataset_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    root = Path(shutil.copytree(tiny_dataset_root, tmp_path / "ROOT"))
    computed = []

    def counted(estimates: dict[str, pd.DataFrame], annotation: pd.DataFrame) -> pd.DataFrame:
        computed.append(annotation)
        return evaluation_rules.side_by_side(estimates, annotation)

    monkeypatch.setattr(rules, "side_by_side", counted)
    store = shared.store()
    compare_rules(comparable(open_dataset(root), store=store), store=store)
    visitor = opened(root)
    before = tables(visitor)[0].loc["Average", "paper"]
    visitor.choose("rules_metric", "capacity_mape")
    visitor.choose("rules_metric", "height_mape")
    assert len(computed) == 1
    annotation = next(root.glob("*annotation.json"))
    content = json.loads(annotation.read_text(encoding="utf-8"))
    for row in content["annotations"]:
        row["height"] = 2 * row["height"]
    annotation.write_text(json.dumps(content), encoding="utf-8")
    after = tables(opened(root))[0].loc["Average", "paper"]
    assert len(computed) == 2
    assert after == pytest.approx((100 + before) / 2, abs=5)  # too low by half and more


def test_without_detections_the_page_says_what_is_missing(tmp_path: Path, tiny_dataset_root: Path) -> None:
    root = tmp_path / "ROOT"
    root.mkdir()
    annotation = next(tiny_dataset_root.glob("*annotation.json"))
    (root / annotation.name).write_bytes(annotation.read_bytes())
    visitor = opened(root)
    assert "No recording has detections and calibrations of two views" in visitor.sentences
    assert visitor.crashes == []
