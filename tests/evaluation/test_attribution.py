import math

import numpy as np
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
from corsmal.evaluation.attribution_words import gone_text, stage_sentences
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


def attributed(estimates, replaced, annotation):
    table = attribution_table(estimates, replaced, annotation, rng=np.random.default_rng(0), resamples=200)
    return table.set_index(["stage", "container", "metric"])


def test_attribution_by_hand(annotation, estimates):
    half = estimates.assign(
        capacity_ml=estimates["capacity_ml"] * 1.25 / 1.5,
        height_mm=estimates["height_mm"] * 0.5,
        filling_type=pd.NA,  # the filling is the run's, and what the networks were trained on
        mass_held_out=pd.NA,
    )
    table = attributed(estimates, {"as it is": estimates, "half": half}, annotation)
    assert list(dict.fromkeys(table.index.get_level_values("stage"))) == ["half", "filling"]
    assert len(table) == 2 * 4 * 7
    cup = table.loc[("half", "red cup", "capacity_mape")]
    assert cup[["before", "after", "gone", "share"]].tolist() == pytest.approx([50, 25, 25, 50])
    assert cup[["low", "high", "share_low", "share_high"]].tolist() == pytest.approx([25, 25, 50, 50])
    grown = table.loc[("half", "Average", "height_mape")]
    assert grown[["before", "after", "gone"]].tolist() == pytest.approx([20, 60, -40])
    assert grown[["share", "share_high"]].tolist() == [0, 0]  # clipped: nothing of it went away
    assert table.loc[("half", "cereal box", "filling_type_mpf1"), "gone"] == 0
    assert table.loc[("filling", "cereal box", "filling_type_mpf1"), "share"] == pytest.approx(100)
    small = table.loc[("filling", "red cup", "width_top_mape")]  # nothing was wrong
    assert (small["gone"], pd.isna(small["share"])) == (0, True)


def test_a_difference_of_containers_that_were_filmed_once_has_an_interval(annotation, estimates):
    rows = estimates.iloc[:3].assign(capacity_ml=lambda table: table["capacity_ml"] * [1.0, 1.2, 1.4])
    table = attributed(rows, {"masks": rows.assign(capacity_ml=rows["capacity_ml"] / 1.2)}, annotation)
    assert pd.isna(table.loc[("masks", "red cup", "capacity_mape"), "low"])
    average = table.loc[("masks", "Average", "capacity_mape")]
    assert average["low"] < average["gone"] < average["high"]


def test_a_sentence_per_stage_tells_shares_with_intervals_and_small_errors_in_percent_only(annotation, estimates):
    better = estimates.assign(capacity_ml=estimates["capacity_ml"] / 1.5, height_mm=estimates["height_mm"] * 0.5)
    estimates["width_top_mm"] *= 1.03
    said = stage_sentences(attributed(estimates, {"masks": better}, annotation).reset_index())
    assert list(said) == ["masks", "filling"]
    assert said["masks"] == (
        "With the true masks in all frames the error of capacity falls from 50.0 to 0.0 % (100 % less), that of top "
        "width from 3.0 to 0.0 %; the error of height grows from 20.0 to 60.0 %; nothing changes for filling level "
        "(100 − MPF1), filling type (100 − MPF1), bottom width and mass."
    )
    assert "the error of filling type (100 − MPF1) falls from" in said["filling"]
    assert "_" not in "".join(said.values())


def test_what_goes_away_is_told_in_a_few_signs():
    row = {"gone": 12.0, "share": 57.6}
    assert gone_text(row) == "58 %"
    assert gone_text({"gone": -700.0, "share": 0.0}) == "+700.0"
    assert gone_text({"gone": 1.26, "share": math.nan}) == "−1.3"
    assert gone_text({"gone": 0.01, "share": 0.1}) == "0"


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
