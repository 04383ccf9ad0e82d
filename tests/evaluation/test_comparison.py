import math

import numpy as np
import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import METRICS, changed_sides, compare_runs, container_table, error_table
from tests.evaluation.made import made_annotation, perfect_estimates


@pytest.fixture
def annotation():
    return made_annotation(210)


def noisy_errors(annotation, seed, *, spread=0.2, right=0.7):
    rng = np.random.default_rng(seed)
    table = perfect_estimates(annotation)
    for name in ("capacity_ml", "width_top_mm", "width_bottom_mm", "height_mm", "container_mass_g"):
        table[name] *= 1 + rng.normal(0, spread, len(table))
    for name, classes in (("filling_type", 4), ("filling_level", 3)):
        wrong = rng.random(len(table)) > right
        table.loc[wrong, name] = rng.integers(-1, classes, wrong.sum())
    return error_table(table, annotation)


def test_values_are_those_of_table_2(annotation):
    first, second = noisy_errors(annotation, 0), noisy_errors(annotation, 1)
    compared = compare_runs(first, second, rng=np.random.default_rng(0), resamples=100)
    assert len(compared) == 4 * len(METRICS)
    by_cell = compared.set_index(["container", "metric"])
    for side, errors in (("first", first), ("second", second)):
        table = container_table(errors).set_index("container")
        for container in table.index:
            for metric in METRICS:
                assert by_cell.loc[(container, metric), side] == pytest.approx(table.loc[container, metric])
    np.testing.assert_allclose(compared["difference"], compared["second"] - compared["first"])
    assert (compared["low"] <= compared["difference"]).all()
    assert (compared["difference"] <= compared["high"]).all()


def test_run_against_itself_has_no_difference(annotation):
    first = noisy_errors(annotation, 0)
    compared = compare_runs(first, first, rng=np.random.default_rng(0), resamples=200)
    assert compared[["difference", "low", "high"]].eq(0).all(axis=None)
    assert compared["verdict"].eq("no significant difference").all()


def test_interval_of_a_mean_has_the_width_of_its_standard_error(annotation):
    first, second = noisy_errors(annotation, 0), noisy_errors(annotation, 1)
    compared = compare_runs(first, second, rng=np.random.default_rng(0), resamples=4000)
    row = compared.set_index(["container", "metric"]).loc[("red cup", "height_mape")]
    own = first["container"] == "red cup"
    paired = second.loc[own, "height_error_percent"].abs() - first.loc[own, "height_error_percent"].abs()
    assert row["high"] - row["low"] == pytest.approx(2 * 1.96 * paired.std() / math.sqrt(own.sum()), rel=0.08)


def test_clear_improvement_is_told_from_luck(annotation):
    bad, good = noisy_errors(annotation, 0, spread=0.4, right=0.3), noisy_errors(annotation, 1, spread=0.1, right=0.95)
    rng = np.random.default_rng(0)
    assert compare_runs(bad, good, rng=rng, resamples=300)["verdict"].eq("better").all()
    assert compare_runs(good, bad, rng=rng, resamples=300)["verdict"].eq("worse").all()
    equals = compare_runs(noisy_errors(annotation, 2), noisy_errors(annotation, 3), rng=rng, resamples=300)
    assert equals["verdict"].eq("no significant difference").mean() > 0.7


def test_same_seed_gives_the_same_intervals(annotation):
    first, second = noisy_errors(annotation, 0), noisy_errors(annotation, 1)
    once, again = (compare_runs(first, second, rng=np.random.default_rng(9), resamples=100) for _ in range(2))
    assert once.equals(again)


def test_only_what_both_runs_have_is_compared(annotation):
    estimates = perfect_estimates(annotation)
    fewer = estimates[:150].drop(columns="container_mass_g")
    fewer.loc[0, "capacity_ml"] = math.nan
    first, second = error_table(estimates, annotation), error_table(fewer, annotation)
    compared = compare_runs(first, second, rng=np.random.default_rng(0), resamples=100)
    assert "mass_mape" not in set(compared["metric"])
    counts = compared.set_index(["container", "metric"])["recordings"]
    assert counts["red cup", "capacity_mape"] == 49
    assert counts["red cup", "height_mape"] == 50
    assert counts["Average", "height_mape"] == 150
    assert counts["red cup", "filling_type_mpf1"] == 50


