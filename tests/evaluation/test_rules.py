import numpy as np
import pandas as pd
import pytest

from corsmal.evaluation import estimates_table, paper_table_2
from corsmal.evaluation.rules import (
    PUBLISHED,
    SHAPE_METRICS,
    average_errors,
    average_texts,
    height_sentence,
    rule_effects,
    side_by_side,
)
from corsmal.quantities import GEOMETRY
from tests.evaluation.made import CONTAINERS, made_annotation


def estimates_with(**factors):
    """Estimates that are the truth times a factor by quantity, of two recordings per container."""
    rows = []
    for row in made_annotation(6).to_dict("records"):
        top, bottom, height, capacity, _ = CONTAINERS[row["container id"]]
        true = dict(zip(GEOMETRY, (capacity, top, bottom, height), strict=True))
        values = {name: value * factors.get(name, 1.0) for name, value in true.items()}
        rows.append({"recording_id": f"{row['id']:06d}", "status": "fitted", **values})
    return estimates_table(rows)


TABLES = {
    "paper": estimates_with(height_mm=0.9),
    "released": estimates_with(height_mm=1.3, width_top_mm=0.5),
    "paper with height rule": estimates_with(height_mm=1.25),
}


def test_errors_stand_side_by_side_with_the_published_ones():
    table = side_by_side(TABLES, made_annotation(6))
    assert list(dict.fromkeys(table["metric"])) == list(SHAPE_METRICS)
    height = table[table["metric"] == "height_mape"]
    average = height[height["container"] == "Average"].set_index("condition")
    assert list(average.index) == [PUBLISHED, *TABLES]
    assert average.loc["paper", "error"] == pytest.approx(10)
    assert average.loc["paper", "signed"] == pytest.approx(-10)
    assert average.loc["released", "signed"] == pytest.approx(30)
    assert average.loc["paper", "recordings"] == 6
    published = paper_table_2().set_index("container_id")["height_mape"]
    one = height[height["container_id"] == 4].set_index("condition")
    assert one.loc[PUBLISHED, "error"] == published.loc[4]
    assert one.loc["released", "error"] == pytest.approx(30)
    assert average.loc[PUBLISHED, "error"] == pytest.approx(30.8)


def test_averages_have_a_row_per_condition_in_the_given_order():
    found = average_errors(side_by_side(TABLES, made_annotation(6)), ["released", "lode", PUBLISHED])
    assert list(found.index) == ["released", PUBLISHED]
    assert found.index.name == "method"
    assert found.loc["released", "height_mape"] == pytest.approx(30)
    assert found.loc["released", "height_signed_percent"] == pytest.approx(30)
    assert found.loc["released", "width_top_signed_percent"] == pytest.approx(-50)
    assert found.loc[PUBLISHED, "height_mape"] == pytest.approx(30.8)
    assert np.isnan(found.loc[PUBLISHED, "height_signed_percent"])
    texts = average_texts(found)
    assert list(texts.loc["released"]) == ["0.0 (+0.0)", "50.0 (−50.0)", "0.0 (+0.0)", "30.0 (+30.0)"]
    assert texts.loc[PUBLISHED, "Height"] == "30.8"


def test_effects_are_the_changes_of_the_average():
    switched = {"height rule": TABLES["paper with height rule"], "all": TABLES["released"]}
    effects = rule_effects(TABLES["paper"], switched, made_annotation(6), rng=np.random.default_rng(0))
    found = effects.set_index(["rule", "metric"])
    assert found.loc[("height rule", "height_mape"), "gone"] == pytest.approx(-15)
    assert found.loc[("height rule", "capacity_mape"), "gone"] == pytest.approx(0)
    assert found.loc[("all", "width_top_mape"), "after"] == pytest.approx(50)
    assert set(effects["metric"]) == set(SHAPE_METRICS)


def test_the_sentence_says_what_the_height_rule_makes_of_the_difference():
    text = height_sentence(side_by_side(TABLES, made_annotation(6)), height_rule="paper with height rule")
    assert "The published error of the height is 30.8 %" in text
    assert "`paper` has 10.0 % (mean signed error −10.0 %)" in text
    assert "lie +20.0 points; the height rule by itself makes +15.0." in text


def test_a_container_that_the_paper_does_not_have_has_no_published_row():
    annotation = made_annotation(6)
    annotation["container id"] = annotation["container id"].replace({7: 12})
    tables = {"paper": estimates_with()}
    table = side_by_side(tables, annotation)
    assert set(table.loc[table["container_id"] == 12, "condition"]) == {"paper"}
    assert pd.api.types.is_integer_dtype(table["container_id"])
