import numpy as np
import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import (
    METRICS,
    challenge_scores,
    confusion_tables,
    container_table,
    error_table,
    read_estimates,
    submission_table,
    write_estimates,
)
from tests.evaluation.made import made_annotation, perfect_estimates

FILLING = ["filling_level_mpf1", "filling_type_mpf1"]


@pytest.fixture
def annotation():
    return made_annotation()


@pytest.fixture
def estimates(annotation):
    """Right on the 28 recordings that the networks were trained on, wrong on the other 14."""
    table = perfect_estimates(annotation)
    table["filling_held_out"] = table["mass_held_out"] = np.arange(42) % 3 == np.arange(42) // 14
    new = table["filling_held_out"]
    table.loc[new, "filling_type"] = (table.loc[new, "filling_type"] + 1) % 4
    table.loc[new, "filling_level"] = (table.loc[new, "filling_level"] + 1) % 3
    table.loc[new, "container_mass_g"] *= 3
    return table


def test_only_recordings_that_no_network_was_trained_on_count(annotation, estimates):
    errors = error_table(estimates, annotation)
    average = container_table(errors).iloc[-1]
    assert average["protocol"] == "held-out"
    assert average[FILLING].tolist() == [0, 0]
    assert average["mass_mape"] == pytest.approx(200)
    assert average["capacity_mape"] == 0  # geometry is not trained
    assert errors["filling_left_out"].sum() == errors["mass_left_out"].sum() == 28
    assert sum(int(table.to_numpy().sum()) for table in confusion_tables(errors, "filling_type").values()) == 14
    notes = errors.attrs["notes"]
    assert notes[0].startswith("Level and type: 28 of 42 recordings are left out (protocol held-out)")
    assert notes[1] == ("Mass: 28 of 42 recordings are left out (protocol held-out): the network was trained on them")


def test_in_sample_counts_everything_and_says_so(annotation, estimates):
    errors = error_table(estimates, annotation, protocol="in-sample")
    table = container_table(errors)
    assert table["protocol"].eq("in-sample").all()
    assert table["mass_mape"].iloc[-1] == pytest.approx(200 / 3)
    assert sum(int(table.to_numpy().sum()) for table in confusion_tables(errors, "filling_type").values()) == 42
    assert errors.attrs["notes"][0].startswith("In-sample: networks are judged on recordings that they were trained on")
    assert "Mass: 28 of 42 recordings are in-sample: the network was trained on them" in errors.attrs["notes"]


def test_scores_leave_out_what_the_tables_leave_out(annotation, estimates):
    errors = error_table(estimates, annotation)
    scores = challenge_scores(annotation, submission_table(estimates), split="other", errors=errors)
    assert scores[["s1", "s2", "JFTL"]].tolist() == [0, 0, 0]
    assert scores["s7"] == pytest.approx(100 * np.exp(-2))
    assert scores["s3"] == 100
    assert not scores.attrs["is_whole"]
    every = challenge_scores(annotation, submission_table(estimates), split="other")
    assert every["s7"] == pytest.approx(100 * (28 + 14 * np.exp(-2)) / 42)


def test_random_labels_that_a_network_knows_by_heart_are_no_result():
    """Labels without anything to learn: a network that memorised them is at 100 % on them, and at chance elsewhere."""
    rng = np.random.default_rng(0)
    annotation = made_annotation(420)
    annotation["filling type"], annotation["filling level"] = rng.integers(0, 4, 420), rng.integers(0, 3, 420)
    estimates = perfect_estimates(annotation)
    new = rng.random(420) < 0.5
    estimates["filling_held_out"] = new
    estimates.loc[new, "filling_type"] = rng.integers(0, 4, new.sum())
    estimates.loc[new, "filling_level"] = rng.integers(0, 3, new.sum())
    average = container_table(error_table(estimates, annotation)).iloc[-1]
    assert average["filling_type_mpf1"] == pytest.approx(25, abs=8)
    assert average["filling_level_mpf1"] == pytest.approx(33, abs=8)
    memorised = error_table(estimates[~new].assign(filling_held_out=False), annotation, protocol="in-sample")
    assert container_table(memorised).iloc[-1][FILLING].tolist() == [100, 100]


