"""The Evaluation page opens with the summary; what is clicked opens beside it."""

import pytest

import corsmal.filling.features  # noqa: F401 - loads PyTorch, before a test's clock runs
from corsmal.runs import list_runs
from corsmal.ui import shared
from tests.app.driver import Visitor


@pytest.fixture
def visitor() -> Visitor:
    """On the Evaluation page of the ready-made demo."""
    return Visitor().open("evaluation")


def select(visitor: Visitor, number: int, *, cell: tuple[int, str]) -> None:
    key = visitor.test.dataframe[number].proto.id.split("-", 2)[2]
    visitor.test.session_state[key] = {"selection": {"rows": [], "columns": [], "cells": [cell]}}
    visitor.test.run()


def test_the_page_opens_with_tiles_multiples_and_the_worst_recordings(visitor: Visitor) -> None:
    assert visitor.crashes == visitor.errors == []
    assert list(visitor.metrics) == [
        "Capacity ↓",
        "Top width ↓",
        "Bottom width ↓",
        "Height ↓",
        "Mass ↓",
        "Filling level ↑",
        "Filling type ↑",
        "Failed",
        "In the interval",
    ]
    figure = visitor.plots["summary"]["figure"]
    points = [trace for trace in figure["data"] if trace["name"].startswith("this run")]
    assert len(points) == 7
    assert points[0]["customdata"][-1] == ["capacity_mape", "Average"]
    worst = visitor.test.dataframe[0].value
    assert len(worst) == 6
    assert worst["mean error"].is_monotonic_decreasing
    assert worst["picture"].str.endswith(".jpg").all()

    visitor.report("summary", click={"curve": 1, "x": 3, "y": 1, "customdata": ["capacity_mape", "green glass"]})
    assert any(each.value == "Capacity, green glass: 1 recording" for each in visitor.test.subheader)
    visitor.report("summary", click={"curve": 1, "x": 3, "y": 1, "customdata": ["no_metric", "no glass"]})
    visitor.report("summary", click={"curve": 1, "x": 3, "y": 1, "customdata": ["height_mape", "Average"]})
    assert any(each.value == "Height, all containers: 6 recordings" for each in visitor.test.subheader)

    select(visitor, 0, cell=(0, "container"))
    name = worst["recording"].iloc[0]
    assert any(each.value == f"Recording {name}" for each in visitor.test.subheader)
    panel = next(each.value for each in visitor.test.dataframe if "Quantity" in each.value)
    assert list(panel["Quantity"])[:3] == ["Level", "Type", "Capacity"]
    assert visitor.crashes == visitor.errors == []
    visitor.widget("close_panel").click().run()
    assert not any(each.value == f"Recording {name}" for each in visitor.test.subheader)
    visitor.choose("worst_metric", "mass_mape")
    assert visitor.test.dataframe[0].value["Mass"].abs().is_monotonic_decreasing
    select(visitor, 0, cell=(1, "Mass"))
    visitor.widget("panel mass").click().run()
    assert visitor.test.title[0].value == "Mass"


def test_runs_are_kept_as_people_keep_them(visitor: Visitor) -> None:
    visitor.choose("evaluation_view", "runs")
    shown = visitor.test.dataframe[0].value
    assert sorted(shown["name"]) == ["paper", "tuned"]
    assert shown["recordings"].tolist() == ["6 of 6"] * 2
    assert shown[["capacity_mape", "filling_type_mpf1"]].notna().all(axis=None)
    row = shown["name"].tolist().index("paper")

    tick(visitor, [row])
    run = next(run for run in list_runs(store=shared.store()) if run.name == "paper")
    for name, said in (
        ("tuned", "the name 'tuned' is taken"),
        ("<i>x</i>", "begins with a letter"),
        ("", "needs a name"),
    ):
        visitor.widget(f"label_name {run.id}").set_value(name)
        visitor.press("Save")
        assert said in visitor.errors[0], name
    visitor.widget(f"label_name {run.id}").set_value("as published")
    visitor.widget(f"label_note {run.id}").set_value("<script>alert(1)</script> **bold**")
    visitor.press("Save")
    assert sorted(visitor.test.dataframe[0].value["name"]) == ["as published", "tuned"]
    assert "<script>alert(1)</script> **bold**" in visitor.test.dataframe[0].value["note"].tolist()

    tick(visitor, [0, 1])
    differences = next(each.value for each in visitor.test.dataframe if "what" in each.value)
    assert set(differences.columns) == {"what", "as published", "tuned"}
    assert not differences["what"].str.contains("_mm").any()
    names = [trace["name"] for trace in visitor.plots["overlay"]["figure"]["data"]]
    assert names[0].startswith("paper")
    assert set(names[1:]) == {"as published", "tuned"}

    tick(visitor, [row])
    visitor.press("Show its results")
    assert visitor.address["run"] == run.short_id  # as before it was renamed
    assert visitor.widget("run_picker").value == run.short_id
    visitor.choose("evaluation_view", "runs")
    tick(visitor, [row])
    visitor.press("Archive")
    assert visitor.test.dataframe[0].value["name"].tolist() == ["tuned"]
    visitor.test.toggle(key="runs_archived").set_value(True).run()
    tick(visitor, [visitor.test.dataframe[0].value["name"].tolist().index("as published")])
    visitor.press("Out of the archive")
    visitor.press("Delete")
    assert visitor.test.dataframe[0].value["name"].tolist() == ["tuned"]
    assert "as published" in visitor.sentences
    visitor.press("Restore")
    assert sorted(visitor.test.dataframe[0].value["name"]) == ["as published", "tuned"]
    assert visitor.crashes == visitor.errors == []


def tick(visitor: Visitor, rows: list[int]) -> None:
    key = visitor.test.dataframe[0].proto.id.split("-", 2)[2]
    visitor.test.session_state[key] = {"selection": {"rows": rows, "columns": [], "cells": []}}
    visitor.test.run()
