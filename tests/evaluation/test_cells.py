import math

import numpy as np
import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import METRICS, cell_table, comparison_note, container_table, error_table, paper_table_2
from tests.evaluation.made import made_annotation, perfect_estimates

COLUMNS = {
    "capacity_mape": "capacity_ml",
    "width_top_mape": "width_top_mm",
    "width_bottom_mape": "width_bottom_mm",
    "height_mape": "height_mm",
    "mass_mape": "container_mass_g",
}


@pytest.fixture
def annotation():
    return made_annotation(63)


@pytest.fixture
def estimates(annotation):
    rng = np.random.default_rng(1)
    table = perfect_estimates(annotation)
    for name in COLUMNS.values():
        table[name] *= 1 + rng.normal(0, 0.3, len(table))
    table["filling_type"] = rng.integers(0, 4, len(table))
    return table


def cells_of(estimates, annotation, **options):
    errors = error_table(estimates, annotation, **options)
    return cell_table(errors, rng=np.random.default_rng(0)).set_index(["container", "metric"])


def test_values_are_those_of_table_2_inside_their_intervals(annotation, estimates):
    cells = cells_of(estimates, annotation)
    table = container_table(error_table(estimates, annotation)).set_index("container")
    assert len(cells) == 4 * len(METRICS)
    for container in table.index:
        for metric in METRICS:
            assert cells.loc[(container, metric), "value"] == pytest.approx(table.loc[container, metric])
    assert (cells["low"] <= cells["value"]).all()
    assert (cells["value"] <= cells["high"]).all()
    assert cells["protocol"].eq("held-out").all()


def test_interval_of_a_mean_has_the_width_of_its_standard_error(annotation, estimates):
    cells = cells_of(estimates, annotation)
    errors = error_table(estimates, annotation)
    widths = {}
    for container, group in errors.groupby("container"):
        own = group["height_error_percent"].abs()
        widths[container] = 2 * 1.96 * own.std() / math.sqrt(len(own))
        cell = cells.loc[(container, "height_mape")]
        assert cell["high"] - cell["low"] == pytest.approx(widths[container], rel=0.1)
    cell = cells.loc[("Average", "height_mape")]
    together = math.sqrt(sum(width**2 for width in widths.values())) / 3
    assert cell["high"] - cell["low"] == pytest.approx(together, rel=0.1)


def test_every_cell_counts_its_recordings_failures_and_what_is_left_out(annotation, estimates):
    estimates.loc[[0, 3], "status"] = ["failed", "fallback: training mean"]
    estimates.loc[0, ["capacity_ml", "width_top_mm", "width_bottom_mm", "height_mm"]] = math.nan
    estimates.loc[6, "filling_type"] = -1
    estimates.loc[[9, 12, 15], "mass_held_out"] = False
    annotation.loc[18, "height"] = math.nan
    cells = cells_of(estimates, annotation)
    counts = cells[["recordings", "failures", "left_out"]]
    assert counts.loc[("red cup", "capacity_mape")].tolist() == [21, 2, 0]
    assert counts.loc[("red cup", "height_mape")].tolist() == [20, 2, 0]
    assert counts.loc[("red cup", "filling_type_mpf1")].tolist() == [21, 1, 0]
    assert counts.loc[("red cup", "filling_level_mpf1")].tolist() == [21, 0, 0]
    assert counts.loc[("red cup", "mass_mape")].tolist() == [18, 2, 3]
    assert counts.loc[("green glass", "mass_mape")].tolist() == [21, 0, 0]
    assert counts.loc[("Average", "mass_mape")].tolist() == [60, 2, 3]


def test_a_single_recording_has_no_interval_and_neither_has_the_average_over_it():
    annotation = made_annotation(4)
    cells = cells_of(perfect_estimates(annotation), annotation)
    assert cells.loc[("red cup", "height_mape"), ["low", "high"]].tolist() == [0, 0]
    assert (
        cells.loc[[("green glass", "height_mape"), ("Average", "height_mape")], ["low", "high"]].isna().all(axis=None)
    )


