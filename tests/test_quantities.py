from dataclasses import fields

import pytest

from corsmal.dataset import Annotation
from corsmal.estimation import Estimate
from corsmal.evaluation.submission import SUBMISSION_COLUMNS
from corsmal.quantities import BY_METRIC, BY_NAME, CLASSES, DIMENSIONS, GEOMETRY, MEASURED, QUANTITIES
from corsmal.shape import Dimensions


def test_names_are_fields_of_the_records_that_hold_them():
    assert set(MEASURED) <= {field.name for field in fields(Estimate)}
    assert set(GEOMETRY) <= {field.name for field in fields(Dimensions)}
    assert set(BY_NAME) <= {field.name for field in fields(Annotation)}


def test_table_2_s_metrics_in_the_paper_s_order():
    assert list(BY_METRIC) == [
        "filling_level_mpf1",
        "filling_type_mpf1",
        "capacity_mape",
        "width_top_mape",
        "width_bottom_mape",
        "height_mape",
        "mass_mape",
    ]


def test_groups_are_parts_of_the_whole():
    assert GEOMETRY == ("capacity_ml", "width_top_mm", "width_bottom_mm", "height_mm")
    assert (*CLASSES, *MEASURED) == tuple(quantity.name for quantity in QUANTITIES)
    assert GEOMETRY[1:] == DIMENSIONS


def test_each_has_a_column_of_the_submission():
    assert {quantity.submission_column for quantity in QUANTITIES} <= set(SUBMISSION_COLUMNS)


@pytest.mark.parametrize(("value", "text"), [(520.4, "520 mL"), (1234.0, "1,234 mL"), (None, "unknown")])
def test_a_value_reads_with_its_unit(value, text):
    assert BY_NAME["capacity_ml"].text(value) == text
