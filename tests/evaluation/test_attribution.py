import math

import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import (
    ablation_table,
    attribution_table,
    container_table,
    error_table,
    estimates_table,
    with_true_filling,
)
from tests.evaluation.made import made_annotation, perfect_estimates


@pytest.fixture
def annotation():
    return made_annotation()


@pytest.fixture
def estimates(annotation):
    table = perfect_estimates(annotation)
    table["capacity_ml"] *= 1.5
    table["height_mm"] *= 0.8
    table["container_mass_g"] *= 2
    table["filling_type"] = 2
    return table


def test_true_filling_makes_no_error_and_leaves_the_others(annotation, estimates):
    table = container_table(error_table(with_true_filling(estimates, annotation), annotation))
    assert table["filling_type_mpf1"].eq(100).all()
    for metric, value in {"capacity_mape": 50, "height_mape": 20, "mass_mape": 100}.items():
        assert table[metric].tolist() == pytest.approx([value] * 4)


def test_masses_follow_from_the_true_filling(annotation, estimates):
    true = perfect_estimates(annotation).assign(container_mass_g=estimates["container_mass_g"], filling_type=2)
    table = with_true_filling(true, annotation)
    assert table["filling_mass_g"].tolist() == pytest.approx(annotation["filling mass"].tolist())
    expected = annotation["filling mass"] + 2 * annotation["container mass"]
    assert table["object_mass_g"].tolist() == pytest.approx(expected.tolist())


def test_what_the_annotation_does_not_know_stays_as_estimated(annotation, estimates):
    annotation["filling type"] = annotation["filling type"].astype("float64")
    annotation.loc[0, "filling type"] = math.nan
    assert with_true_filling(estimates, annotation)["filling_type"].iloc[0] == 2


def test_attribution_by_hand(annotation, estimates):
    half = estimates.assign(
        capacity_ml=estimates["capacity_ml"] * 1.25 / 1.5,
        height_mm=estimates["height_mm"] * 0.5,
        filling_type=pd.NA,  # the filling is the run's, and what the networks were trained on
        mass_held_out=pd.NA,
    )
    table = attribution_table(estimates, {"half": half}, annotation).set_index(["stage", "container"])
    assert len(table) == 3 * 4
    assert list(dict.fromkeys(table.index.get_level_values("stage"))) == ["as it is", "half", "filling"]
    assert table.loc[("as it is", "red cup"), "capacity_mape"] == pytest.approx(50)
    assert table.loc[("as it is", "red cup"), "capacity_mape_removed"] == 0
    assert table.loc[("half", "red cup"), "capacity_mape"] == pytest.approx(25)
    assert table.loc[("half", "red cup"), "capacity_mape_removed"] == pytest.approx(50)
    assert table.loc[("half", "Average"), "height_mape_removed"] == pytest.approx(-200)
    assert table.loc[("half", "cereal box"), "filling_type_mpf1_removed"] == 0
    assert table.loc[("filling", "cereal box"), "filling_type_mpf1_removed"] == pytest.approx(100)
    assert math.isnan(table.loc[("filling", "red cup"), "width_top_mape_removed"])


def test_ablation_by_hand(annotation, estimates):
    annotation["container id"] = annotation["container id"].replace({annotation["container id"].iloc[-1]: 12})
    rows = estimates.assign(height_mm_low=0.7 * estimates["height_mm"], height_mm_high=1.3 * estimates["height_mm"])
    rows.loc[0, ["capacity_ml", "width_top_mm"]] = math.nan
    table = ablation_table({("detected", "tuned"): estimates_table(rows)}, annotation)
    found = table.loc[("detected", "tuned", "all")]
    assert found["height_mm"] == pytest.approx(20)
    assert found["capacity_ml"] == pytest.approx(50)
    assert found["failed"] == 1
    assert found["height_mm inside"] == 100  # 0.8 of the truth, times 1.3, is above it
    assert math.isnan(found["capacity_ml inside"])
    assert table.loc[("detected", "tuned", "unseen"), "failed"] == 0


def test_bad_input_is_one_clear_sentence(annotation):
    with pytest.raises(ArgumentError, match="estimates must hold at least one table"):
        ablation_table({}, annotation)
