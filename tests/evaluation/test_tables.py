import math

import numpy as np
import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import (
    METRICS,
    confusion_tables,
    container_table,
    error_table,
    mape,
    metric_of,
    mpf1,
    recordings_behind,
    recordings_confused,
)
from tests.evaluation.made import made_annotation, perfect_estimates


@pytest.fixture
def annotation():
    return made_annotation()


@pytest.fixture
def estimates(annotation):
    """Off by a different amount in every recording, some answers wrong, some missing."""
    rng = np.random.default_rng(1)
    table = perfect_estimates(annotation)
    for name in ("capacity_ml", "width_top_mm", "width_bottom_mm", "height_mm", "container_mass_g"):
        table[name] *= rng.uniform(0.3, 2.5, len(table))
    table["filling_type"] = rng.integers(0, 4, len(table))
    table["filling_level"] = rng.integers(-1, 3, len(table))
    table.loc[[0, 7], "capacity_ml"] = [math.nan, -1]
    table.loc[[0, 3, 4], "status"] = ["failed", "fallback: training mean", "fitted, second pair"]
    return table


def test_errors_of_one_recording_by_hand(annotation):
    estimates = perfect_estimates(annotation)
    estimates.loc[3, ["capacity_ml", "height_mm", "filling_mass_g"]] = [624.0, 59.5, 100.0]
    estimates.loc[3, "filling_type"] = 2
    row = error_table(estimates, annotation).loc["000003"]
    assert (row["container"], row["kind"], row["failed"]) == ("red cup", "cup", False)
    assert row["capacity_error_percent"] == pytest.approx(20)
    assert row["height_error_percent"] == pytest.approx(-50)
    assert row["width_top_error_percent"] == 0
    assert (row["filling_type"], row["filling_type_true"], row["filling_type_correct"]) == (2, 1, False)
    assert row["filling_level_correct"]
    assert row["filling_mass_error_g"] == pytest.approx(100 - 0.5 * 520 * 0.34)


def test_table_2_agrees_with_the_metrics_container_by_container(annotation, estimates):
    table = container_table(error_table(estimates, annotation))
    assert table["container"].tolist() == ["red cup", "green glass", "cereal box", "Average"]
    assert table["container_id"].tolist()[:3] == [1, 4, 7]
    assert table["container_id"].isna().tolist() == [False, False, False, True]
    for row in range(3):
        own = annotation["container id"] == table.loc[row, "container_id"]
        known, said = annotation[own], estimates[own]
        expected = {
            "filling_level_mpf1": mpf1(known["filling level"], said["filling_level"]),
            "filling_type_mpf1": mpf1(known["filling type"], said["filling_type"]),
            "capacity_mape": mape(said["capacity_ml"], known["container capacity"]),
            "width_top_mape": mape(said["width_top_mm"], known["width at the top"]),
            "width_bottom_mape": mape(said["width_bottom_mm"], known["width at the bottom"]),
            "height_mape": mape(said["height_mm"], known["height"]),
            "mass_mape": mape(said["container_mass_g"], known["container mass"]),
        }
        assert table.loc[row, list(METRICS)].to_dict() == pytest.approx(expected)
    np.testing.assert_allclose(
        table.loc[3, list(METRICS)].to_numpy(dtype=float), table.loc[:2, list(METRICS)].mean().to_numpy()
    )
    assert table["recordings"].tolist() == [14, 14, 14, 42]


def test_failures_are_counted_and_not_averaged_away(annotation):
    estimates = perfect_estimates(annotation)
    estimates.loc[[0, 3], "status"] = ["failed", "fallback: training mean"]
    estimates.loc[0, ["capacity_ml", "width_top_mm", "width_bottom_mm", "height_mm"]] = math.nan
    estimates.loc[3, "capacity_ml"] *= 1.5
    estimates.loc[1, "filling_type"] = -1
    errors = error_table(estimates, annotation)
    table = container_table(errors)
    assert table["failures"].tolist() == [2, 1, 0, 3]
    assert table.loc[0, "capacity_mape"] == pytest.approx(50 / 13)
    # Green glass: of its two empty recordings one has no answer.
    assert table.loc[1, "filling_type_mpf1"] == pytest.approx(100 * (2 / 3 + 3) / 4)
    assert recordings_behind(errors, "failures").index.tolist() == ["000000", "000001", "000003"]
    assert recordings_behind(errors, "failures", container_id=4).index.tolist() == ["000001"]


