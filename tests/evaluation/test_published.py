import numpy as np
import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import (
    LEADERBOARD_SPLITS,
    METRICS,
    cell_table,
    challenge_scores,
    container_table,
    error_table,
    leaderboard,
    leaderboard_row,
    leaderboard_with,
    overall_score,
    paper_table_2,
)
from corsmal.evaluation.published import SCORE_NAMES, THIS_PAPER
from tests.evaluation.made import made_annotation, perfect_estimates, perfect_submission


def test_average_row_of_table_2_is_the_mean_of_its_nine_rows_but_for_the_mass():
    table = paper_table_2()
    means = table[list(METRICS)][:9].mean()
    printed = table[list(METRICS)].iloc[9]
    assert table["container"].iloc[9] == "Average"
    np.testing.assert_allclose(means.drop("mass_mape"), printed.drop("mass_mape").astype(float), atol=0.05)
    # The printed rows of the mass give 182.52, the printed average is 182.8.
    assert means["mass_mape"] == pytest.approx(182.522, abs=0.001)
    assert printed["mass_mape"] == 182.8


def test_average_row_of_table_2_is_reproduced_by_our_table():
    """Estimates with the paper's error in every recording of a container give the paper's rows, and so its average."""
    paper = paper_table_2()
    annotation = made_annotation(9)
    annotation["container id"] = range(1, 10)
    estimates = perfect_estimates(annotation)
    names = ["capacity_ml", "width_top_mm", "width_bottom_mm", "height_mm", "container_mass_g"]
    mapes = [name for name in METRICS if name.endswith("_mape")]
    for name, metric in zip(names, mapes, strict=True):
        estimates[name] *= 1 + paper[metric][:9] / 100
    errors = error_table(estimates, annotation)
    table = container_table(errors)
    np.testing.assert_allclose(table[mapes][:9], paper[mapes][:9])
    np.testing.assert_allclose(
        table[mapes[:-1]].iloc[9].astype(float), paper[mapes[:-1]].iloc[9].astype(float), atol=0.05
    )
    cells = cell_table(errors, rng=np.random.default_rng(0), resamples=100)
    of_numbers = cells[cells["metric"].isin(mapes)]
    np.testing.assert_allclose(of_numbers["difference"][of_numbers["container_id"].notna()], 0, atol=1e-9)
    # the printed average of the mass is not the mean of its printed rows
    averages = of_numbers[of_numbers["container_id"].isna()].set_index("metric")["difference"]
    np.testing.assert_allclose(averages, [0, 0, 0, 0, 182.522 - 182.8], atol=0.05)


@pytest.mark.parametrize("split", LEADERBOARD_SPLITS)
def test_overall_of_every_team_is_reproduced_from_its_scores(split):
    table = leaderboard(split)
    assert len(table) == 12
    scores = {score: table[name] for score, name in SCORE_NAMES.items()}
    # the simulator's two scores are weighted by the share of the five tasks that a team attempted
    dimensions = ["width_top", "width_bottom", "height"]
    tasks = [["filling_level"], ["filling_type"], ["capacity"], ["container_mass"], dimensions]
    attempted = sum(table[names].gt(0).any(axis=1) for names in tasks) / len(tasks)
    simulator = (table["object_safety"] + table["delivery_accuracy"]) * attempted
    # 0.006: what is printed is rounded to two places, and the overall score once more.
    np.testing.assert_allclose(overall_score(scores) + simulator / 8, table["overall"], atol=0.006)
    np.testing.assert_allclose(table["overall_without_simulator"] + simulator / 8, table["overall"], atol=0.006)


@pytest.fixture
def scores():
    annotation = made_annotation()
    return challenge_scores(annotation, perfect_submission(annotation), split="private")


def test_our_row_stands_among_the_teams_of_its_own_set(scores):
    table = leaderboard_with(scores, split="private", name="ours")
    assert table["team"].iloc[0] == "ours"
    assert table["overall_without_simulator"].is_monotonic_decreasing
    assert table.loc[0, "capacity"] == pytest.approx(100)
    assert table.loc[0, ["overall", "object_safety", "delivery_accuracy"]].isna().all()
    assert len(table) == 13


@pytest.mark.parametrize("split", ["public", "combined"])
def test_a_row_of_other_recordings_does_not_stand_among_the_teams(scores, split):
    with pytest.raises(ArgumentError, match=f"scores must be of all recordings of the {split} set"):
        leaderboard_with(scores, split=split, name="ours")


@pytest.mark.parametrize("split", ["other", "train"])
def test_a_row_of_no_test_set_stands_among_no_teams(split):
    annotation = made_annotation()
    scores = challenge_scores(annotation, perfect_submission(annotation), split=split)
    with pytest.raises(ArgumentError, match=rf"got {split}, all recordings"):
        leaderboard_with(scores, split="public", name="the demo")


def test_a_part_of_a_test_set_does_not_stand_among_the_teams():
    annotation = made_annotation()
    scores = challenge_scores(annotation, perfect_submission(annotation)[:5], split="public", absent="skip")
    with pytest.raises(ArgumentError, match="got public, not all recordings"):
        leaderboard_with(scores, split="public", name="ours")


def test_a_row_apart_has_the_columns_of_a_leaderboard(scores):
    row = leaderboard_row(scores, name="ours")
    assert row.columns.equals(leaderboard("public").columns)
    assert row.loc[0, "overall_without_simulator"] == scores["overall"]
    assert row.loc[0, "filling_mass"] == scores["s8"]


def test_tables_are_ones_own_to_change():
    table = paper_table_2()
    table.loc[0, "capacity_mape"] = 0
    assert paper_table_2().loc[0, "capacity_mape"] == 34.2


def test_figures_are_the_published_ones(shared_root):
    table_2, table_3 = (pd.read_csv(shared_root / "reference" / f"paper_table{number}.csv") for number in (2, 3))
    pd.testing.assert_frame_equal(paper_table_2(), table_2, check_dtype=False)
    for row in table_3.to_dict("records"):
        own = leaderboard(row.pop("split")).set_index("team").loc[THIS_PAPER]
        np.testing.assert_allclose(own[list(row)].astype(float), list(row.values()))


def test_unknown_split_is_an_error():
    with pytest.raises(ArgumentError, match="split must be one of public, private, combined, got 'train'"):
        leaderboard("train")