@pytest.mark.parametrize("unknown", [None, pd.NA, "", "perhaps"])
def test_weights_of_unknown_origin_count_as_trained_on_everything(annotation, estimates, unknown):
    errors = error_table(estimates.assign(mass_held_out=unknown, mass_weights="abc"), annotation)
    assert errors["mass_left_out"].all()
    assert container_table(errors)["mass_mape"].isna().all()
    assert (
        "Mass: 42 of 42 recordings are left out (protocol held-out): it is not known what the network was trained on, "
        "so it counts as trained on all of them"
    ) in errors.attrs["notes"]


def test_a_table_without_these_columns_has_only_geometry(annotation):
    given = ["recording_id", "status", "capacity_ml", "height_mm", "filling_type", "container_mass_g"]
    estimates = perfect_estimates(annotation)[given]
    estimates.loc[0, "filling_type"] = -1
    average = container_table(error_table(estimates, annotation)).iloc[-1]
    assert average["capacity_mape"] == 0
    assert average[["filling_type_mpf1", "mass_mape"]].isna().all()
    shown = container_table(error_table(estimates, annotation, protocol="in-sample")).iloc[-1]
    assert shown["mass_mape"] == 0


def test_what_was_not_estimated_is_not_left_out(annotation, estimates):
    bare = estimates.drop(columns=["filling_type", "filling_level", "filling_held_out"])
    errors = error_table(bare, annotation)
    assert not errors["filling_left_out"].any()
    assert not any(note.startswith("Level") for note in errors.attrs["notes"])


def test_a_recording_that_failed_before_the_network_is_a_wrong_answer_and_not_left_out(annotation):
    estimates = perfect_estimates(annotation)
    estimates["filling_held_out"] = estimates["filling_held_out"].astype("boolean")
    estimates.loc[0, ["filling_type", "filling_level", "filling_held_out"]] = [-1, -1, pd.NA]
    errors = error_table(estimates, annotation)
    assert not errors["filling_left_out"].any()
    assert not errors.loc["000000", "filling_type_correct"]


def test_training_means_are_held_out_without_a_network(annotation):
    estimates = perfect_estimates(annotation).drop(columns="mass_held_out")
    estimates["status"] = "fallback: training mean"
    errors = error_table(estimates, annotation)
    assert not errors["mass_left_out"].any()
    assert container_table(errors)["mass_mape"].eq(0).all()
    assert errors["failed"].all()


def test_the_papers_protocol_admits_numbers_whose_epoch_was_chosen_on_them(annotation):
    estimates = perfect_estimates(annotation).assign(protocol="paper")
    estimates["mass_held_out"] = np.arange(42) >= 21
    held_out = error_table(estimates, annotation)
    assert held_out["filling_left_out"].all()
    assert held_out["mass_left_out"].all()
    assert any("the epoch of their network was chosen on them" in note for note in held_out.attrs["notes"])
    paper = error_table(estimates, annotation, protocol="paper")
    assert not paper["filling_left_out"].any()
    assert paper["mass_left_out"].sum() == 21
    assert container_table(paper)["protocol"].eq("paper").all()


def test_flags_survive_a_csv_file(annotation, estimates, tmp_path):
    estimates["mass_held_out"] = estimates["mass_held_out"].astype("boolean")
    estimates.loc[0, "mass_held_out"] = pd.NA
    for ending in ("csv", "json", "parquet"):
        write_estimates(estimates, tmp_path / f"table.{ending}")
        again = read_estimates(tmp_path / f"table.{ending}")
        assert again["mass_held_out"].tolist()[1:] == estimates["mass_held_out"].tolist()[1:]
        assert pd.isna(again["mass_held_out"].iloc[0])
        pd.testing.assert_frame_equal(
            container_table(error_table(again, annotation))[list(METRICS)],
            container_table(error_table(estimates, annotation))[list(METRICS)],
        )


def test_unknown_protocol_is_one_clear_sentence(annotation, estimates):
    with pytest.raises(ArgumentError, match="protocol must be one of held-out, paper, in-sample, got 'best'"):
        error_table(estimates, annotation, protocol="best")
