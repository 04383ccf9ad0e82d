import math

import pandas as pd
import pytest

from corsmal.evaluation import error_table
from corsmal.evaluation.worst import worst_recordings
from tests.evaluation.made import made_annotation, perfect_estimates


@pytest.fixture
def errors():
    annotation = made_annotation(6)
    estimates = perfect_estimates(annotation)
    estimates.loc[1, "capacity_ml"] *= 1.7
    estimates.loc[2, "container_mass_g"] *= 9
    estimates.loc[3, "filling_type"] = 3
    estimates.loc[4, ["capacity_ml", "width_top_mm", "width_bottom_mm", "height_mm"]] = math.nan
    return error_table(estimates, annotation)


def test_the_worst_stand_first_and_one_error_counts_for_100_percent_at_most(errors):
    worst = worst_recordings(errors, count=4)
    assert list(worst.index) == ["000004", "000002", "000003", "000001"]
    assert worst["mean_error"].tolist() == pytest.approx([4 * 100 / 7, 100 / 7, 100 / 7, 10])


def test_of_one_metric_the_largest_errors_stand_first(errors):
    assert list(worst_recordings(errors, metric="capacity_mape").index)[:2] == ["000004", "000001"]
    assert worst_recordings(errors, metric="mass_mape").index[0] == "000002"


def test_what_cannot_be_judged_is_not_among_the_worst(errors):
    errors = errors.assign(
        **{name: False for name in errors if name.endswith("_judged")},
        filling_type_correct=pd.array([pd.NA] * 6, dtype="boolean"),
        filling_level_correct=pd.array([pd.NA] * 6, dtype="boolean"),
    )
    assert worst_recordings(errors).empty