def test_single_recording_has_no_interval():
    annotation = made_annotation(3)
    estimates = perfect_estimates(annotation)
    worse = estimates.assign(height_mm=2 * estimates["height_mm"])
    compared = compare_runs(
        error_table(estimates, annotation), error_table(worse, annotation), rng=np.random.default_rng(0), resamples=100
    )
    heights = compared[compared["metric"] == "height_mape"]
    assert heights["difference"].tolist() == [100.0] * 4
    assert heights[["low", "high"]].isna().all(axis=None)
    assert heights["verdict"].eq("no significant difference").all()


def test_recordings_that_changed_sides_by_hand():
    annotation = made_annotation(6)
    before, after = perfect_estimates(annotation), perfect_estimates(annotation)
    before["capacity_ml"] *= [1.0, 1.1, 1.3, 1.3, 1.0, 1.2]
    after["capacity_ml"] *= [1.0, 0.9, 1.1, 1.4, math.nan, 0.7]
    before.loc[1, "filling_type"] = 3
    after.loc[2, "filling_level"] = -1
    changed = changed_sides(error_table(before, annotation), error_table(after, annotation))
    rows = changed[["recording_id", "metric", "first", "second", "change"]].to_numpy().tolist()
    assert rows == [
        ["000002", "filling_level_mpf1", "empty", "no estimate", "worse"],
        ["000001", "filling_type_mpf1", "water", "none", "better"],
        ["000002", "capacity_mape", "+30.0 %", "+10.0 %", "better"],
        ["000004", "capacity_mape", "+0.0 %", "no estimate", "worse"],
        ["000005", "capacity_mape", "+20.0 %", "-30.0 %", "worse"],
    ]


def test_nothing_changed_is_an_empty_table_with_the_same_columns():
    annotation = made_annotation(6)
    errors = error_table(perfect_estimates(annotation), annotation)
    changed = changed_sides(errors, errors)
    assert len(changed) == 0
    assert changed.columns.tolist()[:4] == ["recording_id", "container_id", "container", "metric"]
    without_mass = error_table(perfect_estimates(annotation).drop(columns="container_mass_g"), annotation)
    assert len(changed_sides(errors, without_mass)) == 0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda e, rng: compare_runs(e, e, rng=rng, resamples=10), "resamples must be at least 100, got 10"),
        (lambda e, rng: compare_runs(e[:3], e[3:], rng=rng), "no recording of a known container in common"),
        (lambda e, rng: compare_runs(e[["kind"]], e, rng=rng), "first must be an error table"),
        (lambda e, rng: compare_runs(e, 3, rng=rng), "second must be an error table"),
        (lambda e, rng: changed_sides(e, e, threshold_percent=0), "threshold_percent must be positive, got 0"),  # noqa: ARG005
        (lambda e, rng: changed_sides(e[:1], e[1:]), "no recording of a known container in common"),  # noqa: ARG005
    ],
)
def test_bad_input_is_one_clear_sentence(annotation, call, message):
    errors = error_table(perfect_estimates(annotation), annotation)
    with pytest.raises(ArgumentError, match=message):
        call(errors, np.random.default_rng(0))


def test_runs_without_a_quantity_in_common_are_an_error(annotation):
    table = perfect_estimates(annotation)
    runs = [error_table(table[["recording_id", "status", name]], annotation) for name in ("height_mm", "capacity_ml")]
    with pytest.raises(ArgumentError, match="estimates of the same quantity"):
        compare_runs(*runs, rng=np.random.default_rng(0))


def test_runs_are_compared_by_one_protocol(annotation):
    table = perfect_estimates(annotation)
    held_out, shown = error_table(table, annotation), error_table(table, annotation, protocol="in-sample")
    with pytest.raises(ArgumentError, match="by the same protocol, got held-out and in-sample"):
        compare_runs(held_out, shown, rng=np.random.default_rng(0))
    compared = compare_runs(shown, shown, rng=np.random.default_rng(0), resamples=100)
    assert compared["protocol"].eq("in-sample").all()