def test_an_average_is_compared_over_the_containers_that_both_tables_have(annotation, estimates):
    """Red cup, green glass and cereal box: the paper's average over its nine containers says nothing about them."""
    cells = cells_of(estimates, annotation)
    paper = paper_table_2().set_index("container_id")
    for metric in METRICS:
        average = cells.loc[("Average", metric)]
        expected = paper.loc[[1, 4, 7], metric].mean()
        assert average["published"] == pytest.approx(expected)
        assert average["difference"] == pytest.approx(average["value"] - expected)
        assert average["compared"] == 3
    note = comparison_note(cells.reset_index())
    assert "(held-out: 3 of 3 containers)" in note


def test_a_container_that_the_paper_does_not_have_is_in_the_average_and_not_in_the_comparison(annotation, estimates):
    annotation.loc[annotation["container id"] == 7, "container id"] = 12
    cells = cells_of(estimates, annotation)
    assert cells.loc[("container 12", "capacity_mape"), ["published", "difference"]].isna().all()
    average = cells.loc[("Average", "capacity_mape")]
    common = cells.loc[[("red cup", "capacity_mape"), ("green glass", "capacity_mape")], "value"].mean()
    assert average["value"] != pytest.approx(common)
    assert average["difference"] == pytest.approx(common - (34.2 + 61.8) / 2)
    assert average["compared"] == 2


def test_no_container_in_common_is_no_comparison(annotation, estimates):
    annotation["container id"] += 100
    cells = cells_of(estimates, annotation)
    assert cells[["published", "difference"]].isna().all(axis=None)
    assert "0 of 3 containers" in comparison_note(cells.reset_index())


def test_a_metric_that_lacks_a_container_is_compared_without_it():
    annotation = made_annotation(54)
    annotation["container id"] = annotation["id"] % 9 + 1
    estimates = perfect_estimates(annotation)
    whole = cells_of(estimates, annotation)
    assert comparison_note(whole.reset_index()) == ""
    assert whole.loc[("Average", "capacity_mape"), "published"] == 77.1  # as printed
    estimates.loc[annotation["container id"] == 6, "capacity_ml"] = -1
    cells = cells_of(estimates, annotation)
    without_flute = paper_table_2()["capacity_mape"][[0, 1, 2, 3, 4, 6, 7, 8]].mean()
    assert cells.loc[("Average", "capacity_mape"), "published"] == pytest.approx(without_flute)
    assert cells.loc[("Average", "height_mape"), "published"] == 30.8
    assert "(held-out: 8 of 8 containers)" in comparison_note(cells.reset_index())


def test_each_protocol_is_compared_over_its_own_containers(annotation, estimates):
    estimates["mass_held_out"] = annotation["container id"] == 1
    tables = [cells_of(estimates, annotation, protocol=name) for name in ("held-out", "in-sample")]
    note = comparison_note(pd.concat(tables).reset_index())
    assert note.endswith("Height 3 of 3, Mass 1 of 1 containers; in-sample: 3 of 3 containers).")


def test_same_seed_gives_the_same_intervals(annotation, estimates):
    errors = error_table(estimates, annotation)
    once, again = (cell_table(errors, rng=np.random.default_rng(9), resamples=100) for _ in range(2))
    pd.testing.assert_frame_equal(once, again)


def test_bad_input_is_one_clear_sentence(annotation, estimates):
    errors, rng = error_table(estimates, annotation), np.random.default_rng(0)
    with pytest.raises(ArgumentError, match="resamples must be at least 100, got 10"):
        cell_table(errors, rng=rng, resamples=10)
    with pytest.raises(ArgumentError, match="a recording whose container is known"):
        cell_table(errors[:0], rng=rng)
    with pytest.raises(ArgumentError, match="errors must be an error table"):
        cell_table(errors[["kind"]], rng=rng)
