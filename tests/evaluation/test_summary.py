import math

import numpy as np
import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import cell_table, error_table, paper_table_2
from corsmal.evaluation.summary import summary
from tests.evaluation.made import made_annotation, perfect_estimates


def summary_of(estimates, annotation):
    errors = error_table(estimates, annotation)
    cells = cell_table(errors, rng=np.random.default_rng(0), resamples=100)
    return {
        (each.group, each.name): each for each in summary(errors, cells, estimates=estimates, annotation=annotation)
    }


def test_a_summary_has_the_averages_beside_the_papers_the_failures_and_the_coverage():
    annotation = made_annotation(42)
    estimates = perfect_estimates(annotation)
    estimates["capacity_ml"] *= 1.1
    estimates.loc[[0, 1], "status"] = "fallback: training mean"
    found = summary_of(estimates, annotation)
    capacity = found["MAPE", "capacity_mape"]
    assert capacity.label == "Capacity"
    assert capacity.value == pytest.approx(10)
    published = paper_table_2().set_index("container_id").loc[[1, 4, 7], "capacity_mape"].mean()
    assert capacity.reference == pytest.approx(published)
    assert capacity.difference == pytest.approx(10 - published)
    assert (capacity.count, capacity.total) == (40, 42)
    assert capacity.is_significant
    assert found["MPF1", "filling_type_mpf1"].value == 100
    failures = found["failures", "All"]
    assert (failures.count, failures.total) == (2, 42)
    assert failures.value == pytest.approx(100 * 2 / 42)
    assert (failures.low, failures.high) == (pytest.approx(1.32, abs=0.01), pytest.approx(15.79, abs=0.01))  # Wilson
    assert found["coverage", "All"].value is None  # no interval in this run


def test_coverage_counts_the_truths_inside_their_intervals():
    annotation = made_annotation(20)
    annotation.loc[19, "height"] = math.nan
    estimates = perfect_estimates(annotation)
    estimates["height_mm_low"], estimates["height_mm_high"] = (estimates["height_mm"] + side for side in (-5, 5))
    estimates.loc[:3, "height_mm_low"] = 1000
    estimates.loc[4, ["height_mm_low", "height_mm_high"]] = None  # a fit of one frame has no interval
    found = summary_of(estimates, annotation)
    height = found["coverage", "height_mm"]
    assert (height.count, height.total, height.reference) == (14, 18, 90)
    assert height.difference == pytest.approx(100 * 14 / 18 - 90)
    assert not height.is_significant
    assert found["coverage", "All"].value == height.value
    assert ("coverage", "capacity_ml") not in found


def test_what_was_not_estimated_has_no_value():
    annotation = made_annotation(6)
    estimates = perfect_estimates(annotation).assign(filling_type=-1)
    assert summary_of(estimates, annotation)["MPF1", "filling_type_mpf1"].value is None


def test_other_tables_are_refused():
    annotation = made_annotation(6)
    with pytest.raises(ArgumentError, match="error_table"):
        summary(annotation, annotation, estimates=annotation, annotation=annotation)