def test_what_was_not_estimated_at_all_is_an_empty_cell_and_no_failure(annotation):
    estimates = perfect_estimates(annotation).drop(columns=["container_mass_g", "filling_type", "filling_level"])
    errors = error_table(estimates, annotation)
    table = container_table(errors)
    assert table[["mass_mape", "filling_type_mpf1", "filling_level_mpf1"]].isna().all(axis=None)
    assert table["capacity_mape"].eq(0).all()
    assert table["failures"].eq(0).all()
    note = "estimates: there is no container mass for any recording; its cells are empty and it counts no failure"
    assert note in errors.attrs["notes"]
    assert errors["filling_type_correct"].isna().all()


def test_annotation_without_truth_says_so_and_the_rest_is_computed(annotation):
    estimates = perfect_estimates(annotation)
    bare = error_table(estimates, annotation[["id", "container id"]])
    assert container_table(bare)[list(METRICS)].isna().all(axis=None)
    assert "annotation: there is no truth of the height: its estimates cannot be judged" in bare.attrs["notes"]
    part = annotation.copy()
    part.loc[0, ["height", "filling type"]] = -1
    errors = error_table(estimates, part)
    assert container_table(errors)["height_mape"].eq(0).all()
    assert "annotation: there is no height of recording 000000: it cannot be judged there" in errors.attrs["notes"]
    assert not errors["failed"].any()
    ids_alone = error_table(estimates, annotation[["id"]])
    with pytest.raises(ArgumentError, match="a recording whose container is known"):
        container_table(ids_alone)


def test_minus_one_everywhere_gives_empty_cells_and_sentences(annotation):
    estimates = perfect_estimates(annotation)
    numbers = estimates.columns.drop(["recording_id", "status", "pair", "notes"])
    estimates[numbers] = -1
    errors = error_table(estimates, annotation)
    assert container_table(errors)[list(METRICS)].isna().all(axis=None)
    assert sum("estimates: there is no" in note for note in errors.attrs["notes"]) == 7


def test_container_of_another_set_is_named_by_its_number(annotation):
    annotation["container id"] += 10
    table = container_table(error_table(perfect_estimates(annotation), annotation))
    assert table["container"].tolist() == ["container 11", "container 14", "container 17", "Average"]


@pytest.mark.parametrize("metric", METRICS)
def test_recordings_behind_a_cell_give_its_number_and_the_worst_come_first(annotation, estimates, metric):
    errors = error_table(estimates, annotation)
    table = container_table(errors).set_index("container")
    rows = recordings_behind(errors, metric, container_id=1)
    assert rows["container"].eq("red cup").all()
    assert metric_of(rows, metric) == pytest.approx(table.loc["red cup", metric])
    column = METRICS[metric]
    if metric.endswith("_mape"):
        sizes = rows[column].abs().fillna(math.inf).tolist()
        assert sizes == sorted(sizes, reverse=True)
        assert len(rows) == 14
    else:
        ranks = [-1 if pd.isna(row[column]) else int(row[f"{column}_correct"]) for _, row in rows.iterrows()]
        assert ranks == sorted(ranks)
    assert set(recordings_behind(errors, metric).index) == set(errors.index)


@pytest.mark.parametrize("quantity", ["filling_type", "filling_level"])
def test_confusion_by_kind_counts_the_recordings_behind_each_cell(annotation, estimates, quantity):
    errors = error_table(estimates, annotation)
    tables = confusion_tables(errors, quantity)
    assert list(tables) == ["cup", "glass", "box"]
    assert sum(int(table.to_numpy().sum()) for table in tables.values()) == len(annotation)
    for kind, table in tables.items():
        classes = len(table)
        for row in range(classes):
            for column in range(classes + 1):
                behind = recordings_confused(
                    errors,
                    quantity,
                    kind=kind,
                    true_class=row,
                    predicted_class=column if column < classes else -1,
                )
                assert len(behind) == table.iloc[row, column]
    expected = sum(
        known == 1 and said == 2 and container == 4
        for known, said, container in zip(
            annotation[quantity.replace("_", " ")], estimates[quantity], annotation["container id"], strict=True
        )
    )
    assert tables["glass"].iloc[1, 2] == expected


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda errors: metric_of(errors, "mape"), "metric must be one of filling_level_mpf1"),
        (lambda errors: metric_of(errors[["kind"]], "mass_mape"), "errors must come from error_table"),
        (lambda errors: recordings_behind(errors, "x"), "metric must be one of"),
        (lambda errors: confusion_tables(errors, "height_mm"), "quantity must be one of filling_type, filling_level"),
        (lambda errors: confusion_tables(errors[["kind"]], "filling_type"), "errors must come from error_table"),
        (lambda errors: container_table(errors[["kind"]]), "errors must be an error table"),
        (lambda errors: container_table(errors[:0]), "a recording whose container is known"),
    ],
)
def test_bad_input_is_one_clear_sentence(annotation, call, message):
    with pytest.raises(ArgumentError, match=message):
        call(error_table(perfect_estimates(annotation), annotation))
